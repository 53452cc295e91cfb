//! Based on:
//! - Walter et al. 2008, *Fast agglomerative clustering for rendering*: joining the best pair first.
//! - Meister and Bittner 2018, *Parallel locally-ordered clustering for bounding volume hierarchy
//!   construction*: clusters along a Morton curve join where each is the other's best within a radius.
//!
//! Deviations: ties, which regular scenes are full of, go to the pair of the least exclusive or of
//! its places; the order of pairs is then total and symmetric, and a row of equal clusters joins two
//! by two in one pass. A pass that joins few pairs is followed by one that joins neighbours, so that
//! passes, and with them the tree's depth, stay logarithmic whatever the input.

use super::{Bounds, Objects, Tree, check};
use crate::OcclusionError;
use rayon::prelude::*;

/// Up to so many objects the best of all pairs is joined first; the time grows with their square.
const EXACT: usize = 2048;
/// Neighbours on either side that are looked at.
const RADIUS: usize = 16;
/// A pass that joins fewer than one cluster in so many counts as stuck.
const STUCK: usize = 32;
/// Fewer clusters are not worth the other threads.
const PARALLEL: usize = 4096;

/// Two clusters that become one. Objects come first, then clusters in the order of their making.
pub(super) type Merge = [u32; 2];

impl Tree {
    /// Bottom-up: the pair of the smallest common surface area is joined first, within a
    /// neighbourhood (locally ordered) where there are more than a few thousand. Binary; leaves of
    /// one object.
    ///
    /// # Errors
    /// More objects than 2^31, or bounds that are not finite.
    pub fn bottom_up(objects: &Objects) -> Result<Self, OcclusionError> {
        check(objects)?;
        let boxes: Vec<Bounds> = objects.objects.iter().map(|o| o.bounds).collect();
        let merges = if boxes.len() <= EXACT { exact(&boxes) } else { locally_ordered(&boxes) };
        let mut tree = Self::from_merges(boxes.len(), &merges);
        tree.fit(objects);
        Ok(tree)
    }

    /// Depth first; bounds are left empty.
    pub(super) fn from_merges(count: usize, merges: &[Merge]) -> Self {
        let mut tree = Self { nodes: Vec::new(), objects: vec![0; count] };
        if count == 0 {
            return tree;
        }
        let mut sizes = vec![1_u32; count + merges.len()];
        for (i, &[a, b]) in merges.iter().enumerate() {
            sizes[count + i] = sizes[a as usize] + sizes[b as usize];
        }
        let root = sizes.len() as u32 - 1;
        tree.nodes.reserve(sizes.len());
        tree.nodes.push(Self::node(0, 0..count as u32));
        let mut open = vec![(0_u32, root)];
        while let Some((index, cluster)) = open.pop() {
            let range = tree.nodes[index as usize].objects.clone();
            let Some(&[a, b]) = (cluster as usize).checked_sub(count).and_then(|i| merges.get(i))
            else {
                tree.objects[range.start as usize] = cluster;
                continue;
            };
            let middle = range.start + sizes[a as usize];
            let child = tree.nodes.len() as u32;
            tree.nodes[index as usize].children = child..child + 2;
            tree.nodes.push(Self::node(index, range.start..middle));
            tree.nodes.push(Self::node(index, middle..range.end));
            open.push((child + 1, b));
            open.push((child, a));
        }
        tree
    }
}

/// Rank of a pair by its common area, then by its places; the least is joined first.
type Rank = (u32, u32, u32);

const NEVER: Rank = (u32::MAX, u32::MAX, u32::MAX);

fn rank(boxes: &[Bounds], i: usize, j: usize) -> Rank {
    // Areas are not negative: their bits are in their order.
    let area = boxes[i].union(boxes[j]).surface_area();
    (area.to_bits(), (i ^ j) as u32, i.min(j) as u32)
}

fn partner(rank: Rank, i: usize) -> usize {
    rank.1 as usize ^ i
}

