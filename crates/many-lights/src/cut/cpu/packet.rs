//! One walk for the 64 pixels of a tile: a node is loaded once, looked at by those lanes that have
//! not skipped it, and skipped when none of them goes into it. Every lane sees the nodes that it would
//! see alone, in the same order.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 3.1 (skip counts).
//! Deviations: lanes that have skipped a node wait in place, as on a device, so that rows of eight
//! become vectors; compiled once for each level of x86-64 and chosen when first called.

use super::{
    lanes::{ROWS, Row, Sum, Tile, WIDTH},
    vector,
};
use crate::{
    BoundForm, PackedNode, Point, Work,
    bound::packed::{self, PackedRegion},
    cut::{Given, Rule},
};
use glam::Vec3;
use multiversion::multiversion;
use std::array::from_fn;

/// What a walk needs beside its tile.
#[derive(Clone, Copy)]
pub(super) struct Walk<'a> {
    pub(super) nodes: &'a [PackedNode],
    pub(super) rule: Rule,
    pub(super) form: BoundForm,
    pub(super) clamp_squared: f32,
    /// For shadow rays; none are traced without.
    pub(super) shadows: Option<&'a Given>,
}

/// What a tile's pixels come out as, and what that took.
#[derive(Clone, Default)]
pub(super) struct Lit {
    pub(super) sums: [Sum; ROWS],
    /// Nodes looked at.
    pub(super) visits: [Row<u32>; ROWS],
    /// Nodes taken.
    pub(super) cut: [Row<u32>; ROWS],
    /// Bounds, lights, clusters of all lanes; shadow rays.
    pub(super) work: Work,
}

/// Lights the lanes `group` of a tile from `starts`, each by its own cut.
#[multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512dq+avx512vl+avx2+bmi1+bmi2+lzcnt+popcnt",
    "x86_64+avx2+bmi1+bmi2+lzcnt+popcnt",
    "x86_64+sse4.1+ssse3+popcnt",
))]
pub(super) fn by_pixel<const COUNT: bool>(
    walk: &Walk<'_>,
    starts: impl Iterator<Item = (u32, f32)>,
    tile: &Tile,
    group: u64,
    lit: &mut Lit,
) {
    let (relative, limit) = match walk.rule {
        Rule::Relative(epsilon) => (true, epsilon as f32),
        Rule::Absolute(threshold) => (false, threshold as f32),
    };
    for (start, hidden_below) in starts {
        let group = above(tile, group, hidden_below);
        if group == 0 {
            continue;
        }
        let end = start + walk.nodes[start as usize].size;
        // The first node that each lane looks at again.
        let mut next = lanes_of(group).map(|row| row.map(|lane| if lane { start } else { end }));
        let mut index = start;
        while index < end {
            let node = &walk.nodes[index as usize];
            let (leaf, after) = (node.size == 1, index + node.size);
            let mut goes_in = false;
            for (row, next) in next.iter_mut().enumerate() {
                if next.iter().fold(end, |a, &b| a.min(b)) > index {
                    continue;
                }
                let points = &tile.rows[row];
                let mut estimates = [Row::default(); 3];
                if relative || leaf {
                    estimates = vector::estimates(node, points, walk.clamp_squared);
                }
                // All ones and all zeros: as wide as the numbers they choose from.
                let mut active = [0_u32; WIDTH];
                for lane in 0..WIDTH {
                    active[lane] = if next[lane] <= index { u32::MAX } else { 0 };
                }
                let mut taken = active;
                if !leaf {
                    let bounds = vector::bounds(walk.form, node, points, walk.clamp_squared);
                    for lane in 0..WIDTH {
                        let [r, g, b] = estimates.map(|channel| channel[lane]);
                        let estimate = r.max(g).max(b);
                        let most = if relative { estimate + limit * estimate } else { limit };
                        taken[lane] = if bounds[lane] > most { 0 } else { active[lane] };
                    }
                }
                let (mut some, mut left) = (0, 0);
                for lane in 0..WIDTH {
                    some |= taken[lane];
                    left |= active[lane] & !taken[lane];
                    next[lane] = if taken[lane] != 0 { after } else { next[lane] };
                }
                goes_in |= left != 0;
                if COUNT {
                    lit.count(row, leaf, relative, &active, &taken);
                }
                if some == 0 {
                    continue;
                }
                if !relative && !leaf {
                    estimates = vector::estimates(node, points, walk.clamp_squared);
                }
                if let Some(given) = walk.shadows {
                    let points = &tile.points[row * WIDTH..][..WIDTH];
                    lit.work.rays += shadow(given, node, points, &taken, &mut estimates);
                }
                lit.sums[row].add(&taken, &estimates);
            }
            index = if goes_in { index + 1 } else { after };
        }
    }
}

