//! Bounding opacity maps with a λ for each tile, in a table that passes of a frame may write.

use super::{
    OpacityGpuError,
    bounds::{Bounds, Ends},
    layered::{LayeredMaps, no_form, scale},
    layers::place,
    raster::Raster,
};
use crate::{Fragments, Layered, Layout, Opaque, Settings, SplitKind};
use dapple_gpu::Gpu;

/// Tiles in a row, and in all.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tiles {
    /// Texels a side.
    pub side: u32,
    pub across: u32,
    pub all: u32,
}

impl Tiles {
    /// Tiles of `side` x `side` texels; 0: one for the whole map.
    pub fn new([width, height]: [u32; 2], side: u32) -> Self {
        // A tile beyond the map is the whole map.
        let longest = width.max(height).max(1);
        let side = if side == 0 { longest } else { side.min(longest) };
        let across = width.div_ceil(side);
        Self { side, across, all: across.saturating_mul(height.div_ceil(side)) }
    }
}

impl LayeredMaps {
    /// Maps whose table holds the λ of each tile, 0 to begin with; between the bounds of `other`,
    /// if given.
    pub fn tiled(
        gpu: &Gpu,
        raster: &Raster,
        layered: &Layered,
        settings: &Settings,
        tiles: Tiles,
        other: Option<&Self>,
    ) -> Result<Self, OpacityGpuError> {
        let mut layered = layered.clone();
        let Layout::Bounded { split, .. } = &mut layered.layout else {
            return Err(no_form("a split of other than bounding opacity maps", "they have none"));
        };
        if !matches!(split.kind, SplitKind::Normalised | SplitKind::Positions) {
            return Err(no_form("a search with lookup textures", "one of them holds one λ"));
        }
        // Any between the ends, where the split is a function of its own: the table tells.
        split.lambda = 0.5;
        let bounds = match other {
            Some(other) => other.shared_bounds(),
            None => {
                let stretches = matches!(settings.opaque, Opaque::Weight { in_bounds: true, .. });
                let ends = Ends::Both(layered.end_map);
                Some(Bounds::new(gpu, raster, ends, stretches)?.into())
            }
        };
        let size = [raster.width, raster.height];
        // Only planes ask for fragments.
        let no_fragments = || Ok::<_, OpacityGpuError>(Fragments::default());
        let mut placed = place(&layered, settings.opaque, size, scale(&layered), no_fragments)?;
        placed.table = vec![0.0; tiles.all as usize];
        for (name, value) in &mut placed.constants {
            if *name == "TILE" {
                *value = f64::from(tiles.side);
            }
        }
        Self::placed(gpu, raster, &layered, bounds, placed, false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_the_map() {
        for (size, side, expected) in [
            ([21, 13], 8, (8, 3, 6)),
            ([21, 13], 0, (21, 1, 1)),
            ([13, 21], 0, (21, 1, 1)),
            ([21, 13], 4096, (21, 1, 1)),
            ([3, 2], 1, (1, 3, 6)),
        ] {
            let tiles = Tiles::new(size, side);
            assert_eq!((tiles.side, tiles.across, tiles.all), expected, "{size:?} {side}");
        }
    }
}
