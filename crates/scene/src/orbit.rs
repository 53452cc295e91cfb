//! A view turned from another one: `orbit:AZIMUTH,ELEVATION,DISTANCE`.
//!
//! The camera is moved as a whole about a centre, by a rotation and a scaling, so that the centre
//! keeps its place in the image: first raised about the camera's own horizontal axis, then turned
//! about the world's up axis, then moved away along the line from the centre.

use crate::{Camera, Projection};
use glam::{DQuat, DVec3};
use std::{fmt, ops::RangeInclusive, str::FromStr};

/// What stands before the numbers.
const PREFIX: &str = "orbit:";

/// Least and greatest azimuth, degrees.
const AZIMUTH_DEG: RangeInclusive<f64> = -360.0..=360.0;

/// Least and greatest elevation that may be asked for, degrees.
const ELEVATION_DEG: RangeInclusive<f64> = -180.0..=180.0;

/// Least and greatest factor of the distance.
const DISTANCE: RangeInclusive<f64> = 0.01..=100.0;

/// An orbit raises or lowers a camera no further than this from the horizon, degrees: at a pole
/// turning would only spin the image, beyond it the image would stand on its head.
pub const HIGHEST_DEG: f64 = 89.0;

/// How a camera is moved about a centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// Turn about the world's up axis, degrees in -360..=360, counter-clockwise seen from above.
    pub azimuth_deg: f64,
    /// Added to the camera's elevation over the centre, degrees in -180..=180; the sum is clamped
    /// to [`HIGHEST_DEG`] either way.
    pub elevation_deg: f64,
    /// Factor of the distance to the centre, in 0.01..=100; of the image's height too where rays
    /// are parallel, as distance alone would change nothing there.
    pub distance: f64,
}

/// A view that begins like an orbit and is none.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "view `{view}`: {what}; expected orbit:AZIMUTH,ELEVATION,DISTANCE with an azimuth in \
     -360..=360 degrees, an elevation in -180..=180 degrees and a distance factor in 0.01..=100"
)]
pub struct OrbitError {
    /// The view as given.
    pub view: String,
    /// What does not fit.
    pub what: String,
}

impl FromStr for Orbit {
    type Err = OrbitError;

    fn from_str(view: &str) -> Result<Self, OrbitError> {
        let error = |what: String| OrbitError { view: view.into(), what };
        let numbers = view
            .strip_prefix(PREFIX)
            .ok_or_else(|| error(format!("it does not begin with {PREFIX}")))?;
        let parts: Vec<&str> = numbers.split(',').collect();
        let [azimuth, elevation, distance] = parts[..] else {
            return Err(error(format!("it has {} numbers, not 3", parts.len())));
        };
        let number = |name: &str, text: &str, allowed: &RangeInclusive<f64>| {
            let value = text.trim().parse().ok().filter(|v| allowed.contains(v));
            value.ok_or_else(|| error(format!("its {name} is `{text}`")))
        };
        Ok(Self {
            azimuth_deg: number("azimuth", azimuth, &AZIMUTH_DEG)?,
            elevation_deg: number("elevation", elevation, &ELEVATION_DEG)?,
            distance: number("distance", distance, &DISTANCE)?,
        })
    }
}

impl fmt::Display for Orbit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{PREFIX}{},{},{}", self.azimuth_deg, self.elevation_deg, self.distance)
    }
}

impl Orbit {
    /// The camera itself.
    pub const NONE: Self = Self { azimuth_deg: 0.0, elevation_deg: 0.0, distance: 1.0 };

    /// Whether a view's name asks for an orbit, well formed or not.
    pub fn is_meant(view: &str) -> bool {
        view.starts_with(PREFIX)
    }

    /// `camera` moved about `centre`, named after the orbit. [`Orbit::NONE`] leaves every number
    /// as it is, bit for bit.
    #[must_use]
    pub fn turn(&self, camera: &Camera, centre: DVec3) -> Camera {
        let name = self.to_string();
        if *self == Self::NONE {
            return Camera { name, ..camera.clone() };
        }
        let rotation = self.rotation(camera, centre);
        let about = |point: DVec3| centre + rotation * (point - centre) * self.distance;
        Camera {
            name,
            position: about(camera.position),
            target: about(camera.target),
            up: rotation * camera.up,
            projection: match camera.projection {
                Projection::Orthographic { height_m } => {
                    Projection::Orthographic { height_m: height_m * self.distance }
                }
                perspective @ Projection::Perspective { .. } => perspective,
            },
        }
    }

