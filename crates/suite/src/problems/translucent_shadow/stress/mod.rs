//! The problem's extremes. Each axis says what is pushed, from where, and how much worse than there
//! counts as broken.
//!
//! `world` pushes the scene and its light, `column` the number and thickness of surfaces behind one
//! another, `knobs` the settings and the window; `bad` is input that must be refused.

mod bad;
mod column;
mod knobs;
#[cfg(test)]
mod tests;
mod world;

use super::{
    TranslucentCase, TranslucentShadow,
    scene::{self, Loaded, Wishes},
};
use crate::{
    SuiteError,
    case::Case,
    problems::shadow_filtering::given::Given,
    stress::{Axis, Criterion, Prepare, settings::Usual},
};
use dapple_scene::Scene;

/// The extremes.
pub fn axes() -> Vec<Axis> {
    let mut axes = world::axes();
    axes.extend(column::axes());
    axes.extend(knobs::axes());
    axes.extend(bad::axes());
    axes
}

/// A few percent of a measured case's receivers and rays: the noise that few rays leave is the same
/// at every value of an axis, and adds to each error alike.
const CHEAP: &[(&str, &str)] = &[("width", "96"), ("truth_rays", "2")];

/// The same question: the answer must not change. What is allowed is what a few rays that pass an
/// edge on the other side, or a few texels, make of it; well below the 0.03 that is the tightest
/// level of the problem's fronts.
const UNCHANGED: Criterion = Criterion { metric: "rmse", times: 1.0, plus: 0.005 };

/// Another question, which may be harder: a quarter more error, and for techniques that have hardly
/// any two thirds of the tightest level of the problem's fronts. Half as much again would let those
/// with most error pass an image without any shadow.
const HARDER: Criterion = Criterion { metric: "rmse", times: 1.25, plus: 0.02 };

/// The same of what is the technique's own: against the uncompressed deep shadow map of the same
/// texels, as the map's own error, which is the same whatever is stored, would hide it.
const LAYERING: Criterion = Criterion { metric: "layering_rmse", ..HARDER };

const USUAL: Usual = Usual { problem: &TranslucentShadow, parameters: CHEAP, criterion: HARDER };
const SAME: Usual = Usual { criterion: UNCHANGED, ..USUAL };
const LAYERS: Usual = Usual { criterion: LAYERING, ..USUAL };

/// The case with its scene changed.
fn pushed(push: fn(Loaded, f64, &Case) -> Loaded) -> Prepare {
    Box::new(move |case, value, gpu| {
        let loaded = push(load(case)?, value, case);
        Ok(Box::new(TranslucentCase::of(checked(loaded)?, case, gpu)?))
    })
}

fn load(case: &Case) -> Result<Loaded, SuiteError> {
    scene::load(&case.scene, &case.view, case.seed, &Wishes::of(&case.parameters)?)
}

/// A changed scene is validated anew, and known by what it has become.
fn checked(loaded: Loaded) -> Result<Loaded, SuiteError> {
    for scene in loaded.casters.iter().chain([&loaded.seen]) {
        scene.validate()?;
    }
    Ok(Loaded { hash: loaded.seen.hash(), ..loaded })
}

/// What is seen and what casts changed alike.
fn both(loaded: Loaded, change: impl Fn(Scene) -> Scene) -> Loaded {
    Loaded { casters: loaded.casters.map(&change), seen: change(loaded.seen), ..loaded }
}