/// Always the best of all pairs. A joined cluster takes the lower of the two places.
pub(super) fn exact(boxes: &[Bounds]) -> Vec<Merge> {
    let mut boxes = boxes.to_vec();
    let mut ids: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut live: Vec<usize> = (0..boxes.len()).collect();
    let search = |boxes: &[Bounds], live: &[usize], i: usize| {
        let others = live.iter().filter(|&&j| j != i);
        others.map(|&j| rank(boxes, i, j)).min().unwrap_or(NEVER)
    };
    let mut best: Vec<Rank> = live.iter().map(|&i| search(&boxes, &live, i)).collect();
    let mut merges = Vec::with_capacity(boxes.len());
    while live.len() > 1 {
        let Some(&first) = live.iter().min_by_key(|&&i| best[i]) else { break };
        let second = partner(best[first], first);
        let (kept, gone) = (first.min(second), first.max(second));
        merges.push([ids[kept], ids[gone]]);
        ids[kept] = (ids.len() + merges.len()) as u32 - 1;
        boxes[kept] = boxes[kept].union(boxes[gone]);
        live.retain(|&i| i != gone);
        best[kept] = search(&boxes, &live, kept);
        for &i in live.iter().filter(|&&i| i != kept) {
            let with = partner(best[i], i);
            best[i] = if with == kept || with == gone {
                search(&boxes, &live, i)
            } else {
                best[i].min(rank(&boxes, i, kept))
            };
        }
    }
    merges
}

/// The best pairs among neighbours along a Morton curve.
pub(super) fn locally_ordered(boxes: &[Bounds]) -> Vec<Merge> {
    let mut ids = along_curve(boxes);
    let mut boxes: Vec<Bounds> = ids.iter().map(|&i| boxes[i as usize]).collect();
    let count = boxes.len() as u32;
    let mut merges: Vec<Merge> = Vec::with_capacity(boxes.len());
    let mut best: Vec<usize> = Vec::new();
    while boxes.len() > 1 {
        let nearest = |i: usize| {
            let last = (i + RADIUS).min(boxes.len() - 1);
            let around = (i.saturating_sub(RADIUS)..=last).filter(|&j| j != i);
            partner(around.map(|j| rank(&boxes, i, j)).min().unwrap_or(NEVER), i)
        };
        best.clear();
        if boxes.len() < PARALLEL {
            best.extend((0..boxes.len()).map(nearest));
        } else {
            (0..boxes.len()).into_par_iter().map(nearest).collect_into_vec(&mut best);
        }
        let joined = (0..best.len()).filter(|&i| i < best[i] && best[best[i]] == i).count();
        if joined * STUCK < boxes.len() {
            for (i, with) in best.iter_mut().enumerate() {
                // The last of an odd number is its own partner.
                *with = (i ^ 1).min(boxes.len() - 1);
            }
        }
        let mut kept = 0;
        for i in 0..boxes.len() {
            let with = best[i];
            let mutual = with != i && best[with] == i;
            if mutual && with < i {
                continue;
            }
            if mutual {
                merges.push([ids[i], ids[with]]);
                (ids[kept], boxes[kept]) =
                    (count + merges.len() as u32 - 1, boxes[i].union(boxes[with]));
            } else {
                (ids[kept], boxes[kept]) = (ids[i], boxes[i]);
            }
            kept += 1;
        }
        ids.truncate(kept);
        boxes.truncate(kept);
    }
    merges
}

/// Indices by the Morton codes of the boxes' centres, 21 bits an axis in the cube around them.
fn along_curve(boxes: &[Bounds]) -> Vec<u32> {
    let all = boxes.iter().fold(Bounds::EMPTY, |all, b| {
        let centre = b.centre();
        all.union(Bounds { min: centre, max: centre })
    });
    let side = f64::from((all.max - all.min).max_element());
    let scale = if side > 0.0 { f64::from((1 << 21) - 1) / side } else { 0.0 };
    let code = |(i, b): (usize, &Bounds)| {
        let cell = (b.centre().as_dvec3() - all.min.as_dvec3()) * scale;
        let [x, y, z] = cell.to_array().map(|t| spread(t as u64));
        (x | y << 1 | z << 2, i as u32)
    };
    let mut codes: Vec<(u64, u32)> = boxes.par_iter().enumerate().map(code).collect();
    codes.par_sort_unstable();
    codes.into_iter().map(|(_, i)| i).collect()
}

/// The lower 21 bits, each followed by two zeros.
fn spread(x: u64) -> u64 {
    let mut x = x & 0x1f_ffff;
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}
