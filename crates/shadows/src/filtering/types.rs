//! What the filters read and report.

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use super::FilterError;

/// A light's depth map.
///
/// Row-major, top row first, `width * height` depths. Depth is linear along the light's axis,
/// 0 at the near plane, 1 at the far plane; 1 also marks a texel that nothing covers.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthMap {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Linear depths in 0..=1.
    pub depths: Vec<f32>,
}

impl DepthMap {
    /// Checks size and every depth.
    ///
    /// # Errors
    /// [`FilterError::EmptyMap`], [`FilterError::MapLength`], [`FilterError::Depth`] (NaN,
    /// infinite or outside 0..=1).
    pub fn check(&self) -> Result<(), FilterError> {
        self.check_size(self.width, self.height)?;
        match self.depths.par_iter().position_first(|z| !(0.0..=1.0).contains(z)) {
            Some(texel) => Err(FilterError::Depth { texel, depth: self.depths[texel] }),
            None => Ok(()),
        }
    }

    /// Checks that the map has `width` x `height` depths, without looking at them.
    pub(crate) fn check_size(&self, width: u32, height: u32) -> Result<(), FilterError> {
        if self.width == 0 || self.height == 0 {
            return Err(FilterError::EmptyMap { width: self.width, height: self.height });
        }
        let texels = self.width as usize * self.height as usize;
        if self.depths.len() != texels {
            return Err(FilterError::MapLength { expected: texels, actual: self.depths.len() });
        }
        if self.width != width || self.height != height {
            return Err(FilterError::MapSize {
                expected: (width, height),
                actual: (self.width, self.height),
            });
        }
        Ok(())
    }
}

/// A point to be shaded, in the map's coordinates.
///
/// It is outside the map, and therefore lit, when `valid` is 0, when `u` or `v` leaves 0..=1 or
/// when `z` is not finite. Non-finite gradients count as 0.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Receiver {
    /// Map coordinate to the right, 0..=1.
    pub u: f32,
    /// Map coordinate downwards, 0..=1.
    pub v: f32,
    /// Linear depth, 0 near plane, 1 far plane.
    pub z: f32,
    /// 1 where there is a receiver, 0 where there is none.
    pub valid: f32,
    /// Slope of the receiver's plane: depth per unit of `u`.
    pub dz_du: f32,
    /// Slope of the receiver's plane: depth per unit of `v`.
    pub dz_dv: f32,
    /// Fills the struct to 32 bytes.
    pub _pad: [f32; 2],
}

impl Receiver {
    /// A receiver at (`u`, `v`) and depth `z` whose plane faces the light.
    #[must_use]
    pub fn new(u: f32, v: f32, z: f32) -> Self {
        Self { u, v, z, valid: 1.0, dz_du: 0.0, dz_dv: 0.0, _pad: [0.0; 2] }
    }

    /// The same receiver on a plane of the given slopes (depth per unit of map coordinate).
    #[must_use]
    pub fn with_slope(self, dz_du: f32, dz_dv: f32) -> Self {
        Self { dz_du, dz_dv, ..self }
    }

    /// Whether the map says anything about this receiver.
    #[must_use]
    pub fn in_map(&self) -> bool {
        self.valid != 0.0
            && (0.0..=1.0).contains(&self.u)
            && (0.0..=1.0).contains(&self.v)
            && self.z.is_finite()
    }
}

/// Work of one frame (pack, two filter passes, shade), independent of the machine.
///
/// A texel counts with all its channels: `texels_fetched` is what the kernels ask for, the bytes
/// say how wide a texel is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Texels read by all stages: `prefilter_texels + shade_texels`.
    pub texels_fetched: u64,
    /// Texels read by pack and the two filter passes.
    pub prefilter_texels: u64,
    /// Texels read by shade.
    pub shade_texels: u64,
    /// Bytes read by all stages, receivers included.
    pub bytes_read: u64,
    /// Bytes written by all stages, visibilities included.
    pub bytes_written: u64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn receiver_is_32_bytes() {
        assert_eq!(size_of::<Receiver>(), 32);
    }

    #[test]
    fn map_check_names_the_first_bad_depth() {
        let mut map = DepthMap { width: 2, height: 2, depths: vec![0.0, 1.0, 0.5, 0.5] };
        assert!(map.check().is_ok());
        for bad in [f32::NAN, -1e-3, 1.001, f32::INFINITY] {
            map.depths[2] = bad;
            assert!(matches!(map.check(), Err(FilterError::Depth { texel: 2, .. })));
        }
        map.depths.pop();
        assert!(matches!(map.check(), Err(FilterError::MapLength { expected: 4, actual: 3 })));
    }

    #[test]
    fn receivers_outside_the_map_are_known() {
        assert!(Receiver::new(0.0, 1.0, 0.3).in_map());
        assert!(!Receiver::new(-0.001, 0.5, 0.3).in_map());
        assert!(!Receiver::new(0.5, f32::NAN, 0.3).in_map());
        assert!(!Receiver::new(0.5, 0.5, f32::INFINITY).in_map());
        assert!(!Receiver { valid: 0.0, ..Receiver::new(0.5, 0.5, 0.3) }.in_map());
    }
}
