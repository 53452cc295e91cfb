//! A camera made ready for culling and drawing: planes, matrices, boxes on the screen.

mod crossing;
mod guard;
#[cfg(test)]
mod tests;

use super::{Bounds, Objects};
use crate::OcclusionError;
use dapple_scene::{Camera, MAX_TEXTURE_SIDE, Projection};
use glam::{DMat4, DVec2, DVec3, DVec4, Mat4, Vec3, Vec4};

pub use crossing::Crossing;

/// Farthest that an eye may be from the objects' origin, metres: squares and cubes of coordinates
/// stay finite in f32.
const MAX_EYE_M: f64 = 1e12;

/// One frame's view of the objects.
#[derive(Clone, Debug)]
pub struct View {
    /// The camera, local space. For parallel rays: the middle of the image on the near plane.
    pub eye: DVec3,
    /// The eye as the device has it: positions are made relative to it, `p - eye_f32`, in f32.
    pub eye_f32: Vec3,
    /// Unit view direction.
    pub forward: DVec3,
    /// Unit vector to the right of the image.
    pub right: DVec3,
    /// Unit vector to the top of the image.
    pub up: DVec3,
    /// Local space to clip space, reversed depth without a far plane (parallel rays: 1 at the near,
    /// 0 at the far plane).
    pub clip: DMat4,
    /// The same for the device, from positions relative to [`Self::eye_f32`]; what rounding the eye
    /// lost is made good here. See [`Self::to_clip_f32`].
    pub clip_f32: Mat4,
    /// Near, left, right, bottom, top planes, local space: `xyz . p + w >= 0` inside, xyz of length 1.
    pub planes: [DVec4; 5],
    /// Columns of the image.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Distance of the near plane from the camera, metres.
    pub near_m: f64,
    /// Whether rays are parallel.
    pub parallel: bool,
    /// From the near to the far plane, metres: infinite but for parallel rays, where it holds all
    /// objects.
    pub range_m: f64,
    /// Half the image's width and height, metres: at distance 1 in front of the eye, or everywhere
    /// for parallel rays.
    pub half_extent: DVec2,
    /// Holds the eye and the part of the near plane that the image shows.
    reach: [DVec3; 2],
}

impl View {
    /// The view of `camera` on an image of `width` x `height` pixels. The near plane lies at
    /// `near_m`.
    ///
    /// # Errors
    /// An image without pixels or larger than [`MAX_TEXTURE_SIDE`], a camera that is not finite or
    /// looks nowhere, an opening outside (0, π), a near plane that is not ahead.
    pub fn new(
        camera: &Camera,
        objects: &Objects,
        width: u32,
        height: u32,
        near_m: f64,
    ) -> Result<Self, OcclusionError> {
        let refuse = |limit: String| {
            Err(OcclusionError::value(format!("camera \"{}\"", camera.name), limit))
        };
        let sides = 1..=MAX_TEXTURE_SIDE;
        if !sides.contains(&width) || !sides.contains(&height) {
            let limit = format!("{width} x {height} pixels, sides must be 1..={MAX_TEXTURE_SIDE}");
            return Err(OcclusionError::value("image", limit));
        }
        if !(near_m > 0.0 && near_m <= MAX_EYE_M) {
            return refuse(format!("near plane at {near_m} m, must be in 0..={MAX_EYE_M:e} m"));
        }
        let position = camera.position - objects.origin;
        if !(position.abs().max_element() <= MAX_EYE_M && position.is_finite()) {
            let limit = format!(
                "position {} m, at most {MAX_EYE_M:e} m from the objects is allowed",
                camera.position
            );
            return refuse(limit);
        }
        let Some((right, up, forward)) = axes(camera) else {
            let Camera { position, target, up, .. } = camera;
            return refuse(format!("looks from {position} to {target}, up {up}: no direction"));
        };
        let aspect = f64::from(width) / f64::from(height);
        let (eye, parallel, half_height) = match camera.projection {
            Projection::Perspective { fov_y_rad } => {
                if !(fov_y_rad > 0.0 && fov_y_rad < std::f64::consts::PI) {
                    return refuse(format!("opening {fov_y_rad} rad is outside (0, pi)"));
                }
                let half = (0.5 * fov_y_rad).tan();
                if 2.0 * half > guard::MAX_PIXEL * f64::from(height) {
                    let limit = format!("opening {fov_y_rad} rad is too wide for {height} rows");
                    return refuse(limit);
                }
                (position, false, half)
            }
            Projection::Orthographic { height_m } => {
                if !(height_m > 0.0 && height_m <= MAX_EYE_M) {
                    return refuse(format!("height {height_m} m, must be in 0..={MAX_EYE_M:e} m"));
                }
                (position + forward * near_m, true, 0.5 * height_m)
            }
        };
        let half_extent = DVec2::new(half_height * aspect, half_height);
        let mut view = Self {
            eye,
            eye_f32: eye.as_vec3(),
            forward,
            right,
            up,
            clip: DMat4::IDENTITY,
            clip_f32: Mat4::IDENTITY,
            planes: [DVec4::ZERO; 5],
            width,
            height,
            near_m,
            parallel,
            range_m: f64::INFINITY,
            half_extent,
            reach: [eye; 2],
        };
        if parallel {
            view.range_m = view.range_over(objects);
        }
        let relative = view.relative_clip();
        view.clip = relative * DMat4::from_translation(-eye);
        let lost = view.eye_f32.as_dvec3() - eye;
        view.clip_f32 = (relative * DMat4::from_translation(lost)).as_mat4();
        view.planes = view.frustum();
        view.reach = view.near_reach();
        Ok(view)
    }

