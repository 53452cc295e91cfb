//! Which cascade and which texels a receiver looks at.
//!
//! All of it is f32 in every form, the reference included: these are decisions, and forms that
//! round differently before a decision cannot be held against each other. Products are compared
//! and floored as they are, never added to, so that fused operations change nothing.

use super::{Cascade, CascadeReceiver, Taps};

/// Steepest slope that is told apart, depth per unit of the base map.
pub const MAX_SLOPE: f32 = 1e6;

/// A cascade as receivers see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Base map coordinates of the region's corner.
    pub offset: [f32; 2],
    /// Texels of the cascade's map in a unit of the base map; 0 where the cascade is empty.
    pub texels_per_unit: f32,
    /// Side of a texel in base map coordinates.
    pub texel: f32,
    /// View depth at which the cascade ends, itself included.
    pub far: f32,
}

impl Region {
    /// The region of a cascade whose map has `side` texels a side.
    #[must_use]
    pub fn new(cascade: &Cascade, side: u32) -> Self {
        let side = f64::from(side);
        Self {
            offset: cascade.offset.map(|x| x as f32),
            texels_per_unit: if cascade.is_empty() { 0.0 } else { (side / cascade.scale) as f32 },
            texel: (cascade.scale / side) as f32,
            far: cascade.far as f32,
        }
    }
}

/// The cascade of a view depth: the first that does not end before it, so that a boundary belongs
/// to the nearer one; what lies beyond all is in the last.
///
/// 0 where there are no regions.
#[must_use]
pub fn select(regions: &[Region], view_depth: f32) -> usize {
    let found = regions.iter().position(|region| view_depth <= region.far);
    found.unwrap_or(regions.len().saturating_sub(1))
}

/// Where a receiver lies in its cascade's map, and the first texel it compares with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Texels from the map's corner along u and v, 0..=side.
    pub at: [f32; 2],
    /// First tap along u and v; may lie before the border.
    pub first: [i32; 2],
}

impl Place {
    /// The place of a valid receiver; `None` outside the region.
    #[must_use]
    pub fn new(receiver: &CascadeReceiver, region: &Region, side: u32, taps: Taps) -> Option<Self> {
        let at = [
            (receiver.u - region.offset[0]) * region.texels_per_unit,
            (receiver.v - region.offset[1]) * region.texels_per_unit,
        ];
        let inside = at.iter().all(|x| (0.0..=side as f32).contains(x));
        (inside && region.texels_per_unit > 0.0)
            .then(|| Self { at, first: at.map(|x| first(x, taps)) })
    }
}

fn first(at: f32, taps: Taps) -> i32 {
    let floor = at.floor();
    let texel = floor as i32;
    match taps {
        Taps::One => texel,
        Taps::Box3 => texel - 1,
        // floor(at - 3/2), written without a difference.
        Taps::Box4 => texel - 2 + i32::from(at >= floor + 0.5),
    }
}

/// Tap `i` along an axis as a texel: beyond the border, the border's.
#[must_use]
pub fn texel(first: i32, i: u32, side: u32) -> u32 {
    (i64::from(first) + i64::from(i)).clamp(0, i64::from(side) - 1) as u32
}

/// Slopes along u and v, 0 where they are not finite, never steeper than [`MAX_SLOPE`].
#[must_use]
pub fn slopes(receiver: &CascadeReceiver) -> [f32; 2] {
    [receiver.slope_u, receiver.slope_v]
        .map(|s| if s.is_finite() { s.clamp(-MAX_SLOPE, MAX_SLOPE) } else { 0.0 })
}
