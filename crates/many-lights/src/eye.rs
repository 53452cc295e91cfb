//! Where an image is seen from.

use dapple_scene::{Camera, Projection};
use glam::{DVec2, DVec3};

/// A camera in local space, made for projecting points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    /// Metres, relative to the world's origin.
    pub position: DVec3,
    /// Unit length.
    pub forward: DVec3,
    /// From the middle of the image to its right border at distance 1 (or of a parallel image).
    pub right: DVec3,
    /// From the middle of the image to its upper border.
    pub up: DVec3,
    /// Whether rays meet in the position.
    pub perspective: bool,
}

impl Eye {
    /// The eye of a camera whose image is `aspect` times as wide as high.
    pub fn new(camera: &Camera, origin: DVec3, aspect: f64) -> Self {
        let forward = (camera.target - camera.position).normalize();
        let right = forward.cross(camera.up).normalize();
        let up = right.cross(forward);
        let (half_height, perspective) = match camera.projection {
            Projection::Perspective { fov_y_rad } => ((0.5 * fov_y_rad).tan(), true),
            Projection::Orthographic { height_m } => (0.5 * height_m, false),
        };
        Self {
            position: camera.position - origin,
            forward,
            right: right * (half_height * aspect),
            up: up * half_height,
            perspective,
        }
    }

    /// Where a point lies in the image, both coordinates in 0..=1 with the origin top left where it
    /// is inside, and its distance along the view axis. `None` behind a perspective eye.
    pub fn project(&self, point: DVec3) -> Option<(DVec2, f64)> {
        let to_point = point - self.position;
        let depth = to_point.dot(self.forward);
        let scale = if self.perspective { depth } else { 1.0 };
        if self.perspective && depth <= 0.0 {
            return None;
        }
        let x = to_point.dot(self.right) / (self.right.length_squared() * scale);
        let y = to_point.dot(self.up) / (self.up.length_squared() * scale);
        Some((DVec2::new(0.5 + 0.5 * x, 0.5 - 0.5 * y), depth))
    }
}
