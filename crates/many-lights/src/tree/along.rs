//! Clusters side by side along a curve, in f32: all neighbours of one are compared at once.
//!
//! What costs least only decides which lights are joined first; nodes are fitted in f64. Places are
//! shares of about the largest side of the box around all, and intensities of about the sum of all: costs
//! are those of [`Metric`] times a constant, whatever the lights are. The factors are powers of two, so
//! that windows in rows, whose pairs cost the same, still do.
#![allow(clippy::needless_range_loop, reason = "lanes side by side become vectors")]

use super::cluster::{Cluster, Metric};
use crate::bound::branchless::{greater, lesser};
use glam::{DVec3, Vec3};
use multiversion::multiversion;

/// Neighbours on either side that are looked at.
pub(super) const RADIUS: usize = 16;

/// Neighbours on both sides.
const BOTH: usize = 2 * RADIUS;

/// Numbers of a cluster: box, intensity, axis, cosine and sine of half the half opening.
const NUMBERS: usize = 12;
const MIN: usize = 0;
const MAX: usize = 3;
const INTENSITY: usize = 6;
const AXIS: usize = 7;
const HALF: usize = 10;

/// Beyond either end: joining it costs more than any other.
const NOBODY: [f32; NUMBERS] =
    [4.0, 4.0, 4.0, 4.0, 4.0, 4.0, f32::INFINITY, 0.0, 1.0, 0.0, 1.0, 0.0];

/// Clusters in a row, with [`RADIUS`] places that hold nobody at both ends.
pub(super) struct Along {
    numbers: [Vec<f32>; NUMBERS],
    len: usize,
    /// c² of the metric, 0 where directions are nothing to it.
    c_squared: f32,
}

impl Along {
    /// `clusters` in the order of `ids`; `side` is that of the cube around their middles and `min` its
    /// lower corner.
    pub fn new(
        metric: &Metric,
        clusters: &[Cluster],
        ids: &[u32],
        (min, side): (DVec3, f64),
    ) -> Self {
        let scale = inverse(side);
        let total: f64 = clusters.iter().map(|cluster| cluster.intensity).sum();
        let share = inverse(total);
        let c_squared = (metric.c_squared * scale * scale) as f32;
        let places = ids.len() + BOTH;
        let mut along =
            Self { numbers: NOBODY.map(|number| vec![number; places]), len: ids.len(), c_squared };
        for (place, &id) in ids.iter().enumerate() {
            let cluster = &clusters[id as usize];
            let at = |corner: DVec3| ((corner - min) * scale).as_vec3().to_array();
            let ([x, y, z], [u, v, w]) = (at(cluster.min), at(cluster.max));
            let [p, q, r] = cluster.axis.as_vec3().to_array();
            let [cosine, sine] = cluster.half.map(|number| number as f32);
            let intensity = (cluster.intensity * share) as f32;
            along.set(place, [x, y, z, u, v, w, intensity, p, q, r, cosine, sine]);
        }
        along
    }

    /// Clusters.
    pub fn len(&self) -> usize {
        self.len
    }

    fn get(&self, place: usize) -> [f32; NUMBERS] {
        std::array::from_fn(|number| self.numbers[number][place + RADIUS])
    }

    fn set(&mut self, place: usize, cluster: [f32; NUMBERS]) {
        for (numbers, number) in self.numbers.iter_mut().zip(cluster) {
            numbers[place + RADIUS] = number;
        }
    }

    /// A cluster takes another place, where none is needed any more.
    pub fn put(&mut self, place: usize, from: usize) {
        if place != from {
            self.set(place, self.get(from));
        }
    }

    /// Two become one at a place.
    pub fn put_joined(&mut self, place: usize, a: usize, b: usize) {
        let joined = joined(self.get(a), self.get(b));
        self.set(place, joined);
    }

    /// Only the first `len` are left.
    pub fn truncate(&mut self, len: usize) {
        self.len = len;
        for place in len..len + RADIUS {
            self.set(place, NOBODY);
        }
        self.numbers.iter_mut().for_each(|numbers| numbers.truncate(len + BOTH));
    }

