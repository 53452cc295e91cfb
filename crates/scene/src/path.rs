//! Frames of a camera path.

use crate::{Camera, CameraPath, Projection};

impl CameraPath {
    /// The camera of frame `index` (clamped to the last): frames lie evenly along the sequence of
    /// keys, positions, targets and openings interpolated linearly between them. Projection kind
    /// and name are the earlier key's. `None` for a path without keys.
    pub fn camera(&self, index: u32) -> Option<Camera> {
        let last = self.keys.len().checked_sub(1)?;
        let steps = self.frames.saturating_sub(1);
        let along = f64::from(index.min(steps)) / f64::from(steps.max(1)) * last as f64;
        let key = (along as usize).min(last);
        let t = along - key as f64;
        let (a, b) = (&self.keys[key], &self.keys[(key + 1).min(last)]);
        let projection = match (a.projection, b.projection) {
            (
                Projection::Perspective { fov_y_rad: a },
                Projection::Perspective { fov_y_rad: b },
            ) => Projection::Perspective { fov_y_rad: a + (b - a) * t },
            (
                Projection::Orthographic { height_m: a },
                Projection::Orthographic { height_m: b },
            ) => Projection::Orthographic { height_m: a + (b - a) * t },
            (kept, _) => kept,
        };
        Some(Camera {
            name: a.name.clone(),
            position: a.position.lerp(b.position, t),
            target: a.target.lerp(b.target, t),
            up: a.up.lerp(b.up, t),
            projection,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn key(x: f64) -> Camera {
        Camera {
            name: format!("{x}"),
            position: DVec3::new(x, 0.0, 0.0),
            target: DVec3::new(x, 0.0, -1.0),
            up: DVec3::Y,
            projection: Projection::Perspective { fov_y_rad: 1.0 },
        }
    }

    #[test]
    fn frames_lie_evenly_along_the_keys() {
        let path =
            CameraPath { name: "p".into(), keys: vec![key(0.0), key(2.0), key(3.0)], frames: 5 };
        let x = |i| path.camera(i).map(|c| c.position.x);
        let expected = [0.0, 1.0, 2.0, 2.5, 3.0];
        for (i, e) in expected.into_iter().enumerate() {
            assert_eq!(x(i as u32), Some(e));
        }
        assert_eq!(x(99), Some(3.0), "beyond the end: the last");
        let one = CameraPath { frames: 1, ..path.clone() };
        assert_eq!(one.camera(0).map(|c| c.position.x), Some(0.0));
        assert!(CameraPath { keys: vec![], ..path }.camera(0).is_none());
    }
}
