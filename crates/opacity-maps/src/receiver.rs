//! A point to be shaded.

use bytemuck::{Pod, Zeroable};

/// A point in the map's coordinates. 24 bytes.
///
/// It is lit (T = 1) when `flags` lacks [`Receiver::VALID`], when `u` or `v` leaves 0..=1, or when
/// `depth` is not finite. Non-finite slopes count as 0.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Receiver {
    /// Map coordinate to the right, 0..=1.
    pub u: f32,
    /// Map coordinate downwards, 0..=1.
    pub v: f32,
    /// Linear light depth, 0 near plane, 1 far plane.
    pub depth: f32,
    /// Slope of the receiver's plane, depth per unit of `u`: moves the comparison with the opaque
    /// map from tap to tap.
    pub slope_u: f32,
    /// Depth per unit of `v`.
    pub slope_v: f32,
    /// [`Receiver::VALID`], [`Receiver::OPAQUE`].
    pub flags: u32,
}

impl Receiver {
    /// There is a receiver.
    pub const VALID: u32 = 1;
    /// It lies on an opaque surface.
    pub const OPAQUE: u32 = 2;

    /// A translucent receiver at (`u`, `v`) and `depth`.
    #[must_use]
    pub fn at(u: f32, v: f32, depth: f32) -> Self {
        Self { u, v, depth, slope_u: 0.0, slope_v: 0.0, flags: Self::VALID }
    }

    /// Whether it is inside the map.
    pub fn in_map(&self) -> bool {
        let inside = |x: f32| (0.0..=1.0).contains(&x);
        self.flags & Self::VALID != 0 && inside(self.u) && inside(self.v) && self.depth.is_finite()
    }

    /// Depth of its plane `du`, `dv` map coordinates away.
    pub fn plane_depth(&self, du: f32, dv: f32) -> f32 {
        let slope = |s: f32| if s.is_finite() { s } else { 0.0 };
        self.depth + slope(self.slope_u) * du + slope(self.slope_v) * dv
    }
}
