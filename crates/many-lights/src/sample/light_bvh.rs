//! Lights drawn down a tree in proportion to what may come from them.
//!
//! Based on: A. Conty Estevez and C. Kulla, "Importance sampling of many lights with adaptive tree
//! splitting", 2018: the sampling, one way down a sample.
//! Deviations: trees of different kinds of emission are drawn from by the importance of their roots;
//! nodes may have more than two children; siblings take random numbers of their own rather than one
//! that is rescaled ([`super::descend`]); importance as [`super::walked`] says. The samples of a pixel
//! are independent of each other, without the paper's adaptive splitting and without the stratified
//! numbers that renderers draw with: from the second sample on both would leave less noise.

use super::{
    descend::{Draw, draw, probabilities},
    lane::Lane,
    walked::Walked,
};
use crate::Point;
use glam::DVec3;

/// The mean over `samples` lights of what each gives over its chance.
pub(super) fn radiance(walked: &impl Walked, samples: u32, lane: &mut Lane<'_>) -> DVec3 {
    let point = lane.point;
    let worth = |node| [walked.importance(node, point)];
    let mut sum = DVec3::ZERO;
    for _ in 0..samples {
        let roots = walked.roots().iter().copied();
        let drawn = draw(walked, roots, &worth, &mut lane.random, &mut lane.visits);
        let Some(Draw { leaf, probability }) = drawn else { continue };
        lane.work.samples += 1;
        sum += lane.light(walked, leaf) / probability;
    }
    sum / f64::from(samples)
}

/// All lights that one sample may be, and their chances.
pub(super) fn chances(walked: &impl Walked, point: &Point) -> Vec<Draw> {
    probabilities(walked, walked.roots(), &|node| [walked.importance(node, point)])
}
