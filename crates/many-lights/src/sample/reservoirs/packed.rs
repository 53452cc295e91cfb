//! What the f32 forms hold, on processors and devices alike.

use super::{DEPTH_SHARE, LEAST_COSINE, NONE};
use crate::{Eye, Point, light::luminance_f32};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// A light that stands for all that were looked at. 12 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct Reservoir {
    /// [`NONE`] where none gives anything.
    pub light: u32,
    /// Candidates it stands for: M.
    pub count: u32,
    /// W: what one over the probability of the light is estimated as.
    pub weight: f32,
}

/// An eye in f32. 64 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct PackedEye {
    /// Metres, local.
    pub position: Vec3,
    /// 1 where rays meet in the position.
    pub perspective: u32,
    /// Unit length.
    pub forward: Vec3,
    /// Columns of its image.
    pub width: u32,
    /// [`Eye::right`] over its squared length.
    pub right: Vec3,
    /// Rows of its image.
    pub height: u32,
    /// [`Eye::up`] over its squared length.
    pub up: Vec3,
    /// Unused.
    pub pad: u32,
}

impl Reservoir {
    #[inline(always)]
    pub fn empty(count: u32) -> Self {
        Self { light: NONE, count, weight: 0.0 }
    }

    /// Emptied where the weight overflowed.
    #[inline(always)]
    pub fn of(light: u32, count: u32, weight: f32) -> Self {
        if weight <= f32::MAX { Self { light, count, weight } } else { Self::empty(count) }
    }

    /// Whether it can be merged: one that went wrong, however it did, ends here.
    #[inline(always)]
    pub fn is_sound(&self, lights: usize) -> bool {
        self.weight >= 0.0
            && self.weight <= f32::MAX
            && (self.weight == 0.0 || (self.light as usize) < lights)
    }
}

impl PackedEye {
    /// The eye of an image of width x height.
    pub fn new(eye: &Eye, [width, height]: [u32; 2]) -> Self {
        Self {
            position: eye.position.as_vec3(),
            perspective: u32::from(eye.perspective),
            forward: eye.forward.as_vec3(),
            width,
            right: (eye.right / eye.right.length_squared()).as_vec3(),
            height,
            up: (eye.up / eye.up.length_squared()).as_vec3(),
            pad: 0,
        }
    }

    /// Where a point was in the image, as the number of the pixel.
    #[inline]
    pub fn pixel_of(&self, point: &Point) -> Option<usize> {
        let to_point = point.position - self.position;
        let depth = to_point.dot(self.forward);
        let scale = if self.perspective != 0 { depth } else { 1.0 };
        if scale <= 0.0 {
            return None;
        }
        let x = 0.5 + 0.5 * (to_point.dot(self.right) / scale);
        let y = 0.5 - 0.5 * (to_point.dot(self.up) / scale);
        if !(x >= 0.0 && y >= 0.0 && x < 1.0 && y < 1.0) {
            return None;
        }
        let column = ((x * self.width as f32) as u32).min(self.width - 1);
        let row = ((y * self.height as f32) as u32).min(self.height - 1);
        Some((row * self.width + column) as usize)
    }

    /// Whether two points may be of one surface, as the eye sees them.
    #[inline]
    pub fn is_alike(&self, point: &Point, other: &Point) -> bool {
        if !other.is_there() {
            return false;
        }
        let here = (point.position - self.position).dot(self.forward);
        let there = (other.position - self.position).dot(self.forward);
        point.normal.dot(other.normal) >= LEAST_COSINE as f32
            && (there - here).abs() <= DEPTH_SHARE as f32 * here.abs()
    }
}

/// Luminance (Rec. 709); 0 where it is no finite number.
#[inline(always)]
pub(crate) fn target_of(radiance: Vec3) -> f32 {
    let value = luminance_f32(radiance);
    if value <= f32::MAX { value } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::luminance;

    #[test]
    fn luminance_is_the_one_of_the_exact_form() {
        for rgb in [Vec3::X, Vec3::Y, Vec3::Z] {
            assert_eq!(target_of(rgb), luminance(rgb.as_dvec3()) as f32);
        }
        assert_eq!(target_of(Vec3::splat(f32::INFINITY)), 0.0);
        assert_eq!(target_of(Vec3::splat(f32::NAN)), 0.0);
    }

    #[test]
    fn reservoirs_that_went_wrong_are_not_merged() {
        let sound = Reservoir::of(2, 8, 1.0);
        assert!(sound.is_sound(3) && Reservoir::empty(8).is_sound(3));
        for weight in [f32::NAN, f32::INFINITY, -1.0, f32::NEG_INFINITY] {
            assert!(!Reservoir { weight, ..sound }.is_sound(3));
        }
        assert!(!sound.is_sound(2));
        assert_eq!(Reservoir::of(2, 8, f32::INFINITY), Reservoir::empty(8));
        assert_eq!(Reservoir::of(2, 8, f32::NAN), Reservoir::empty(8));
    }
}