    /// A point of local space in clip space as forms in f32 compute it.
    pub fn to_clip_f32(&self, p: Vec3) -> Vec4 {
        self.clip_f32 * (p - self.eye_f32).extend(1.0)
    }

    /// Distance of the near plane from [`Self::eye`], metres: 0 for parallel rays.
    pub fn near_distance(&self) -> f64 {
        if self.parallel { 0.0 } else { self.near_m }
    }

    /// Reversed depth at `distance` metres from the eye along the view direction.
    pub fn depth(&self, distance: f64) -> f64 {
        if self.parallel { 1.0 - distance / self.range_m } else { self.near_m / distance }
    }

    /// Side of a pixel in metres at `distance` metres from the eye along the view direction.
    pub fn pixel_m(&self, distance: f64) -> f64 {
        let side = 2.0 * self.half_extent.y / f64::from(self.height);
        if self.parallel { side } else { side * distance }
    }

    /// Whether any of `bounds`, grown ([`Self::guarded`]), lies inside all planes; conservative: a
    /// box near an edge of the frustum may pass though it is outside. What passes for a box passes
    /// for all that hold it.
    pub fn sees(&self, bounds: &Bounds) -> bool {
        self.crossing(bounds, Crossing::UNKNOWN).is_some()
    }

    fn sees_grown(&self, bounds: &Bounds) -> bool {
        let grown = self.guarded(bounds);
        let (min, max) = (grown.min.as_dvec3(), grown.max.as_dvec3());
        self.planes.iter().all(|plane| {
            let normal = plane.truncate();
            let furthest = DVec3::select(normal.cmpge(DVec3::ZERO), max, min);
            // The plane itself is known to a few units in the last place of f64.
            let rounding = 1e-14 * (normal.abs().dot(furthest.abs()) + plane.w.abs());
            normal.dot(furthest) + plane.w >= -rounding
        })
    }

    /// Whether the part of the near plane that the image shows, or the eye, is inside or on the
    /// grown box: such a box cannot be asked about, it counts as visible. A box that the near plane
    /// cuts elsewhere can: clipped at the near plane, its faces still cover what they hold.
    pub fn touches(&self, bounds: &Bounds) -> bool {
        if bounds.is_empty() {
            return false;
        }
        let grown = self.guarded(bounds);
        let [low, high] = self.reach;
        grown.min.as_dvec3().cmple(high).all()
            && grown.max.as_dvec3().cmpge(low).all()
            && self.distance(&grown) <= self.near_distance() * (1.0 + 1e-6)
    }

    /// Distance of the nearest point of `bounds` along the view direction, metres, negative behind
    /// the eye: the order of traversal.
    pub fn distance(&self, bounds: &Bounds) -> f64 {
        self.distances(bounds)[0]
    }

    /// Least and greatest distance of `bounds` from the eye along the view direction, metres.
    pub fn distances(&self, bounds: &Bounds) -> [f64; 2] {
        let ahead = self.forward.cmpge(DVec3::ZERO);
        let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
        [DVec3::select(ahead, min, max), DVec3::select(ahead, max, min)]
            .map(|p| (p - self.eye).dot(self.forward))
    }

    /// Distance from the near plane to a far plane behind all objects, with room for the guard band
    /// and so that no depth is 0.
    fn range_over(&self, objects: &Objects) -> f64 {
        let (mut deep, mut wide) = (0.0_f64, 0.0_f64);
        for object in objects.objects.iter().filter(|o| !o.bounds.is_empty()) {
            deep = deep.max(self.distances(&object.bounds)[1]);
            wide = wide.max(self.farthest(&object.bounds));
        }
        1.125 * deep + wide * 2.0_f64.powi(-16) + self.pixel_m(0.0)
    }

    /// Clip space from positions relative to the eye.
    fn relative_clip(&self) -> DMat4 {
        let x = (self.right / self.half_extent.x).extend(0.0);
        let y = (self.up / self.half_extent.y).extend(0.0);
        let (z, w) = if self.parallel {
            ((-self.forward / self.range_m).extend(1.0), DVec4::W)
        } else {
            (DVec4::W * self.near_m, self.forward.extend(0.0))
        };
        DMat4::from_cols(x, y, z, w).transpose()
    }

    fn frustum(&self) -> [DVec4; 5] {
        let plane = |normal: DVec3, offset: f64| {
            let normal = normal.normalize();
            normal.extend(offset - normal.dot(self.eye))
        };
        let side = |axis: DVec3, half: f64| {
            if self.parallel { plane(axis, half) } else { plane(axis + self.forward * half, 0.0) }
        };
        let DVec2 { x, y } = self.half_extent;
        [
            plane(self.forward, -self.near_distance()),
            side(self.right, x),
            side(-self.right, x),
            side(self.up, y),
            side(-self.up, y),
        ]
    }

    fn near_reach(&self) -> [DVec3; 2] {
        let near = self.near_distance();
        let scale = if self.parallel { 1.0 } else { near };
        let across =
            (self.right.abs() * self.half_extent.x + self.up.abs() * self.half_extent.y) * scale;
        let middle = self.eye + self.forward * near;
        let slack = 1e-6 * (across + self.forward.abs() * near);
        let (low, high) = (middle - across, middle + across);
        [low.min(self.eye) - slack, high.max(self.eye) + slack]
    }
}

/// Right, up and forward of a camera's image; none where its vectors do not give them.
fn axes(camera: &Camera) -> Option<(DVec3, DVec3, DVec3)> {
    let forward = (camera.target - camera.position).try_normalize()?;
    let up = camera.up.try_normalize()?;
    let right = forward.cross(up);
    if right.length() < 1e-9 {
        return None;
    }
    let right = right.try_normalize()?;
    Some((right, right.cross(forward), forward))
}
