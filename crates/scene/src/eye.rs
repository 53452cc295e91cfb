//! A view placed by hand: `eye:X,Y,Z,TX,TY,TZ`, a camera at (X, Y, Z) that looks at (TX, TY, TZ).

use crate::{Camera, MAX_COORDINATE_M};
use glam::DVec3;
use std::{fmt, str::FromStr};

/// What stands before the numbers.
const PREFIX: &str = "eye:";

/// An axis steeper than this counts as vertical: the sine of its angle with the world's up axis.
/// A valid camera needs more than 1e-6 (up is then not along the view).
const VERTICAL: f64 = 1e-3;

/// Where a camera stands and what it looks at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    /// World space, metres.
    pub position: DVec3,
    /// World space, metres; not `position`.
    pub target: DVec3,
}

/// A view that begins like an eye and is none.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "view `{view}`: {what}; expected eye:X,Y,Z,TX,TY,TZ, a place and another place to look at, in \
     metres, each number in -1e9..=1e9"
)]
pub struct EyeError {
    /// The view as given.
    pub view: String,
    /// What does not fit.
    pub what: String,
}

impl FromStr for Eye {
    type Err = EyeError;

    fn from_str(view: &str) -> Result<Self, EyeError> {
        let error = |what: String| EyeError { view: view.into(), what };
        let numbers = view
            .strip_prefix(PREFIX)
            .ok_or_else(|| error(format!("it does not begin with {PREFIX}")))?;
        let parts: Vec<&str> = numbers.split(',').collect();
        if parts.len() != 6 {
            return Err(error(format!("it has {} numbers, not 6", parts.len())));
        }
        let mut values = [0.0; 6];
        for ((value, text), name) in
            values.iter_mut().zip(parts).zip(["X", "Y", "Z", "TX", "TY", "TZ"])
        {
            let limits = -MAX_COORDINATE_M..=MAX_COORDINATE_M;
            let number = text.trim().parse().ok().filter(|v| limits.contains(v));
            *value = number.ok_or_else(|| error(format!("its {name} is `{text}`")))?;
        }
        let [x, y, z, tx, ty, tz] = values;
        let eye = Self { position: DVec3::new(x, y, z), target: DVec3::new(tx, ty, tz) };
        if (eye.target - eye.position).try_normalize().is_none() {
            return Err(error("it looks at its own place".into()));
        }
        Ok(eye)
    }
}

impl fmt::Display for Eye {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (p, t) = (self.position, self.target);
        write!(f, "{PREFIX}{},{},{},{},{},{}", p.x, p.y, p.z, t.x, t.y, t.z)
    }
}

impl Eye {
    /// Whether a view's name asks for an eye, well formed or not.
    pub fn is_meant(view: &str) -> bool {
        view.starts_with(PREFIX)
    }

    /// A camera there, with the projection of `like`. Up is y, or z where the view is vertical.
    #[must_use]
    pub fn camera(&self, like: &Camera) -> Camera {
        let forward = (self.target - self.position).normalize_or(DVec3::NEG_Z);
        let vertical = forward.cross(DVec3::Y).length() <= VERTICAL;
        Camera {
            name: self.to_string(),
            position: self.position,
            target: self.target,
            up: if vertical { DVec3::Z } else { DVec3::Y },
            projection: like.projection,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Projection;

    fn like() -> Camera {
        crate::generate::by_name("cube", 0).unwrap().cameras[0].clone()
    }

    #[test]
    fn a_camera_stands_where_it_is_told_and_looks_at_its_target() {
        let eye: Eye = "eye:0, 6,-13,0,1.5,0".parse().unwrap();
        let camera = eye.camera(&like());
        assert_eq!(camera.position, DVec3::new(0.0, 6.0, -13.0));
        assert_eq!((camera.name.as_str(), camera.up), ("eye:0,6,-13,0,1.5,0", DVec3::Y));
        let Projection::Perspective { fov_y_rad } = camera.projection else {
            panic!("perspective")
        };
        assert_eq!(fov_y_rad, 36.0_f64.to_radians());
        let (origin, direction) = camera.ray(0.5, 0.5, 1.5);
        assert_eq!(origin, camera.position);
        let expected = DVec3::new(0.0, -4.5, 13.0).normalize();
        assert!(direction.distance(expected) < 1e-12);
    }

    #[test]
    fn vertical_views_have_z_up_and_every_view_makes_a_valid_camera() {
        for view in [
            "eye:1,5,1,1,0,1",
            "eye:1,-5,1,1,0,1",
            "eye:0,5,0,0.00000001,0,0",
            "eye:0,5,0,0.01,0,0",
        ] {
            let eye: Eye = view.parse().unwrap();
            let mut scene = crate::generate::by_name("cube", 0).unwrap();
            scene.cameras = vec![eye.camera(&like())];
            scene.validate().unwrap();
            let vertical = view != "eye:0,5,0,0.01,0,0";
            assert_eq!(scene.cameras[0].up == DVec3::Z, vertical, "{view}");
            assert!(scene.cameras[0].ray(0.2, 0.3, 1.5).1.is_finite());
        }
    }

    #[test]
    fn views_are_read_back_and_bad_ones_name_the_form_and_the_limits() {
        for view in ["eye:0,6,13,0,1,0", "eye:-1.5,0,1e9,0.1,-1e-7,3"] {
            let eye: Eye = view.parse().unwrap();
            assert_eq!(eye.to_string().parse(), Ok(eye));
        }
        for (view, what) in [
            ("eye:", "1 numbers"),
            ("eye:1,2,3", "3 numbers"),
            ("eye:1,2,3,4,5,6,7", "7 numbers"),
            ("eye:x,0,0,1,1,1", "X is `x`"),
            ("eye:0,NaN,0,1,1,1", "Y is `NaN`"),
            ("eye:0,0,0,1,1,inf", "TZ is `inf`"),
            ("eye:0,0,0,1,2e9,1", "TY is `2e9`"),
            ("eye:1,2,3,1,2,3", "own place"),
            ("orbit:0,0,1", "does not begin"),
        ] {
            let error = view.parse::<Eye>().unwrap_err().to_string();
            assert!(error.contains(what) && error.contains(view), "{error}");
            assert!(error.contains("eye:X,Y,Z,TX,TY,TZ") && error.contains("1e9"), "{error}");
        }
        assert!(Eye::is_meant("eye:rubbish") && !Eye::is_meant("orbit:0,0,1"));
    }
}
