//! Ways down a tree by chance.
//!
//! Every sibling after the first takes a number of its own, so that rounding cannot make draws of
//! later siblings or levels depend on each other: one number that is rescaled on its way down, as
//! published, has 24 bits in f32, and lights below a chance of 2^-24 would never be drawn.

use super::{Random, walked::Walked};
use crate::cut;

/// A light that was drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Draw {
    /// Its leaf.
    pub leaf: u32,
    /// Its chance.
    pub probability: f64,
}

/// The children of a cluster.
pub(super) fn children(walked: &impl Walked, node: u32) -> impl Iterator<Item = u32> {
    cut::children(node, |node| walked.size(node))
}

/// One of `nodes` by chance, and its chance: the mean over the N measures of its share of their sums.
/// Nothing where all are worth nothing. `visits` counts the nodes.
fn choose<const N: usize>(
    nodes: impl Iterator<Item = u32>,
    worth: &impl Fn(u32) -> [f64; N],
    random: &mut Random,
    visits: &mut u32,
) -> Option<(u32, f64)> {
    let measure = if N == 1 { 0 } else { (f64::from(random.unit()) * N as f64) as usize };
    let mut sums = [0.0; N];
    let mut chosen: Option<(u32, [f64; N])> = None;
    for (index, node) in nodes.enumerate() {
        let worth = worth(node);
        let number = if index == 0 { 0.0 } else { f64::from(random.unit()) };
        for (sum, worth) in sums.iter_mut().zip(worth) {
            *sum += worth;
        }
        *visits += 1;
        let one = worth[measure];
        if one > 0.0 && (chosen.is_none() || number * sums[measure] < one) {
            chosen = Some((node, worth));
        }
    }
    let (node, worth) = chosen?;
    Some((node, share(worth, sums)))
}

fn share<const N: usize>(worth: [f64; N], sums: [f64; N]) -> f64 {
    let share = |(worth, sum)| if worth > 0.0 { worth / sum } else { 0.0 };
    worth.into_iter().zip(sums).map(share).sum::<f64>() / N as f64
}

/// A light below one of `start`; nothing where the way ends among nodes that are worth nothing.
pub(super) fn draw<const N: usize>(
    walked: &impl Walked,
    start: impl Iterator<Item = u32>,
    worth: &impl Fn(u32) -> [f64; N],
    random: &mut Random,
    visits: &mut u32,
) -> Option<Draw> {
    let (mut node, mut probability) = choose(start, worth, random, visits)?;
    while walked.size(node) > 1 {
        let (child, share) = choose(children(walked, node), worth, random, visits)?;
        node = child;
        probability *= share;
    }
    // What underflows cannot be divided by.
    (probability > 0.0).then_some(Draw { leaf: node, probability })
}

/// The chances of all lights below `start`, for those above 0: [`draw`] enumerated. They sum to 1, less
/// the chance that nothing is drawn.
pub(super) fn probabilities<const N: usize>(
    walked: &impl Walked,
    start: &[u32],
    worth: &impl Fn(u32) -> [f64; N],
) -> Vec<Draw> {
    let mut draws = Vec::new();
    let mut groups = vec![(start.to_vec(), 1.0)];
    while let Some((nodes, reached)) = groups.pop() {
        let worths: Vec<_> = nodes.iter().map(|&node| worth(node)).collect();
        let mut sums = [0.0; N];
        for one in &worths {
            for (sum, worth) in sums.iter_mut().zip(one) {
                *sum += worth;
            }
        }
        for (&node, &one) in nodes.iter().zip(&worths) {
            if one.iter().all(|worth| *worth <= 0.0) {
                continue;
            }
            let probability = reached * share(one, sums);
            if walked.size(node) == 1 {
                draws.push(Draw { leaf: node, probability });
            } else {
                groups.push((children(walked, node).collect(), probability));
            }
        }
    }
    draws
}
