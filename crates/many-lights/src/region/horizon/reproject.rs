//! Umbrae that are moved from one plane to another.

use super::super::{Cuboid, Edge};
use super::line::{between, beyond, lowered, raised};
use super::outline::Outline;
use super::{Peak, Umbra};

/// The umbra on plane `to` of what is an umbra on plane `from`, which lies before it and behind the
/// cell: that hides all that lies behind it, as if it stood on that plane. `None` where it collapses.
/// Level edges and peaks of single occluders lose nothing; others keep no more than they had.
pub fn reproject(cell: &Cuboid, umbra: &Umbra, from: f64, to: f64) -> Option<Umbra> {
    let ([u0, u1], [h0, h1]) = (cell.u, cell.h);
    if !(from > cell.w[1] && to >= from && to < f64::INFINITY) {
        return None;
    }
    // From the near side of the cell what stands on a plane is seen larger than from its far side.
    let [far, near] = cell.w.map(|c| beyond(c, from, to));
    let left = raised(u0, umbra.u[0], if umbra.u[0] > u0 { near } else { far });
    let right = lowered(u1, umbra.u[1], if umbra.u[1] < u1 { near } else { far });
    let foot = raised(h0, umbra.foot, if umbra.foot > h0 { near } else { far });
    let of_level = |h: f64| if h > h1 { far } else { near };
    if umbra.is_flat() {
        let top = lowered(h1, umbra.top[0], of_level(umbra.top[0]));
        return (left < right && foot < top).then_some(Umbra::flat([left, right], foot, top));
    }
    let ends = [[umbra.u[0], umbra.top[0]], [umbra.u[1], umbra.top[1]]];
    // A line as moved from each corner of the cell's top: the lowest at `u`.
    let moved = |a: [f64; 2], b: [f64; 2], u: f64| {
        let from_corner = |corner: f64, beyond: f64| {
            let then = (u + beyond * corner) / (1.0 + beyond);
            let height = lowered(h1, between(a, b, then), beyond);
            // What rounding of the place does to the height.
            let steepness = ((b[1] - a[1]) / (b[0] - a[0])).abs() * (1.0 + beyond);
            height - 4.0 * f64::EPSILON * steepness * (u.abs() + corner.abs())
        };
        let from_side = |corner| from_corner(corner, far).min(from_corner(corner, near));
        from_side(u0).min(from_side(u1))
    };
    let Some(Peak { u: peak, h }) = umbra.peak else {
        let line = |u| moved(ends[0], ends[1], u);
        let (rising, falling) = (line, line);
        let knees = [left, right];
        let level = f64::INFINITY;
        return Outline { u: [left, right], foot, level, knees, rising, falling }
            .umbra(Edge::Sloped);
    };
    let bends = [peak[0] > umbra.u[0], peak[1] < umbra.u[1]];
    let line = |side: usize, u: f64| match (bends[side], side) {
        (false, _) => f64::INFINITY,
        (true, 0) => moved(ends[0], [peak[0], h], u),
        (true, _) => moved([peak[1], h], ends[1], u),
    };
    let level = of_level(h);
    let knees = [
        if bends[0] { raised(u0, peak[0], level) } else { left },
        if bends[1] { lowered(u1, peak[1], level) } else { right },
    ];
    Outline {
        u: [left, right],
        foot,
        level: lowered(h1, h, level),
        knees: knees.map(|knee| knee.max(left).min(right)),
        rising: |u| line(0, u),
        falling: |u| line(1, u),
    }
    .umbra(Edge::Hull)
}