/// Lights the lanes `group` of a tile from `starts` by one cut, made for the region that holds them.
#[multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512dq+avx512vl+avx2+bmi1+bmi2+lzcnt+popcnt",
    "x86_64+avx2+bmi1+bmi2+lzcnt+popcnt",
    "x86_64+sse4.1+ssse3+popcnt",
))]
pub(super) fn by_tile<const COUNT: bool>(
    walk: &Walk<'_>,
    starts: impl Iterator<Item = (u32, f32)>,
    tile: &Tile,
    group: u64,
    region: &PackedRegion,
    lit: &mut Lit,
) {
    let Rule::Absolute(threshold) = walk.rule else { return };
    let limit = threshold as f32;
    let lanes = lanes_of(group).map(|row| row.map(|lane| if lane { u32::MAX } else { 0 }));
    let count = u64::from(group.count_ones());
    for (start, hidden_below) in starts {
        if region.max.y <= hidden_below {
            continue;
        }
        // Lanes that are hidden wait for the others' walk.
        let above = lanes_of(above(tile, group, hidden_below));
        let above = above.map(|row| row.map(|lane| if lane { u32::MAX } else { 0 }));
        let mut index = start;
        let end = start + walk.nodes[start as usize].size;
        while index < end {
            let node = &walk.nodes[index as usize];
            let leaf = node.size == 1;
            let is_split =
                !leaf && packed::region(walk.form, node, region, walk.clamp_squared) > limit;
            let taken = !is_split;
            if COUNT {
                lit.work.bounds += u64::from(!leaf);
                lit.work.lights += if leaf { count } else { 0 };
                lit.work.clusters += if taken && !leaf { count } else { 0 };
            }
            if !taken {
                index += 1;
            } else {
                index += node.size;
            }
            for (row, lanes) in lanes.iter().enumerate() {
                if COUNT {
                    for lane in 0..WIDTH {
                        lit.visits[row][lane] += lanes[lane] & 1;
                        lit.cut[row][lane] += lanes[lane] & u32::from(taken);
                    }
                }
                if !taken || lanes.iter().all(|&lane| lane == 0) {
                    continue;
                }
                let mut estimates = vector::estimates(node, &tile.rows[row], walk.clamp_squared);
                if hidden_below > f32::NEG_INFINITY {
                    for channel in &mut estimates {
                        for lane in 0..WIDTH {
                            channel[lane] = if above[row][lane] == 0 { 0.0 } else { channel[lane] };
                        }
                    }
                }
                if let Some(given) = walk.shadows {
                    let points = &tile.points[row * WIDTH..][..WIDTH];
                    lit.work.rays += shadow(given, node, points, lanes, &mut estimates);
                }
                lit.sums[row].add(lanes, &estimates);
            }
        }
    }
}

impl Lit {
    /// What a lane came out as that walked alone.
    pub(super) fn set(&mut self, lane: usize, radiance: Vec3, visits: u32, cut: u32) {
        let (row, lane) = (lane / WIDTH, lane % WIDTH);
        self.sums[row].set(lane, radiance);
        self.visits[row][lane] = visits;
        self.cut[row][lane] = cut;
    }

    /// A row looked at a node with some of its lanes, and took it with some of those.
    #[inline(always)]
    fn count(
        &mut self,
        row: usize,
        leaf: bool,
        relative: bool,
        active: &Row<u32>,
        taken: &Row<u32>,
    ) {
        let (mut looked, mut took) = (0, 0);
        for lane in 0..WIDTH {
            self.visits[row][lane] += active[lane] & 1;
            self.cut[row][lane] += taken[lane] & 1;
            looked += active[lane] & 1;
            took += taken[lane] & 1;
        }
        if leaf {
            self.work.lights += u64::from(took);
        } else {
            self.work.bounds += u64::from(looked);
            // The relative rule estimates what it looks at.
            self.work.clusters += u64::from(if relative { looked } else { took });
        }
    }
}

/// Takes away what does not reach the points of the lanes `taken`; the rays that this took.
#[cold]
fn shadow(
    given: &Given,
    node: &PackedNode,
    points: &[Point],
    taken: &Row<u32>,
    estimates: &mut [Row; 3],
) -> u64 {
    let mut rays = 0;
    for lane in (0..WIDTH).filter(|&lane| taken[lane] != 0) {
        if estimates.iter().all(|channel| channel[lane] == 0.0) {
            continue;
        }
        rays += 1;
        if !given.sees(&points[lane], node.light) {
            estimates.iter_mut().for_each(|channel| channel[lane] = 0.0);
        }
    }
    rays
}

/// The lanes of a group whose points lie above a height.
#[inline(always)]
fn above(tile: &Tile, group: u64, height: f32) -> u64 {
    if height == f32::NEG_INFINITY {
        return group;
    }
    let lanes = Tile::lanes(group).filter(|&lane| tile.points[lane].position.y > height);
    lanes.fold(0, |group, lane| group | 1 << lane)
}

/// The bits of a group, lane by lane.
fn lanes_of(group: u64) -> [Row<bool>; ROWS] {
    from_fn(|row| from_fn(|lane| group >> (row * WIDTH + lane) & 1 == 1))
}
