//! The problem's extremes. Each axis says what is pushed, from where, and how much worse than there
//! counts as broken.
//!
//! `world` pushes the scene, the light and the numbers they are kept in; `knobs` pushes settings
//! and the window; `bad` is input that must be refused.

mod bad;
mod knobs;
#[cfg(test)]
mod tests;
mod world;

use super::{ShadowCase, ShadowFiltering, given::Given};
use crate::{
    case::Case,
    scene,
    stress::{Axis, Criterion, Prepare, settings::Usual},
};
use dapple_scene::Scene;

/// The extremes.
pub fn axes() -> Vec<Axis> {
    let mut axes = world::axes();
    axes.extend(knobs::axes());
    axes.extend(bad::axes());
    axes
}

/// A quarter of the pixels and of the rays of a measured case: the noise that 16 rays leave is the
/// same at every value of an axis, and adds to each error alike.
const CHEAP: &[(&str, &str)] = &[("width", "160"), ("truth_rays", "4")];

/// The same question: the answer must not change. What is allowed is what a few rays that pass
/// an edge on the other side, or a few texels, make of it; well below the 0.02 that is the
/// tightest level of the problem's fronts.
const UNCHANGED: Criterion = Criterion { metric: "rmse", times: 1.0, plus: 0.005 };

/// Another question, which may be harder: a quarter more error, and for techniques that have hardly
/// any the tightest level of the problem's fronts. Half as much again would let those with most
/// error pass an image without any shadow.
const HARDER: Criterion = Criterion { metric: "rmse", times: 1.25, plus: 0.02 };

const USUAL: Usual = Usual { problem: &ShadowFiltering, parameters: CHEAP, criterion: HARDER };
const SAME: Usual = Usual { criterion: UNCHANGED, ..USUAL };

/// The case with its scene changed, and with what techniques are given besides it.
fn pushed(push: fn(Scene, f64, &Case) -> (Scene, Given)) -> Prepare {
    Box::new(move |case, value, gpu| {
        let loaded = scene::load(&case.scene, case.seed)?;
        let (scene, given) = push(loaded.scene, value, case);
        let loaded = scene::complete(scene, loaded.notes)?;
        Ok(Box::new(ShadowCase::given(loaded, given, case, gpu)?))
    })
}
