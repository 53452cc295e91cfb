//! A light drawn by chance in every node of a cut.
//!
//! Based on: C. Yuksel, "Stochastic lightcuts", 2019: a cut of a fixed number of
//! nodes, always splitting the one with the largest error bound; below each a light is drawn, a child
//! by the mean of its shares of bounds at the smallest and at the largest distance. Real time:
//! D. Lin and C. Yuksel, "Real-time stochastic lightcuts", 2020: one cut for a tile, made at
//! a pixel of it that changes by chance; what can give nothing there stays in the cut, since other
//! pixels may get something from it.
//! Deviations: no light is carried over from a node to its child when a node is split, since a cut
//! is made before anything is drawn; distances are clamped from below as estimates are, in place of
//! the paper's rule for points inside of both boxes; where a pixel makes its own cut, nodes that can
//! give nothing leave it; nodes may have more than two children, and one whose children do not fit
//! stays; lights of different kinds start as nodes of their own, so that a cut holds at least one of
//! each. In real time lights' directions are bounded as in the published program's option for light
//! cones; trees are not rebuilt in a frame, nor is the result filtered.

use super::{
    descend::{Draw, children, draw, probabilities},
    lane::Lane,
    walked::Walked,
};
use crate::{Point, StochasticLightcuts};
use glam::DVec3;

/// A node of a cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slot {
    pub node: u32,
    /// Its error bound, 0 where it is not to be split.
    error: f64,
}

/// Fills `slots` with the cut at a point: never more than the settings' number and one more, or one a
/// root. `visits` counts nodes. Whether it was its size that ended it.
pub(super) fn cut(
    walked: &impl Walked,
    settings: &StochasticLightcuts,
    point: &Point,
    slots: &mut Vec<Slot>,
    visits: &mut u32,
) -> bool {
    let most = settings.cut as usize;
    let mut ended = false;
    let mut add = |slots: &mut Vec<Slot>, node| {
        *visits += 1;
        let [error, _] = worth(walked, point, node);
        // A light is exact.
        let open = if walked.size(node) == 1 { 0.0 } else { error };
        if error > 0.0 || (settings.real_time && walked.shines(node)) {
            slots.push(Slot { node, error: open });
        }
    };
    slots.clear();
    for &root in walked.roots() {
        add(slots, root);
    }
    loop {
        let mut worst = Slot { node: 0, error: 0.0 };
        let mut place = 0;
        for (index, slot) in slots.iter().enumerate() {
            if slot.error > worst.error {
                (worst, place) = (*slot, index);
            }
        }
        if worst.error == 0.0 {
            return ended;
        }
        if slots.len() >= most {
            return true;
        }
        let before = slots.len();
        for child in children(walked, worst.node) {
            add(slots, child);
            if slots.len() > most + 1 {
                break;
            }
        }
        if slots.len() > most + 1 {
            slots.truncate(before);
            slots[place].error = 0.0;
            ended = true;
        } else {
            slots.swap_remove(place);
        }
    }
}

/// How much may come from a node were all its lights as near, and as far, as its box allows. The first
/// is its error bound.
pub(super) fn worth(walked: &impl Walked, point: &Point, node: u32) -> [f64; 2] {
    let [near, far] = walked.distances_squared(node, point);
    let bound = walked.bound(node, point);
    [bound, bound * (near / far)]
}

/// The sum over the cut of what a light of each node gives over its chance.
pub(super) fn radiance(walked: &impl Walked, slots: &[Slot], lane: &mut Lane<'_>) -> DVec3 {
    let point = lane.point;
    let worth = |node| worth(walked, point, node);
    let mut sum = DVec3::ZERO;
    for slot in slots {
        if walked.size(slot.node) == 1 {
            sum += lane.light(walked, slot.node);
            continue;
        }
        let below = children(walked, slot.node);
        let drawn = draw(walked, below, &worth, &mut lane.random, &mut lane.visits);
        let Some(Draw { leaf, probability }) = drawn else { continue };
        lane.work.samples += 1;
        sum += lane.light(walked, leaf) / probability;
    }
    sum
}

/// The lights of each node of the cut, and their chances there.
pub(super) fn chances(walked: &impl Walked, slots: &[Slot], point: &Point) -> Vec<Vec<Draw>> {
    let worth = |node| worth(walked, point, node);
    slots.iter().map(|slot| probabilities(walked, &[slot.node], &worth)).collect()
}
