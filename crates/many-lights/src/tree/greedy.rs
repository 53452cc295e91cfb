//! The best of all pairs is joined first.
//!
//! Based on: B. Walter et al., "Lightcuts: a scalable approach to illumination", 2005, section 3
//! (what is joined), and B. Walter et al., "Fast agglomerative clustering for rendering", 2008,
//! section 3 (a heap of best partners, found in a tree that bounds the metric from below).
//! Deviations: ties go to the pair of the least light numbers, clusters counting after all lights in
//! the order of their making; the order of pairs is then total, and every join is the least pair.

use super::{
    cluster::{Cluster, Metric},
    nearest::{Partner, Partners},
    shape::Merge,
};
use std::{cmp::Reverse, collections::BinaryHeap};

/// All joins, in order.
pub(super) fn merges(metric: &Metric, lights: Vec<Cluster>) -> Vec<Merge> {
    let count = lights.len();
    let mut merges: Vec<Merge> = Vec::with_capacity(count);
    let mut partners = Partners::new(metric, lights);
    let mut heap: BinaryHeap<Reverse<(Partner, u32)>> =
        (0..count as u32).filter_map(|id| Some(Reverse((partners.best(id)?, id)))).collect();
    while merges.len() + 1 < count {
        // Every pair is known to the younger of the two, whose entry is at most that pair: what is on
        // top and alive is the least of all.
        let Some(Reverse((partner, id))) = heap.pop() else { break };
        if !partners.is_alive(id) {
            continue;
        }
        let other = partner.other(id);
        let next = if partners.is_alive(other) {
            merges.push([partner.low, partner.high]);
            partners.join(partner.low, partner.high)
        } else {
            id
        };
        if let Some(best) = partners.best(next) {
            heap.push(Reverse((best, next)));
        }
    }
    merges
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::Emission;
    use glam::DVec3;
    use proptest::prelude::*;

    /// By definition.
    fn by_definition(metric: &Metric, lights: &[Cluster]) -> Vec<Merge> {
        let mut alive: Vec<(u32, Cluster)> = (0..).zip(lights.iter().copied()).collect();
        let mut merges = Vec::new();
        while alive.len() > 1 {
            let mut least = (f64::INFINITY, 0, 0);
            for i in 0..alive.len() {
                for j in i + 1..alive.len() {
                    let cost = metric.cost(&alive[i].1, &alive[j].1);
                    if cost < least.0 {
                        least = (cost, i, j);
                    }
                }
            }
            let (_, i, j) = least;
            let (high, second) = alive.remove(j);
            let (low, first) = alive.remove(i);
            merges.push([low, high]);
            // Clusters stay in the order of their numbers: the first of equal pairs is the least.
            alive.push(((lights.len() + merges.len() - 1) as u32, first.joined(&second)));
        }
        merges
    }

    fn any() -> impl Strategy<Value = Cluster> {
        let coordinate = prop_oneof![(0..4_u8).prop_map(f64::from), -1e6..1e6_f64, -1e-4..1e-4_f64];
        let axis = prop_oneof![
            Just(DVec3::X),
            Just(-DVec3::X),
            Just(DVec3::Z),
            [-1.0..1.0, -1.0..1.0, -1.0..1.0]
                .prop_map(|a| DVec3::from_array(a).normalize_or(DVec3::Y))
        ];
        let intensity = prop_oneof![Just(0.0), Just(1.0), 0.0..10.0];
        ([coordinate.clone(), coordinate.clone(), coordinate], axis, intensity).prop_map(
            |(at, axis, intensity)| {
                let at = DVec3::from_array(at);
                Cluster { min: at, max: at, intensity, axis, half: [1.0, 0.0] }
            },
        )
    }

    proptest! {
        #[test]
        fn every_join_is_the_least_pair(
            lights in prop::collection::vec(any(), 0..80), spread in prop_oneof![Just(0.0), Just(1.0), 0.0..9.0]
        ) {
            let metric = Metric::of(&lights, Emission::Oriented, spread);
            let expected = by_definition(&metric, &lights);
            prop_assert_eq!(merges(&metric, lights), expected);
        }
    }

    #[test]
    fn every_join_is_the_least_pair_of_two_hundred_and_where_all_are_equal() {
        let window = |i: u32| {
            let at = DVec3::new(f64::from(i % 20), f64::from(i / 40), f64::from(i / 20 % 2) * 9.0);
            let axis = if (i / 20).is_multiple_of(2) { DVec3::Z } else { -DVec3::Z };
            Cluster { min: at, max: at, intensity: 1.0, axis, half: [1.0, 0.0] }
        };
        let windows: Vec<_> = (0..200).map(window).collect();
        let dark: Vec<_> = windows.iter().map(|&c| Cluster { intensity: 0.0, ..c }).collect();
        let same = vec![windows[0]; 200];
        let mut differ = 0;
        for lights in [windows, dark, same] {
            let metric = Metric::of(&lights, Emission::Oriented, 1.0);
            let expected = by_definition(&metric, &lights);
            // An order that is not greedy is told apart.
            differ += usize::from(expected.iter().enumerate().any(|(i, m)| m[1] != i as u32 + 1));
            assert_eq!(merges(&metric, lights), expected);
        }
        assert!(differ > 0);
    }
}
