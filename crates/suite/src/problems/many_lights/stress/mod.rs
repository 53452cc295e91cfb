//! The problem's extremes. Each axis says what is pushed, from where, and how much worse than there
//! counts as broken. Light that is no number or less than none is a violation on every axis, and so
//! is the mean of an unbiased technique that misses the truth.
//!
//! `world` pushes the scene, the image and the camera's steps, `lights` what lights are, `places`
//! where they are, `content` what there is at all, `walls` what hides lights by a hair, `knobs` the
//! settings; `bad` is input that must be refused. `made` has the worlds that are made for it.

mod bad;
mod content;
mod knobs;
mod lights;
mod made;
mod places;
#[cfg(test)]
mod tests;
mod walls;
mod world;

use super::{LightsCase, ManyLights, input::Input};
use crate::{
    case::Case,
    stress::{Axis, Criterion, Prepare, Values, settings::Usual},
};

/// The extremes.
pub fn axes() -> Vec<Axis> {
    [
        world::axes(),
        lights::axes(),
        places::axes(),
        vec![content::content()],
        walls::axes(),
        knobs::axes(),
        bad::axes(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// A thousandth of a measured case's evaluations: a small image, of which all is truth.
const CHEAP: &[(&str, &str)] = &[("width", "24"), ("frames", "2"), ("truth_pixels", "512")];

/// A city's lights are thousands: fewer pixels.
const CITY: &[(&str, &str)] = &[("width", "16"), ("frames", "1"), ("truth_pixels", "144")];

/// Enough frames for what is remembered to matter.
const STEPS: &[(&str, &str)] = &[("width", "24"), ("frames", "6"), ("truth_pixels", "64")];

/// The same question in other units: the same light, but for a cut or a draw that rounding turns.
const UNCHANGED: Criterion = Criterion { metric: "error_p99", times: 1.25, plus: 0.5 / 255.0 };

/// Another question of the same total light: what is hard differs from world to world, and what
/// draws by chance draws others, but three times the error is another technique.
const HARDER: Criterion = Criterion { metric: "error_p99", times: 3.0, plus: 2.0 / 255.0 };

/// Another setting: twice the error at the usual one, or what nobody sees.
const GIVEN_UP: Criterion = Criterion { metric: "error_p99", times: 2.0, plus: 2.0 / 255.0 };

const USUAL: Usual = Usual { problem: &ManyLights, parameters: CHEAP, criterion: HARDER };
const SAME: Usual = Usual { criterion: UNCHANGED, ..USUAL };

/// An axis of lights and surfaces alone: every technique is pushed, as it is.
fn of_input(
    id: &'static str,
    help: &'static str,
    values: Values,
    home: f64,
    prepare: Prepare,
) -> Axis {
    Axis { prepare, ..USUAL.axis(id, help, values, home) }
}

/// Lights and surfaces of the axis's own, along their only path, whatever the case's.
fn made(make: fn(f64, &Case) -> Input) -> Prepare {
    Box::new(move |case, value, gpu| {
        let input = known(make(value, case));
        input.scene.validate()?;
        Ok(Box::new(LightsCase::of(input, &first_view(case), gpu)?))
    })
}

/// Random lights, of a case whose parameters are changed.
fn of_cloud(change: fn(&mut Case, f64)) -> Prepare {
    Box::new(move |case, value, gpu| {
        let mut case = first_view(case);
        change(&mut case, value);
        let input = known(made::cloud(made::LIGHTS, case.seed));
        Ok(Box::new(LightsCase::of(input, &case, gpu)?))
    })
}

/// The case with the first path that there is.
fn first_view(case: &Case) -> Case {
    Case { view: String::new(), ..case.clone() }
}

/// What was changed is known by what it has become: the truth is stored under that.
fn known(input: Input) -> Input {
    let mut hasher = blake3::Hasher::new();
    hasher.update(input.scene.hash().as_bytes());
    for light in &input.lights {
        hasher.update(format!("{light:?}").as_bytes());
    }
    Input { hash: hasher.finalize().to_hex()[..32].into(), ..input }
}
