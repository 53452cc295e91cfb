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
