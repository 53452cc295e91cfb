//! What is most alike among neighbours along a curve is joined, everywhere at once.
//!
//! Based on: D. Meister and J. Bittner, "Parallel locally-ordered clustering for bounding volume
//! hierarchy construction", 2018, section 3, with the metric of B. Walter et al., "Lightcuts: a
//! scalable approach to illumination", 2005; B. Walter et al., "Fast agglomerative clustering for
//! rendering", 2008 (two that are each other's best may be joined before others).
//! Deviations: ties, which regular cities are full of, go to the pair of the least exclusive or of its
//! places; the order of pairs is then total and symmetric, and a row of equal lights joins two by two
//! in one pass. A pass that joins few is followed by one that joins neighbours, so that passes, and
//! with them the tree's depth, stay logarithmic whatever the lights.

use super::{
    cluster::{Cluster, Metric},
    shape::Merge,
};
use glam::DVec3;
use obvhs::ploc::morton::morton_encode_u64_unorm;
use rayon::prelude::*;

/// Neighbours on either side that are looked at.
const RADIUS: usize = 16;
/// A pass that joins fewer than one cluster in so many counts as stuck.
const STUCK: usize = 32;
/// Fewer clusters are not worth the other threads.
const PARALLEL: usize = 2048;

/// A pair by its cost, then by its places; the least is joined first.
type Rank = (u64, u32, u32);

const NEVER: Rank = (u64::MAX, u32::MAX, u32::MAX);

/// All joins, in order; the same for any number of threads.
pub(super) fn merges(metric: &Metric, lights: Vec<Cluster>) -> Vec<Merge> {
    let count = lights.len() as u32;
    let mut ids = along_curve(&lights);
    let mut clusters: Vec<Cluster> = ids.iter().map(|&id| lights[id as usize]).collect();
    drop(lights);
    let mut merges: Vec<Merge> = Vec::with_capacity(clusters.len());
    let mut best: Vec<u32> = Vec::new();
    while clusters.len() > 1 {
        let nearest = |i| nearest(metric, &clusters, i) as u32;
        best.clear();
        if clusters.len() < PARALLEL {
            best.extend((0..clusters.len()).map(nearest));
        } else {
            (0..clusters.len()).into_par_iter().map(nearest).collect_into_vec(&mut best);
        }
        let mutual = |best: &[u32], i: usize| best[best[i] as usize] as usize == i;
        let joined = (0..best.len()).filter(|&i| i < best[i] as usize && mutual(&best, i)).count();
        if joined * STUCK < clusters.len() {
            for (i, with) in best.iter_mut().enumerate() {
                // The last of an odd number is its own partner.
                *with = (i ^ 1).min(clusters.len() - 1) as u32;
            }
        }
        let mut kept = 0;
        for i in 0..clusters.len() {
            let with = best[i] as usize;
            let mutual = with != i && mutual(&best, i);
            if mutual && with < i {
                continue;
            }
            if mutual {
                merges.push([ids[i], ids[with]]);
                let id = count + merges.len() as u32 - 1;
                (ids[kept], clusters[kept]) = (id, clusters[i].joined(&clusters[with]));
            } else {
                (ids[kept], clusters[kept]) = (ids[i], clusters[i]);
            }
            kept += 1;
        }
        ids.truncate(kept);
        clusters.truncate(kept);
    }
    merges
}

/// The place of the neighbour that is most like cluster `i`.
fn nearest(metric: &Metric, clusters: &[Cluster], i: usize) -> usize {
    let last = (i + RADIUS).min(clusters.len() - 1);
    let mut best = NEVER;
    for j in (i.saturating_sub(RADIUS)..=last).filter(|&j| j != i) {
        let (a, b) = (&clusters[i], &clusters[j]);
        if metric.exceeds(a, b, f64::from_bits(best.0)) {
            continue;
        }
        // Costs are not negative: their bits are in their order.
        best = best.min((metric.cost(a, b).to_bits(), (i ^ j) as u32, i.min(j) as u32));
    }
    if best == NEVER { i } else { best.1 as usize ^ i }
}

/// Numbers by the Morton codes of the boxes' middles, 21 bits an axis in the cube around them.
fn along_curve(clusters: &[Cluster]) -> Vec<u32> {
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for cluster in clusters {
        (min, max) = (min.min(cluster.middle()), max.max(cluster.middle()));
    }
    let side = (max - min).max_element();
    let scale = if side > 0.0 { 1.0 / side } else { 0.0 };
    let code = |(id, cluster): (u32, &Cluster)| {
        (morton_encode_u64_unorm((cluster.middle() - min) * scale), id)
    };
    let mut codes: Vec<(u64, u32)> =
        clusters.par_iter().enumerate().map(|(id, c)| code((id as u32, c))).collect();
    codes.par_sort_unstable();
    codes.into_iter().map(|(_, id)| id).collect()
}
