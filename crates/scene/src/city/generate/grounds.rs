//! What lies flat: blocks with their sidewalks, streets, and the land that rows leave free.
//!
//! The pieces tile the city at y = 0 without overlap. A block's slab runs on under its buildings.

use super::layout::Layout;
use crate::city::{Ground, GroundKind};
use glam::DVec2;

/// Every flat piece: the slabs block by block, then streets and land row by row.
pub fn grounds(layout: &Layout) -> Vec<Ground> {
    let cells = (0..layout.rows).flat_map(|r| (0..layout.columns).map(move |c| (r, c)));
    let mut grounds: Vec<Ground> =
        cells.map(|(r, c)| piece(GroundKind::Sidewalk, layout.slab(r, c))).collect();
    for row in 0..layout.rows {
        across(layout, row, &mut grounds);
    }
    for street in 0..=layout.rows {
        along(layout, street, &mut grounds);
    }
    grounds
}

/// The streets between the blocks of a row, and land beyond its ends.
fn across(layout: &Layout, row: u32, grounds: &mut Vec<Ground>) {
    let [first, last] = [layout.slab(row, 0), layout.slab(row, layout.columns - 1)];
    let (z0, z1, street) = (first[0].y, first[1].y, layout.street_m);
    let mut push = |kind: GroundKind, x0: f64, x1: f64| {
        if x1 > x0 {
            grounds.push(piece(kind, [DVec2::new(x0, z0), DVec2::new(x1, z1)]));
        }
    };
    push(GroundKind::Land, layout.min.x, first[0].x - street);
    for column in 0..layout.columns {
        let x = layout.slab(row, column)[0].x;
        push(GroundKind::Street, x - street, x);
    }
    push(GroundKind::Street, last[1].x, last[1].x + street);
    push(GroundKind::Land, last[1].x + street, layout.max.x);
}

/// Street `index` along x, south of row `index - 1`, cut wherever a slab beside it begins or ends.
fn along(layout: &Layout, index: u32, grounds: &mut Vec<Ground>) {
    let beside = [index.checked_sub(1), Some(index).filter(|&r| r < layout.rows)];
    let slabs = beside
        .into_iter()
        .flatten()
        .flat_map(|row| (0..layout.columns).flat_map(move |c| layout.slab(row, c)));
    let mut cuts: Vec<f64> =
        slabs.map(|corner| corner.x).chain([layout.min.x, layout.max.x]).collect();
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    let z = layout.min.y + f64::from(index) * (layout.slab.y + layout.street_m);
    for x in cuts.windows(2) {
        let corners = [DVec2::new(x[0], z), DVec2::new(x[1], z + layout.street_m)];
        grounds.push(piece(GroundKind::Street, corners));
    }
}

/// A rectangle at y = 0, facing up.
fn piece(kind: GroundKind, [min, max]: [DVec2; 2]) -> Ground {
    Ground { kind, triangles: super::rectangle(min, max, 0.0).into() }
}