    /// The places of the neighbours that are most like clusters `first..`, itself for one that is alone.
    /// Of equally like ones, the one of the pair whose places have the least exclusive or, then of the
    /// least place: the order of pairs is total, whoever looks.
    pub fn nearest(&self, first: usize, nearest: &mut [u32]) {
        if self.c_squared > 0.0 {
            all_nearest::<true>(self, first, nearest);
        } else {
            all_nearest::<false>(self, first, nearest);
        }
    }
}

/// The greatest power of two that makes `value` at most 1; 0 for 0.
fn inverse(value: f64) -> f64 {
    if value > 0.0 { (-value.log2().ceil()).exp2() } else { 0.0 }
}

#[multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512dq+avx512vl+avx2+bmi1+lzcnt",
    "x86_64+avx2+bmi1+lzcnt",
    "x86_64+sse4.1",
))]
fn all_nearest<const TURNED: bool>(along: &Along, first: usize, nearest: &mut [u32]) {
    for (i, nearest) in (first..).zip(nearest) {
        *nearest = one_nearest::<TURNED>(along, i);
    }
}

#[inline(always)]
fn one_nearest<const TURNED: bool>(along: &Along, i: usize) -> u32 {
    let own = along.get(i);
    let [mut before, mut behind] = [[0; RADIUS]; 2];
    let c_squared = along.c_squared;
    costs::<TURNED>(along, &own, c_squared, i, &mut before);
    costs::<TURNED>(along, &own, c_squared, i + RADIUS + 1, &mut behind);
    let mut least = u32::MAX;
    for lane in 0..RADIUS {
        least = least.min(before[lane]).min(behind[lane]);
    }
    let mut equal = 0_u32;
    for lane in 0..RADIUS {
        equal |= u32::from(before[lane] == least) << lane;
        equal |= u32::from(behind[lane] == least) << (lane + RADIUS);
    }
    let mut best = (u32::MAX, u32::MAX, i as u32);
    while equal != 0 {
        let lane = equal.trailing_zeros() as usize;
        equal &= equal - 1;
        // Places from `i - RADIUS` on, without `i`.
        let shifted = i + lane + usize::from(lane >= RADIUS);
        if shifted < RADIUS || shifted - RADIUS >= along.len {
            continue;
        }
        let j = shifted - RADIUS;
        best = best.min(((i ^ j) as u32, i.min(j) as u32, j as u32));
    }
    best.2
}

/// Bits of what joining `own` with each of the clusters from padded place `from` on costs. Costs are not
/// negative: their bits are in their order. The order of the two changes nothing.
#[inline(always)]
fn costs<const TURNED: bool>(
    along: &Along,
    own: &[f32; NUMBERS],
    c_squared: f32,
    from: usize,
    costs: &mut [u32; RADIUS],
) {
    let other: [&[f32]; NUMBERS] =
        std::array::from_fn(|number| &along.numbers[number][from..from + RADIUS]);
    for lane in 0..RADIUS {
        let mut diagonal = 0.0;
        for k in 0..3 {
            let side = greater(own[MAX + k], other[MAX + k][lane])
                - lesser(own[MIN + k], other[MIN + k][lane]);
            diagonal += side * side;
        }
        if TURNED {
            let theirs = std::array::from_fn(|number| other[number][lane]);
            let open = 1.0 - cosine(own, &theirs);
            diagonal += c_squared * (open * open);
        }
        costs[lane] = ((own[INTENSITY] + other[INTENSITY][lane]) * diagonal).to_bits();
    }
}