    fn rotation(&self, camera: &Camera, centre: DVec3) -> DQuat {
        let up = DVec3::Y;
        let turned = DQuat::from_axis_angle(up, self.azimuth_deg.to_radians());
        // Seen from the centre; a camera at the centre has no elevation and looks about.
        let away = (camera.position - centre).normalize_or(camera.position - camera.target);
        let away = away.normalize_or_zero();
        let now_deg = away.dot(up).clamp(-1.0, 1.0).asin().to_degrees();
        let highest = HIGHEST_DEG.max(now_deg.abs());
        let wanted_deg = (now_deg + self.elevation_deg).clamp(-highest, highest);
        // Straight above the centre the camera's own right hand says where the horizon is.
        let right = (camera.target - camera.position).cross(camera.up).normalize_or(DVec3::X);
        let axis = up.cross(away).try_normalize().unwrap_or(right);
        // Rotating about `up x away` by a positive angle lowers the camera.
        let raised = DQuat::from_axis_angle(axis, (now_deg - wanted_deg).to_radians());
        turned * raised
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(position: DVec3, target: DVec3, up: DVec3) -> Camera {
        let projection = Projection::Perspective { fov_y_rad: 0.8 };
        Camera { name: "front".into(), position, target, up, projection }
    }

    fn usual() -> Camera {
        camera(DVec3::new(3.0, 2.1, 0.7), DVec3::new(0.1, 0.3, 0.2), DVec3::Y)
    }

    const CENTRE: DVec3 = DVec3::new(0.2, 0.5, -0.4);

    fn turn(camera: &Camera, azimuth_deg: f64, elevation_deg: f64, distance: f64) -> Camera {
        Orbit { azimuth_deg, elevation_deg, distance }.turn(camera, CENTRE)
    }

    fn numbers(c: &Camera) -> [[f64; 3]; 3] {
        [c.position, c.target, c.up].map(Into::into)
    }

    fn elevation_deg(c: &Camera) -> f64 {
        (c.position - CENTRE).normalize().y.asin().to_degrees()
    }

    fn close(a: DVec3, b: DVec3) -> bool {
        a.distance(b) <= 1e-12
    }

    #[test]
    fn no_turn_is_the_camera_itself_bit_for_bit_and_a_full_turn_nearly() {
        let c = usual();
        let same = turn(&c, 0.0, 0.0, 1.0);
        assert_eq!(
            numbers(&same).map(|v| v.map(f64::to_bits)),
            numbers(&c).map(|v| v.map(f64::to_bits))
        );
        assert_eq!(same.name, "orbit:0,0,1");
        for azimuth in [360.0, -360.0] {
            let full = turn(&c, azimuth, 0.0, 1.0);
            assert!(close(full.position, c.position) && close(full.target, c.target));
            assert!(close(full.up, c.up));
        }
    }

    #[test]
    fn a_quarter_turn_and_a_raise_are_those_of_hand() {
        let c = camera(CENTRE + DVec3::Z * 2.0, CENTRE, DVec3::Y);
        // Counter-clockwise seen from above: from +z to +x.
        assert!(close(turn(&c, 90.0, 0.0, 1.0).position, CENTRE + DVec3::X * 2.0));
        let raised = turn(&c, 0.0, 30.0, 1.0).position - CENTRE;
        assert!(close(raised, DVec3::new(0.0, 1.0, 3.0_f64.sqrt())), "{raised}");
        let both = turn(&c, 90.0, 30.0, 1.0).position - CENTRE;
        assert!(close(both, DVec3::new(3.0_f64.sqrt(), 1.0, 0.0)), "{both}");
    }

    #[test]
    fn distance_2_doubles_and_the_centre_keeps_its_place_in_the_image() {
        let c = usual();
        let cosine = |c: &Camera| {
            let forward = (c.target - c.position).normalize();
            forward.dot((CENTRE - c.position).normalize())
        };
        for orbit in [(0.0, 0.0, 2.0), (40.0, 20.0, 2.0), (-100.0, -15.0, 2.0)] {
            let moved = turn(&c, orbit.0, orbit.1, orbit.2);
            let ratio = moved.position.distance(CENTRE) / c.position.distance(CENTRE);
            assert!((ratio - 2.0).abs() < 1e-12);
            assert!((cosine(&moved) - cosine(&c)).abs() < 1e-12);
        }
        let flat = Camera { projection: Projection::Orthographic { height_m: 3.0 }, ..c };
        let Projection::Orthographic { height_m } = turn(&flat, 0.0, 0.0, 2.0).projection else {
            panic!("still parallel");
        };
        assert_eq!(height_m, 6.0);
    }

    #[test]
    fn elevation_adds_up_and_stops_short_of_the_poles() {
        let c = usual();
        let now = elevation_deg(&c);
        assert!((elevation_deg(&turn(&c, 77.0, 10.0, 1.0)) - now - 10.0).abs() < 1e-9);
        for (asked, found) in [(90.0, HIGHEST_DEG), (180.0, HIGHEST_DEG), (-180.0, -HIGHEST_DEG)] {
            let moved = turn(&c, 10.0, asked, 1.0);
            assert!((elevation_deg(&moved) - found).abs() < 1e-6, "{}", elevation_deg(&moved));
            // A ray can still be cast: up is not along the view.
            assert!(moved.ray(0.2, 0.3, 1.5).1.is_finite());
        }
    }

    #[test]
    fn a_camera_straight_above_can_be_turned_and_lowered() {
        let above = camera(CENTRE + DVec3::Y * 5.0, CENTRE, DVec3::NEG_Z);
        let moved = turn(&above, 90.0, -60.0, 1.0);
        assert!((elevation_deg(&moved) - 30.0).abs() < 1e-9, "{}", elevation_deg(&moved));
        assert!(moved.ray(0.5, 0.5, 1.0).1.is_finite());
        // Its image's top was north: lowered, it looks north, and then was turned to the west.
        let forward = (moved.target - moved.position).normalize();
        assert!(forward.x < -0.8 && forward.z.abs() < 1e-9, "{forward}");
        let still = turn(&above, 90.0, 0.0, 1.0);
        assert!(close(still.position, above.position) && close(still.up, DVec3::NEG_X));
    }

    #[test]
    fn a_camera_at_the_centre_looks_about() {
        let inside = camera(CENTRE, CENTRE + DVec3::NEG_Z, DVec3::Y);
        let moved = turn(&inside, 90.0, 0.0, 3.0);
        assert_eq!(moved.position, CENTRE);
        assert!(close((moved.target - moved.position).normalize(), DVec3::NEG_X));
    }

    #[test]
    fn views_are_read_back_and_bad_ones_name_the_form_and_the_limits() {
        for (view, orbit) in [
            ("orbit:30,10,1", [30.0, 10.0, 1.0]),
            ("orbit:-45.5, 0, 0.5", [-45.5, 0.0, 0.5]),
            ("orbit:360,-180,100", [360.0, -180.0, 100.0]),
        ] {
            let read: Orbit = view.parse().unwrap();
            assert_eq!([read.azimuth_deg, read.elevation_deg, read.distance], orbit);
            assert_eq!(read.to_string().parse(), Ok(read));
        }
        for (view, what) in [
            ("orbit:", "1 numbers"),
            ("orbit:1,2", "2 numbers"),
            ("orbit:1,2,3,4", "4 numbers"),
            ("orbit:x,0,1", "azimuth is `x`"),
            ("orbit:NaN,0,1", "azimuth is `NaN`"),
            ("orbit:361,0,1", "azimuth is `361`"),
            ("orbit:0,inf,1", "elevation is `inf`"),
            ("orbit:0,0,0", "distance is `0`"),
            ("orbit:0,0,101", "distance is `101`"),
            ("front", "does not begin"),
        ] {
            let error = view.parse::<Orbit>().unwrap_err().to_string();
            assert!(error.contains(what), "{error}");
            assert!(error.contains("orbit:AZIMUTH,ELEVATION,DISTANCE"), "{error}");
            assert!(error.contains("0.01..=100") && error.contains(view), "{error}");
        }
        assert!(Orbit::is_meant("orbit:rubbish") && !Orbit::is_meant("front"));
    }
}
