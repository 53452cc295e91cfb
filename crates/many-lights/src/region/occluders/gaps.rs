//! Gaps between boxes that no light passes: within the walls that neighbours share.
//!
//! Inscribed boxes of two buildings that share a wall do not touch, and shadows of boxes that do not
//! touch are never joined. Where the gap between them is proved to lie inside the two buildings, the
//! lower box is extended to the higher one.

use super::block::Walls;
use crate::region::Solid;
use glam::{DVec2, DVec3};

/// The widest gap looked at, metres: what a wall is askew by over its length, and more only where
/// inscribed boxes are much smaller than their buildings.
const WIDEST_M: f64 = 4.0;
/// What the proof keeps from walls, over the farthest coordinate: rounding of turned coordinates.
const ROUNDING: f64 = 1e-12;

/// A box and what it stands in.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    /// Turned space.
    pub solid: Solid,
    /// Index into [`Walls`].
    pub building: u32,
}

/// Walls in turned space.
pub struct Plan<'a> {
    /// Local space.
    pub walls: &'a Walls,
    /// Local (x, z) to turned.
    pub turn: &'a dyn Fn(DVec2) -> DVec2,
}

impl Placed {
    /// Its sides along an axis: 0 is x, 2 is z.
    pub fn side(&self, axis: usize) -> [f64; 2] {
        [self.solid.min[axis], self.solid.max[axis]]
    }

    /// Whether its height range holds the other's.
    pub fn stands_over(&self, other: &Self) -> bool {
        self.solid.min.y <= other.solid.min.y && self.solid.max.y >= other.solid.max.y
    }
}

/// What two ranges share.
pub fn shared(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].max(b[0]), a[1].min(b[1])]
}

/// For each box, those that begin after it along `axis` and within reach of its end, nearest first.
pub fn followers(placed: &[Placed], axis: usize) -> Vec<Vec<u32>> {
    let mut order: Vec<u32> = (0..placed.len() as u32).collect();
    let begin = |i: u32| placed[i as usize].side(axis)[0];
    order.sort_by(|&a, &b| begin(a).total_cmp(&begin(b)).then(a.cmp(&b)));
    let across = 2 - axis;
    let of = |a: &Placed| {
        let [from, to] = a.side(axis);
        let first = order.partition_point(|&i| begin(i) <= from);
        let reached = order[first..].iter().take_while(|&&i| begin(i) <= to + WIDEST_M);
        let follows = |b: &Placed| {
            let [low, high] = shared(a.side(across), b.side(across));
            b.side(axis)[1] > to && low <= high
        };
        reached.copied().filter(|&i| follows(&placed[i as usize])).collect()
    };
    placed.iter().map(of).collect()
}

impl Plan<'_> {
    /// Whether all between two boxes along `axis`, over `range` across, is inside one of them or of
    /// their buildings: `range` lies within what both share across, or within `a` alone.
    pub fn is_solid(&self, a: &Placed, b: &Placed, axis: usize, range: [f64; 2]) -> bool {
        let (from, to) = (a.side(axis)[1], b.side(axis)[0]);
        if to <= from {
            return true;
        }
        if to - from > WIDEST_M || !self.walls.related(a.building, b.building) {
            return false;
        }
        let across = 2 - axis;
        let (mut min, mut max) = (DVec3::ZERO, DVec3::ZERO);
        (min[axis], max[axis]) = (from, to);
        (min[across], max[across]) = (range[0], range[1]);
        let (min, max) = (DVec2::new(min.x, min.z), DVec2::new(max.x, max.z));
        let kept = ROUNDING * min.abs().max(max.abs()).max_element();
        // One side of the gap lies in a building, and nothing leads out of the two.
        let mut border = self.walls.border(a.building, b.building);
        border.all(|wall| !meets(wall.map(self.turn), min - kept, max + kept))
    }

    /// Extends boxes to those beside them, where these are at least as high and what lies between is
    /// solid.
    pub fn close(&self, placed: &mut [Placed]) {
        for axis in [0, 2] {
            let before = placed.to_vec();
            for (i, followers) in followers(&before, axis).into_iter().enumerate() {
                let a = before[i];
                for j in followers {
                    let b = before[j as usize];
                    self.extend(placed, [i, j as usize], [a, b], axis);
                }
            }
        }
    }

    /// Extends the lower of `a` and `b`, which stand at `at`.
    fn extend(&self, placed: &mut [Placed], at: [usize; 2], [a, b]: [Placed; 2], axis: usize) {
        let (to, from) = (b.side(axis)[0], a.side(axis)[1]);
        if to <= from {
            return;
        }
        let range = |p: &Placed| p.side(2 - axis);
        if b.stands_over(&a) && self.is_solid(&a, &b, axis, range(&a)) {
            let max = &mut placed[at[0]].solid.max;
            max[axis] = max[axis].max(to);
        } else if a.stands_over(&b) && self.is_solid(&a, &b, axis, range(&b)) {
            let min = &mut placed[at[1]].solid.min;
            min[axis] = min[axis].min(from);
        }
    }
}

/// Whether a segment and a closed rectangle have a point in common (separating axes).
fn meets([p, q]: [DVec2; 2], min: DVec2, max: DVec2) -> bool {
    let (middle, half) = (0.5 * (min + max), 0.5 * (max - min));
    let (centre, reach) = (0.5 * (p + q) - middle, 0.5 * (q - p).abs());
    let across = (q - p).perp();
    let apart = (centre.abs() - reach - half).max_element() > 0.0
        || centre.dot(across).abs() > half.dot(across.abs());
    !apart
}
