//! The umbra of one occluder.

use super::super::{Cuboid, Edge};
use super::Umbra;
use super::line::{beyond, lowered, raised};
use super::outline::Outline;

/// The umbra of an occluder on the plane w = `plane`, which lies behind the cell; `None` where nothing
/// is hidden, and where anything is not a number. What of the occluder lies within the cell's depth,
/// or behind the plane, hides nothing.
pub fn umbra(cell: &Cuboid, occluder: &Cuboid, plane: f64, edge: Edge) -> Option<Umbra> {
    let ([c0, c1], [u0, u1], [h0, h1]) = (cell.w, cell.u, cell.h);
    let ([a0, a1], [foot, top]) = (occluder.u, occluder.h);
    let far = occluder.w[1].min(plane);
    let are_boxes = c0 <= c1 && u0 <= u1 && h0 <= h1 && a0 <= a1 && foot <= top;
    let is_before = plane < f64::INFINITY && occluder.w[0] <= far;
    let is_behind = occluder.w[1] > c1 && far > c1;
    if !(are_boxes && is_before && is_behind) {
        return None;
    }
    let mut near = occluder.w[0].max(c1);
    // The near face widens the shadow of an occluder wider than the cell, but sinks the top of one
    // that is lower than the cell, and lifts the foot of one above the cell's: without bounds as it
    // comes near. The far face alone is an occluder too.
    let sinks = top < h1 && edge != Edge::Hull || foot > h0;
    if near <= c0 || sinks {
        near = far;
    }
    let [near_c0, far_c0, far_c1] =
        [beyond(c0, near, plane), beyond(c0, far, plane), beyond(c1, far, plane)];
    let left = raised(u0, a0, if a0 > u0 { far_c1 } else { near_c0 });
    let right = lowered(u1, a1, if a1 < u1 { far_c1 } else { near_c0 });
    // Between the ends, a wide occluder is seen against its near face from everywhere.
    let over = if a0 <= u0 && a1 >= u1 { near_c0 } else { far_c0 };
    let foot = raised(h0, foot, if foot > h0 { far_c1 } else { over });
    if edge == Edge::Flat || top == h1 {
        let top = lowered(h1, top, if top > h1 { over } else { far_c1 });
        return (left < right && foot < top).then_some(Umbra::flat([left, right], foot, top));
    }
    // The highest side of the top as all corners see it is level. Towards an end, the sides that run
    // along w are its outline: from the cell's corner at that end they go towards its height.
    let is_high = top > h1;
    let highest = if is_high { near_c0 } else { far_c1 };
    let bends = [(a0 > u0) == is_high && a0 != u0, (a1 < u1) == is_high && a1 != u1];
    let slope = |side: usize, u: f64| match bends[side] {
        true => lowered(h1, top, beyond(cell.u[side], occluder.u[side], u)),
        false => f64::INFINITY,
    };
    let knees = [
        if bends[0] { raised(u0, a0, highest) } else { left },
        if bends[1] { lowered(u1, a1, highest) } else { right },
    ];
    Outline {
        u: [left, right],
        foot,
        level: lowered(h1, top, highest),
        knees: knees.map(|knee| knee.max(left).min(right)),
        rising: |u| slope(0, u),
        falling: |u| slope(1, u),
    }
    .umbra(edge)
}