/// Cosine of half the opening of the smallest cone that holds both.
#[inline(always)]
fn cosine(a: &[f32; NUMBERS], b: &[f32; NUMBERS]) -> f32 {
    let ([ca, sa], [cb, sb]) = ([a[HALF], a[HALF + 1]], [b[HALF], b[HALF + 1]]);
    let (mut sum, mut difference) = (0.0, 0.0);
    for k in AXIS..AXIS + 3 {
        sum += (a[k] + b[k]) * (a[k] + b[k]);
        difference += (a[k] - b[k]) * (a[k] - b[k]);
    }
    let (cd, sd) = (0.5 * sum.sqrt(), 0.5 * difference.sqrt());
    let (c, s) = (ca * cb - sa * sb, sa * cb + ca * sb);
    let (c, s) = (c * cd - s * sd, s * cd + c * sd);
    let both = if s < 0.0 { -1.0 } else { c };
    let own = lesser(ca * ca - sa * sa, cb * cb - sb * sb);
    lesser(greater(lesser(both, own), -1.0), 1.0)
}

fn joined(a: [f32; NUMBERS], b: [f32; NUMBERS]) -> [f32; NUMBERS] {
    let mut both = a;
    for k in 0..3 {
        both[MIN + k] = a[MIN + k].min(b[MIN + k]);
        both[MAX + k] = a[MAX + k].max(b[MAX + k]);
    }
    both[INTENSITY] = a[INTENSITY] + b[INTENSITY];
    // Walls are full of these.
    if a[AXIS..] == b[AXIS..] {
        return both;
    }
    let of = |c: &[f32; NUMBERS]| Cluster {
        min: DVec3::ZERO,
        max: DVec3::ZERO,
        intensity: 0.0,
        axis: Vec3::new(c[AXIS], c[AXIS + 1], c[AXIS + 2]).as_dvec3(),
        half: [c[HALF], c[HALF + 1]].map(f64::from),
    };
    let cone = of(&a).joined(&of(&b));
    both[AXIS..HALF].copy_from_slice(&cone.axis.as_vec3().to_array());
    both[HALF..].copy_from_slice(&cone.half.map(|number| number as f32));
    both
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Light, worlds};

    fn clusters(emission: crate::Emission, count: u32) -> Vec<Cluster> {
        let emissions = vec![emission];
        let cloud = worlds::Cloud { lights: count, emissions, ..worlds::Cloud::default() };
        let lights: Vec<Light> = worlds::cloud(&cloud).world.lights;
        lights.iter().map(Cluster::of).collect()
    }

    #[test]
    fn the_cheapest_neighbours_are_those_of_the_metric() {
        for emission in [crate::Emission::Omni, worlds::WINDOW] {
            for count in [1, 2, 3, 16, 17, 18, 40, 300] {
                let clusters = clusters(emission, count);
                let metric = Metric::of(&clusters, emission, 1.0);
                let ids: Vec<u32> = (0..count).collect();
                let along = Along::new(&metric, &clusters, &ids, (DVec3::ZERO, 40.0));
                let mut nearest = vec![0; clusters.len()];
                along.nearest(0, &mut nearest);
                for (i, &found) in nearest.iter().enumerate() {
                    let last = (i + RADIUS).min(clusters.len() - 1);
                    let others = (i.saturating_sub(RADIUS)..=last).filter(|&j| j != i);
                    let cost = |j: usize| metric.cost(&clusters[i], &clusters[j]);
                    let least = others.map(cost).fold(f64::INFINITY, f64::min);
                    if count == 1 {
                        assert_eq!(found, 0);
                    } else {
                        assert_ne!(found as usize, i);
                        assert!(found as usize <= last && found as usize + RADIUS >= i);
                        assert!(cost(found as usize) <= least * (1.0 + 1e-4), "{i} of {count}");
                    }
                }
            }
        }
    }

    #[test]
    fn equal_clusters_find_each_other_two_by_two() {
        let clusters = vec![clusters(worlds::WINDOW, 1)[0]; 50];
        let metric = Metric { c_squared: 1.0 };
        let ids: Vec<u32> = (0..50).collect();
        let along = Along::new(&metric, &clusters, &ids, (DVec3::ZERO, 0.0));
        let mut nearest = vec![0; 50];
        along.nearest(0, &mut nearest);
        assert!((0..50).all(|i| nearest[i as usize] == i ^ 1), "{nearest:?}");
    }
}
