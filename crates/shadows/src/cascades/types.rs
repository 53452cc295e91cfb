//! What cascades read and report.

use bytemuck::{Pod, Zeroable};

use super::CascadeError;
use super::lookup::{Place, Region, select};

/// Most cascades of a light.
pub const MAX_CASCADES: usize = 8;

/// Longest side of a map, texels.
pub const MAX_SIDE: u32 = 1 << 15;

/// Depths compared for a receiver, all of the same weight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Taps {
    /// The texel the receiver lies in.
    One,
    /// 3 x 3 texels around that one.
    Box3,
    /// The 4 x 4 nearest texels: offsets -1.5, -0.5, 0.5 and 1.5 texels along each axis.
    Box4,
}

impl Taps {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::One, Self::Box3, Self::Box4];

    /// Taps along one axis.
    #[must_use]
    pub fn side(self) -> u32 {
        match self {
            Self::One => 1,
            Self::Box3 => 3,
            Self::Box4 => 4,
        }
    }

    /// Texels beyond a receiver that may be read: the margin that keeps them in the map.
    #[must_use]
    pub fn reach(self) -> u32 {
        self.side() / 2
    }
}

/// How receivers are compared with the maps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Texels compared.
    pub taps: Taps,
    /// Depth, at least 0, that is taken off a receiver's.
    pub bias: f32,
    /// Texels, at least 0, of slope that are taken off too: this times the depth that the
    /// receiver's plane gains over a texel of its cascade along both axes.
    pub slope_bias: f32,
    /// Whether each tap is compared with the receiver's plane at the tap's texel centre.
    pub plane_bias: bool,
}

impl Settings {
    /// The taps with a bias of 1e-4 on the receiver's plane.
    #[must_use]
    pub fn new(taps: Taps) -> Self {
        Self { taps, bias: 1e-4, slope_bias: 0.0, plane_bias: true }
    }

    /// Checks both biases.
    ///
    /// # Errors
    /// [`CascadeError::Knob`].
    pub fn check(&self) -> Result<(), CascadeError> {
        let least = |name, value: f32, most: f32, limit| {
            if (0.0..=most).contains(&value) {
                Ok(())
            } else {
                Err(CascadeError::Knob { name, value: value.into(), limit })
            }
        };
        least("bias", self.bias, 1.0, "within 0..=1")?;
        least("slope_bias", self.slope_bias, 1e3, "within 0..=1000 texels")
    }
}

/// A point to be shaded, in the base map's coordinates. 32 bytes.
///
/// It is lit when `flags` lacks [`CascadeReceiver::VALID`], when `u`, `v`, `depth` or
/// `view_depth` is not finite, and when it lies outside its cascade's region. Non-finite slopes
/// count as 0.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct CascadeReceiver {
    /// Base map coordinate to the right.
    pub u: f32,
    /// Base map coordinate downwards.
    pub v: f32,
    /// Linear light depth, 0 near plane, 1 far plane.
    pub depth: f32,
    /// Slope of the receiver's plane: depth per unit of the base map's `u`.
    pub slope_u: f32,
    /// Depth per unit of the base map's `v`.
    pub slope_v: f32,
    /// Distance from the camera along its axis, in the unit of the splits: picks the cascade.
    pub view_depth: f32,
    /// [`CascadeReceiver::VALID`] or 0.
    pub flags: u32,
    /// Fills the struct to 32 bytes.
    pub pad: u32,
}

impl CascadeReceiver {
    /// There is a receiver.
    pub const VALID: u32 = 1;

    /// A receiver whose plane faces the light.
    #[must_use]
    pub fn at(u: f32, v: f32, depth: f32, view_depth: f32) -> Self {
        let (slope_u, slope_v) = (0.0, 0.0);
        Self { u, v, depth, slope_u, slope_v, view_depth, flags: Self::VALID, pad: 0 }
    }

    /// The same receiver on a plane of the given slopes.
    #[must_use]
    pub fn with_slope(self, slope_u: f32, slope_v: f32) -> Self {
        Self { slope_u, slope_v, ..self }
    }

    /// Whether there is a receiver and its place is finite.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        self.flags & Self::VALID != 0
            && [self.u, self.v, self.depth, self.view_depth].iter().all(|x| x.is_finite())
    }
}

/// Work of one frame, independent of the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Passes over the geometry: one a cascade.
    pub geometry_passes: u64,
    /// Texels of all maps.
    pub map_texels: u64,
    /// Bytes of all maps, f32 depths.
    pub map_bytes: u64,
    /// Texels that receivers compare with.
    pub shade_texels: u64,
    /// Bytes that shade reads: texels compared, and receivers.
    pub bytes_read: u64,
    /// Bytes written: maps, and visibilities.
    pub bytes_written: u64,
}

impl Counters {
    /// Every map is written once; every receiver in its cascade's region reads its taps.
    pub(super) fn of(
        regions: &[Region],
        side: u32,
        settings: &Settings,
        receivers: &[CascadeReceiver],
    ) -> Self {
        let map_texels = regions.len() as u64 * u64::from(side) * u64::from(side);
        let in_map = |receiver: &&CascadeReceiver| {
            let region = &regions[select(regions, receiver.view_depth)];
            receiver.is_valid() && Place::new(receiver, region, side, settings.taps).is_some()
        };
        let shaded = receivers.iter().filter(in_map).count() as u64;
        let shade_texels = shaded * u64::from(settings.taps.side().pow(2));
        let (map_bytes, count) = (4 * map_texels, receivers.len() as u64);
        Self {
            geometry_passes: regions.len() as u64,
            map_texels,
            map_bytes,
            shade_texels,
            bytes_read: 4 * shade_texels + size_of::<CascadeReceiver>() as u64 * count,
            bytes_written: map_bytes + 4 * count,
        }
    }
}
