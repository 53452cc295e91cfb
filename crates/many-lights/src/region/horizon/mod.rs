//! Shadows of single occluders on a plane, as seen from everywhere in a cell, and projections of what
//! they may hide.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, sections 4.2.3 (horizons),
//! 4.2.5 (reprojection), after F. Durand et al., "Conservative visibility preprocessing using extended
//! projections", 2000.
//! Deviations: the thesis gives no formulas; these are exact for boxes: a point lies in the umbra of a
//! convex occluder exactly if it is hidden from all corners of the cell. Occluders have a foot, minus
//! infinity where they are the thesis's, which reach down for ever.

use super::{Cuboid, Edge};
use std::cmp::Ordering;

/// The part of a plane that is hidden from every point of a cell: between `u[0]` and `u[1]`, above
/// `foot`, below the edge from `top[0]` at `u[0]` to `top[1]` at `u[1]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Umbra {
    /// Left and right end, metres; the left one is smaller.
    pub u: [f64; 2],
    /// Height of the edge at each end.
    pub top: [f64; 2],
    /// Height above which it hides.
    pub foot: f64,
}

/// Everything of a plane that any line from a point of a cell to a point of an occludee crosses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Left and right end, metres.
    pub u: [f64; 2],
    /// The lowest and the highest point.
    pub h: [f64; 2],
}

impl Umbra {
    /// Whether a projection lies wholly inside.
    pub fn hides(&self, p: &Projection) -> bool {
        p.u[0] >= self.u[0] && p.u[1] <= self.u[1] && p.h[0] >= self.foot && {
            p.h[1] <= self.height(p.u[0]).min(self.height(p.u[1]))
        }
    }

    /// Height of the edge at `u`, which lies between the ends.
    pub fn height(&self, u: f64) -> f64 {
        if self.top[0] == self.top[1] {
            return self.top[0];
        }
        let share = (u - self.u[0]) / (self.u[1] - self.u[0]);
        (1.0 - share) * self.top[0] + share * self.top[1]
    }
}

/// What is called k: how much farther a plane is from a cell's side than an occluder.
fn k(cell: f64, at: f64, plane: f64) -> f64 {
    (plane - cell) / (at - cell)
}

/// On the line from `from` through `at`, `k` times as far. This form gives `at` itself where k is 1:
/// walls that touch have shadows that touch.
fn along(from: f64, at: f64, k: f64) -> f64 {
    (1.0 - k) * from + k * at
}

/// The umbra of an occluder on the plane w = `plane`, which lies behind the cell; `None` where nothing
/// is hidden. What of the occluder lies within the cell's depth, or behind the plane, hides nothing.
pub fn umbra(cell: &Cuboid, occluder: &Cuboid, plane: f64, edge: Edge) -> Option<Umbra> {
    let _ = edge;
    let [c0, c1] = cell.w;
    let [foot, top] = occluder.h;
    let mut near = occluder.w[0].max(c1);
    let far = occluder.w[1].min(plane);
    if !(far > c1 && near <= far) {
        return None;
    }
    // Where the near face touches the cell, some factors are infinite: the far face alone hides more.
    if near <= c0 || near <= c1 && (top < cell.h[1] || foot > cell.h[0]) {
        near = far;
    }
    let left_k = if occluder.u[0] > cell.u[0] { k(c1, far, plane) } else { k(c0, near, plane) };
    let right_k = if occluder.u[1] < cell.u[1] { k(c1, far, plane) } else { k(c0, near, plane) };
    let left = along(cell.u[0], occluder.u[0], left_k);
    let right = along(cell.u[1], occluder.u[1], right_k);
    let top = match top.total_cmp(&cell.h[1]) {
        Ordering::Less => along(cell.h[1], top, k(c1, near, plane)),
        Ordering::Equal => top,
        Ordering::Greater => along(cell.h[1], top, k(c0, far, plane)),
    };
    let foot = match foot.total_cmp(&cell.h[0]) {
        Ordering::Less => along(cell.h[0], foot, k(c0, far, plane)),
        Ordering::Equal => foot,
        Ordering::Greater => along(cell.h[0], foot, k(c1, near, plane)),
    };
    (left < right && foot < top).then_some(Umbra { u: [left, right], top: [top; 2], foot })
}

/// The umbra on plane `to` of what is an umbra on plane `from`, which lies before it and behind the
/// cell: that hides all that lies behind it, as if it stood on that plane. `None` where it collapses.
pub fn reproject(cell: &Cuboid, umbra: &Umbra, from: f64, to: f64) -> Option<Umbra> {
    let ks = cell.w.map(|c| k(c, from, to));
    let most = |a: [f64; 2]| a[0].max(a[1]);
    let least = |a: [f64; 2]| a[0].min(a[1]);
    let left = most(ks.map(|k| along(cell.u[0], umbra.u[0], k)));
    let right = least(ks.map(|k| along(cell.u[1], umbra.u[1], k)));
    if left.partial_cmp(&right) != Some(Ordering::Less) {
        return None;
    }
    let foot = most(ks.map(|k| along(cell.h[0], umbra.foot, k)));
    let top = if umbra.top[0] == umbra.top[1] {
        [least(ks.map(|k| along(cell.h[1], umbra.top[0], k))); 2]
    } else {
        // The edge as moved from each corner of the cell's top; the lowest of lines bends down only.
        let height = |at: f64| {
            let from_corner = |k: f64, u: f64| {
                let u_then = (at - (1.0 - k) * u) / k;
                along(cell.h[1], umbra.height(u_then), k)
            };
            least(ks.map(|k| least(cell.u.map(|u| from_corner(k, u)))))
        };
        [height(left), height(right)]
    };
    (foot < top[0].min(top[1])).then_some(Umbra { u: [left, right], top, foot })
}

/// The projection of an occludee on the plane w = `plane`, which lies behind the cell and not behind
/// the occludee's near face.
pub fn project(cell: &Cuboid, occludee: &Cuboid, plane: f64) -> Projection {
    // Share of the way from the cell to the occludee at which the plane lies.
    let most = k(cell.w[0], occludee.w[0], plane);
    let least = k(cell.w[1], occludee.w[1], plane);
    let low = |from: f64, at: f64| along(from, at, if at < from { most } else { least });
    let high = |from: f64, at: f64| along(from, at, if at > from { most } else { least });
    Projection {
        u: [low(cell.u[0], occludee.u[0]), high(cell.u[1], occludee.u[1])],
        h: [low(cell.h[0], occludee.h[0]), high(cell.h[1], occludee.h[1])],
    }
}
