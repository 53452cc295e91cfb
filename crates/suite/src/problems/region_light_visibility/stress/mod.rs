//! The problem's extremes. Axes of cities at night are shared with whole frames of them; `knobs` pushes
//! the settings, `bad` those that must be refused.
//!
//! On axes of the city a technique breaks when it leaves out light that a ray finds: what it keeps
//! besides is its own affair.

mod bad;
mod knobs;
#[cfg(test)]
mod tests;

use super::{RegionCase, RegionLightVisibility};
use crate::stress::{
    Axis, Criterion,
    night::{self, Posed},
    settings::Usual,
};

/// The extremes.
pub fn axes() -> Vec<Axis> {
    const SOLIDS: &[&str] = &["boxes", "runs", "bounding-boxes", "objects"];
    let regions = night::knobs::axes(POSED, GIVEN_UP, SOLIDS);
    [night::axes(POSED), regions, knobs::axes(), bad::axes()].into_iter().flatten().collect()
}

/// Few faces of a small image, and few of their lights.
const CHEAP: &[(&str, &str)] =
    &[("width", "24"), ("truth_faces", "6"), ("truth_lights", "96"), ("truth_points", "32")];

/// Another question: no light may be lost. What is not sound may lose thrice as much as at home.
const SOUND: Criterion = Criterion { metric: "false_hidden", times: 3.0, plus: 0.0 };

/// The same question in other units: what is kept though hidden, but for a tie that rounding turns.
const UNCHANGED: Criterion = Criterion { metric: "kept_hidden", times: 1.1, plus: 0.05 };

/// Another setting: half as many hidden lights again, or a tenth of all.
const GIVEN_UP: Criterion = Criterion { metric: "kept_hidden", times: 1.5, plus: 0.1 };

const USUAL: Usual = Usual { problem: &RegionLightVisibility, parameters: CHEAP, criterion: SOUND };

const POSED: Posed = Posed {
    usual: USUAL,
    unchanged: UNCHANGED,
    pose: |night, case, _| Ok(Box::new(RegionCase::of(night, case)?)),
    refuses_dark: true,
};
