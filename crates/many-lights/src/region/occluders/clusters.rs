//! Boxes around clusters of buildings: not sound, they fill streets and gaps.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 4.2.3 (boxes of the
//! nodes of a hierarchy over buildings, contiguous ones grouped first).
//! Deviations: the thesis does not say which nodes are projected. These are the highest ones whose
//! buildings differ in height and whose boxes are deep by no more than a fixed length; clusters that
//! could only grow beyond are not joined at all. Boxes are as high as their tallest building.

use super::gaps::{Placed, shared};
use crate::region::Solid;
use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

/// Most by which the tops of a cluster's buildings differ, metres: three storeys.
pub const SPREAD_M: f64 = 9.0;
/// Most of the shorter side of a cluster's box, metres: two rows of buildings back to back.
pub const DEPTH_M: f64 = 30.0;
/// Clusters farther apart are not joined, metres: a street with its sidewalks lies between.
pub const APART_M: f64 = 16.0;

#[derive(Clone, Copy, Debug)]
struct Cluster {
    solid: Solid,
    lowest_top: f64,
}

/// Boxes around clusters of `boxes`, one a building. Those that share walls are joined first, by
/// `sharing`, then all that are near; always the two whose box has the least plan.
pub fn clusters(boxes: &[Placed], sharing: impl Fn(&Placed, &Placed) -> bool) -> Vec<Solid> {
    let of = |p: &Placed| Cluster { solid: p.solid, lowest_top: p.solid.max.y };
    let contiguous = neighbours(boxes, |a, b| distance(&a.solid, &b.solid) <= 0.0 && sharing(a, b));
    let first = joined(boxes.iter().map(of).collect(), contiguous);
    let near = neighbours(&first, |a, b| distance(&a.solid, &b.solid) <= APART_M);
    joined(first, near).into_iter().map(|c| c.solid).collect()
}

/// Joins neighbours while any may be.
fn joined(clusters: Vec<Cluster>, mut neighbours: Vec<BTreeSet<usize>>) -> Vec<Cluster> {
    let mut there: Vec<Option<Cluster>> = clusters.into_iter().map(Some).collect();
    let mut queue = BinaryHeap::new();
    for (i, list) in neighbours.iter().enumerate() {
        queue.extend(list.range(i + 1..).filter_map(|&j| candidate(&there, i, j)));
    }
    while let Some(Reverse((_, i, j))) = queue.pop() {
        let (Some(a), Some(b)) = (there[i], there[j]) else { continue };
        (there[i], there[j]) = (None, None);
        let mut both = std::mem::take(&mut neighbours[i]);
        both.append(&mut neighbours[j]);
        both.retain(|&k| there[k].is_some());
        let made = there.len();
        there.push(Some(a.with(&b)));
        for &k in &both {
            neighbours[k].insert(made);
            queue.extend(candidate(&there, k, made));
        }
        neighbours.push(both);
    }
    there.into_iter().flatten().collect()
}

/// Two clusters that may be joined, by what that costs. Areas are at least 0: their bits are in order.
fn candidate(
    there: &[Option<Cluster>],
    i: usize,
    j: usize,
) -> Option<Reverse<(u64, usize, usize)>> {
    let both = there[i]?.with(&there[j]?);
    let Solid { min, max } = both.solid;
    let sides = (max - min).with_y(1.0);
    let fits = max.y - both.lowest_top <= SPREAD_M && sides.x.min(sides.z) <= DEPTH_M;
    fits.then(|| Reverse(((sides.x * sides.z).to_bits(), i, j)))
}

impl Cluster {
    fn with(&self, other: &Self) -> Self {
        let (a, b) = (&self.solid, &other.solid);
        Self {
            solid: Solid { min: a.min.min(b.min), max: a.max.max(b.max) },
            lowest_top: self.lowest_top.min(other.lowest_top),
        }
    }
}

/// Horizontal distance of two boxes, metres.
fn distance(a: &Solid, b: &Solid) -> f64 {
    let gap = |axis: usize| {
        let [from, to] = shared([a.min[axis], a.max[axis]], [b.min[axis], b.max[axis]]);
        (from - to).max(0.0)
    };
    gap(0).hypot(gap(2))
}

/// Of each, the others that are `near`.
fn neighbours<T>(all: &[T], near: impl Fn(&T, &T) -> bool) -> Vec<BTreeSet<usize>> {
    let mut lists = vec![BTreeSet::new(); all.len()];
    for i in 0..all.len() {
        for j in i + 1..all.len() {
            if near(&all[i], &all[j]) {
                lists[i].insert(j);
                lists[j].insert(i);
            }
        }
    }
    lists
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn placed(x: [f64; 2], z: [f64; 2], top: f64) -> Placed {
        let min = DVec3::new(x[0], f64::NEG_INFINITY, z[0]);
        Placed { solid: Solid { min, max: DVec3::new(x[1], top, z[1]) }, building: 0 }
    }

    #[test]
    fn contiguous_buildings_come_first_then_near_ones_within_the_limits() {
        let row = |z: f64, tops: [f64; 3]| {
            let of = move |(i, top): (usize, f64)| {
                let x = 10.0 * i as f64;
                placed([x, x + 10.0], [z, z + 10.0], top)
            };
            tops.into_iter().enumerate().map(of)
        };
        // Two rows over an alley, one of mixed heights; a third over a street that is too wide.
        let boxes: Vec<Placed> = row(0.0, [6.0, 9.0, 6.0])
            .chain(row(15.0, [3.0, 30.0, 9.0]))
            .chain(row(15.0 + 10.0 + APART_M + 1.0, [6.0, 6.0, 6.0]))
            .collect();
        let made = clusters(&boxes, |_, _| true);
        let mut plans: Vec<[f64; 5]> =
            made.iter().map(|s| [s.min.x, s.max.x, s.min.z, s.max.z, s.max.y]).collect();
        plans.sort_by(|a, b| {
            a.iter().zip(b).map(|(a, b)| a.total_cmp(b)).find(|o| o.is_ne()).unwrap()
        });
        // The tall one stays alone; everything else of the first block is one box, over the alley.
        let expected = [
            [0.0, 30.0, 0.0, 25.0, 9.0],
            [0.0, 30.0, 42.0, 52.0, 6.0],
            [10.0, 20.0, 15.0, 25.0, 30.0],
        ];
        assert_eq!(plans, expected);
        // Without walls in common they are joined all the same, since they are near.
        assert_eq!(clusters(&boxes, |_, _| false).len(), 3);
        assert!(clusters(&[], |_, _| true).is_empty());
    }
}
