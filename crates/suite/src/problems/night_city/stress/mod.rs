//! The problem's extremes. Axes of cities at night are shared with the question which lights reach a
//! facade; `motion` pushes the camera's steps, `knobs` the settings, `bad` those that must be refused.
//! Light that is no number or less than none is a violation on every axis.
//!
//! On axes of the city a technique breaks when it takes for hidden what a pixel sees: what leaks, and
//! what that costs, is its own affair.

mod bad;
mod knobs;
mod motion;
#[cfg(test)]
mod tests;

use super::{NightCase, NightCity};
use crate::stress::{
    Axis, Criterion,
    night::{self, Posed},
    settings::Usual,
};

/// The extremes.
pub fn axes() -> Vec<Axis> {
    [
        night::axes(POSED),
        motion::axes(),
        night::knobs::axes(POSED, GIVEN_UP, &["boxes", "runs", "bounding-boxes"]),
        knobs::axes(),
        vec![bad::bad_settings()],
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// A small image, of which some is truth.
const CHEAP: &[(&str, &str)] = &[("width", "24"), ("frames", "2"), ("truth_pixels", "48")];

/// Enough frames for what is remembered to matter.
const STEPS: &[(&str, &str)] = &[("width", "20"), ("frames", "5"), ("truth_pixels", "24")];

/// Another question: no light that a pixel sees may be taken for hidden.
const SEEN: Criterion = Criterion { metric: "lost_lights", times: 1.0, plus: 0.0 };

/// The same question in other units: the same light, but for a cut or a draw that rounding turns.
const UNCHANGED: Criterion = Criterion { metric: "error_p99", times: 1.25, plus: 2.0 / 255.0 };

/// Another setting: twice the error at the usual one, or what nobody sees.
const GIVEN_UP: Criterion = Criterion { metric: "error_p99", times: 2.0, plus: 2.0 / 255.0 };

const USUAL: Usual = Usual { problem: &NightCity, parameters: CHEAP, criterion: SEEN };

const POSED: Posed = Posed {
    usual: USUAL,
    unchanged: UNCHANGED,
    pose: |night, case, gpu| Ok(Box::new(NightCase::of(night, case, gpu)?)),
    refuses_dark: false,
};
