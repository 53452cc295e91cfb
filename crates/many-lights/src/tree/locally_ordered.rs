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
    along::Along,
    cluster::{Cluster, Metric},
    shape::Merge,
};
use glam::DVec3;
use obvhs::ploc::morton::morton_encode_u64_unorm;
use rayon::prelude::*;

/// A pass that joins fewer than one cluster in so many counts as stuck.
const STUCK: usize = 32;
/// Clusters that one thread looks at in a row.
const PIECE: usize = 1024;

/// All joins, in order; the same for any number of threads.
pub(super) fn merges(metric: &Metric, lights: Vec<Cluster>) -> Vec<Merge> {
    let count = lights.len() as u32;
    let around = cube(&lights);
    let mut ids = along_curve(&lights, around);
    let mut clusters = Along::new(metric, &lights, &ids, around);
    drop(lights);
    let mut merges: Vec<Merge> = Vec::with_capacity(ids.len());
    let mut best: Vec<u32> = vec![0; ids.len()];
    while clusters.len() > 1 {
        let len = clusters.len();
        best.truncate(len);
        let pieces = best.par_chunks_mut(PIECE).enumerate();
        pieces.for_each(|(piece, best)| clusters.nearest(piece * PIECE, best));
        let mutual = |best: &[u32], i: usize| best[best[i] as usize] as usize == i;
        let joined = (0..len).filter(|&i| i < best[i] as usize && mutual(&best, i)).count();
        if joined * STUCK < len {
            for (i, with) in best.iter_mut().enumerate() {
                // The last of an odd number is its own partner.
                *with = (i ^ 1).min(len - 1) as u32;
            }
        }
        let mut kept = 0;
        for i in 0..len {
            let with = best[i] as usize;
            let mutual = with != i && mutual(&best, i);
            if mutual && with < i {
                continue;
            }
            if mutual {
                merges.push([ids[i], ids[with]]);
                ids[kept] = count + merges.len() as u32 - 1;
                clusters.put_joined(kept, i, with);
            } else {
                ids[kept] = ids[i];
                clusters.put(kept, i);
            }
            kept += 1;
        }
        ids.truncate(kept);
        clusters.truncate(kept);
    }
    merges
}

/// The cube around all middles: lower corner and side.
fn cube(clusters: &[Cluster]) -> (DVec3, f64) {
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for cluster in clusters {
        (min, max) = (min.min(cluster.min), max.max(cluster.max));
    }
    (min, (max - min).max_element())
}

/// Numbers by the Morton codes of the boxes' middles, 21 bits an axis in the cube around them.
fn along_curve(clusters: &[Cluster], (min, side): (DVec3, f64)) -> Vec<u32> {
    let scale = if side > 0.0 { 0.5 / side } else { 0.0 };
    let code = |(id, cluster): (u32, &Cluster)| {
        (morton_encode_u64_unorm((cluster.middle() - 2.0 * min) * scale), id)
    };
    let mut codes: Vec<(u64, u32)> =
        clusters.par_iter().enumerate().map(|(id, c)| code((id as u32, c))).collect();
    codes.par_sort_unstable();
    codes.into_iter().map(|(_, id)| id).collect()
}
