//! A camera made ready for culling and drawing: planes, matrices, boxes on the screen.

use super::{Bounds, Objects};
use crate::OcclusionError;
use dapple_scene::Camera;
use glam::{DMat4, DVec3, DVec4, Mat4, Vec3};

/// One frame's view of the objects.
#[derive(Clone, Debug)]
pub struct View {
    /// The camera, local space. For parallel rays: a point on the near plane.
    pub eye: DVec3,
    /// Unit view direction.
    pub forward: DVec3,
    /// Local space to clip space, reversed depth without a far plane (parallel rays: 1 at the near,
    /// 0 at the far plane).
    pub clip: DMat4,
    /// The same for the device.
    pub clip_f32: Mat4,
    /// Near, left, right, bottom, top planes, local space: `xyz . p + w >= 0` inside, xyz of length 1.
    pub planes: [DVec4; 5],
    /// Columns of the image.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Distance of the near plane, metres.
    pub near_m: f64,
}

impl View {
    /// The view of `camera` on an image of `width` x `height` pixels. The near plane lies at
    /// `near_m`.
    ///
    /// # Errors
    /// An image without pixels, or a camera that looks nowhere.
    pub fn new(
        camera: &Camera,
        objects: &Objects,
        width: u32,
        height: u32,
        near_m: f64,
    ) -> Result<Self, OcclusionError> {
        let _ = (camera, objects, width, height, near_m);
        Err(OcclusionError::value("view", "not yet"))
    }

    /// Whether any of `bounds` lies inside all planes; conservative: a box near an edge of the
    /// frustum may pass though it is outside.
    pub fn sees(&self, bounds: &Bounds) -> bool {
        let _ = bounds;
        true
    }

    /// Whether the near plane cuts the grown box or the eye is inside it: such a box cannot be asked
    /// about, it counts as visible.
    pub fn touches(&self, bounds: &Bounds) -> bool {
        let _ = bounds;
        true
    }

    /// The box grown by the guard band: half a sub-pixel step of rasterisers at its farthest corner
    /// and the rounding of f32 positions and depths there. Everything inside `bounds` that covers a
    /// pixel's centre on any form is covered by the grown box, nearer.
    #[must_use]
    pub fn guarded(&self, bounds: &Bounds) -> Bounds {
        *bounds
    }

    /// Distance of the nearest point of `bounds` along the view direction, metres, negative behind
    /// the eye: the order of traversal.
    pub fn distance(&self, bounds: &Bounds) -> f64 {
        let forward = self.forward.as_vec3();
        let nearest =
            Vec3::select(forward.cmpge(Vec3::ZERO), bounds.min, bounds.max).as_dvec3() - self.eye;
        nearest.dot(self.forward)
    }
}
