//! The problem's extremes. Each axis says what is pushed, from where, and how much worse than there
//! counts as broken. What an exact technique culls though it shows is a violation on every axis.
//!
//! `world` pushes the scene and the camera's kind, `content` what is placed at all, `walls` what
//! hides and what shows through, `motion` the camera's steps, `knobs` the settings; `bad` is input
//! that must be refused. `made` has the scenes that are made for it.

mod bad;
mod content;
mod knobs;
mod made;
mod motion;
#[cfg(test)]
mod tests;
mod walls;
mod world;

use super::{CameraVisibility, VisibilityCase};
use crate::{
    SuiteError,
    case::Case,
    city::{self, Loaded},
    stress::{Axis, Criterion, Prepare, Values, settings::Usual},
};
use dapple_scene::Scene;

/// The extremes.
pub fn axes() -> Vec<Axis> {
    [
        world::axes(),
        vec![content::content()],
        walls::axes(),
        motion::axes(),
        knobs::axes(),
        bad::axes(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// A sixteenth of a measured case's pixels and few of its frames.
const CHEAP: &[(&str, &str)] = &[("width", "64"), ("frames", "5"), ("truth_samples", "1")];

/// The same question: nothing that shows may be missing, as at home, and no more may be drawn than
/// what a few boxes near a limit make of it.
const UNCHANGED: Criterion = Criterion { metric: "overdraw", times: 1.02, plus: 0.02 };

/// Another question. Techniques may draw as much as they like, but nothing that shows may be missing:
/// exact techniques miss nothing at home, and approximate ones may miss a quarter more than there.
const SEEN: Criterion = Criterion { metric: "missed", times: 1.25, plus: 0.0 };

/// Another setting, which may pay less: half as many triangles for nothing again, and for techniques
/// that draw hardly any as many as are seen.
const PAYS: Criterion = Criterion { metric: "overdraw", times: 1.5, plus: 1.0 };

const USUAL: Usual = Usual { problem: &CameraVisibility, parameters: CHEAP, criterion: SEEN };
const SAME: Usual = Usual { criterion: UNCHANGED, ..USUAL };

/// An axis of the scene alone: every technique is pushed, as it is.
fn of_scene(
    id: &'static str,
    help: &'static str,
    values: Values,
    home: f64,
    prepare: Prepare,
) -> Axis {
    Axis { prepare, ..USUAL.axis(id, help, values, home) }
}

/// The case with its scene changed.
fn pushed(push: fn(Loaded, f64, &Case) -> Loaded) -> Prepare {
    Box::new(move |case, value, gpu| {
        let loaded = push(load(case)?, value, case);
        Ok(Box::new(VisibilityCase::of(checked(loaded)?, case, gpu)?))
    })
}

/// A scene of the axis's own along its only path, whatever the case's.
fn made(make: fn(f64, &Case) -> Scene) -> Prepare {
    Box::new(move |case, value, gpu| {
        let loaded = checked(of(make(value, case)))?;
        Ok(Box::new(VisibilityCase::of(loaded, &first_view(case), gpu)?))
    })
}

fn load(case: &Case) -> Result<Loaded, SuiteError> {
    city::load(&case.scene, case.seed, &case.parameters)
}

/// A scene as it is loaded from a file that is no city.
fn of(scene: Scene) -> Loaded {
    Loaded { scene, city: None, hash: String::new(), notes: Vec::new() }
}

/// The case with the first path that there is.
fn first_view(case: &Case) -> Case {
    Case { view: String::new(), ..case.clone() }
}

/// A changed scene is validated anew, and known by what it has become.
fn checked(loaded: Loaded) -> Result<Loaded, SuiteError> {
    loaded.scene.validate()?;
    Ok(Loaded { hash: loaded.scene.hash(), ..loaded })
}
