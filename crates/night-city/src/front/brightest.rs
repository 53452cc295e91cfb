//! How much light cells may get.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 6.1 (future work:
//! detail by the upper bound of what shines on a view cell).
//! Deviations: those of [`levels_of_detail`].

use super::Front;
use crate::cells::each;
use dapple_many_lights::region::levels_of_detail;

/// The most light that the points of a cell may get.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellLight {
    /// Node of the scene's hierarchy.
    pub node: u32,
    /// Radiance of a white surface, linear, largest channel: of the brightest of its faces.
    pub radiance: f64,
}

impl Front<'_> {
    /// The most light that each cell of the last frame may get from what its objects start at, for
    /// levels of detail of the next ([`levels_of_detail::Levels`]): in the order of the cells. Clusters
    /// are divided while they may give more than `threshold`, radiance of a white surface. What a
    /// precut left out as too weak is no part of it; heights are not used.
    pub fn brightest(&mut self, threshold: f64) -> Vec<CellLight> {
        let Self { town, whole, cells, starts, .. } = self;
        let clamp_m = town.world(false).clamp_m;
        let mut of_cells = Vec::with_capacity(cells.cells.len());
        for (index, cell) in cells.cells.iter().enumerate() {
            let around = whole.of(town, cell.node);
            let mut lists: Vec<u32> = cells.objects_of(index).to_vec();
            lists.sort_unstable_by_key(|object| starts.range(*object));
            lists.dedup_by_key(|object| starts.range(*object));
            let bound = |object: &u32| {
                let faces = each(around.faced(*object).all());
                let regions = faces.filter_map(|d| around.cell.face(d)).map(|face| face.region);
                let of = |region| {
                    let nodes = starts.of(*object);
                    levels_of_detail::brightest(&town.lights, nodes, &region, clamp_m, threshold)
                };
                regions.map(|region| of(region).radiance).fold(0.0, f64::max)
            };
            let radiance = lists.iter().map(bound).fold(0.0, f64::max);
            of_cells.push(CellLight { node: cell.node, radiance });
        }
        of_cells
    }
}
