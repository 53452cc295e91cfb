//! Extremes of settings of from-region visibility.

use super::Posed;
use crate::stress::{
    Axis, Criterion, Values,
    settings::{Changes, Usual, position, with_all, words},
};

/// The axes of knobs that all techniques of regions have; settings may give up as much as the criterion
/// says. What stands for buildings is one of `solids`.
pub fn axes(posed: Posed, given_up: Criterion, solids: &'static [&'static str]) -> Vec<Axis> {
    let knobs = Usual { criterion: given_up, ..posed.usual };
    vec![least_step(knobs), divisions(knobs), edge(knobs), occluders(posed.usual, solids)]
}

fn least_step(knobs: Usual) -> Axis {
    Axis {
        unit: "m",
        ..knobs.of_knob(
            "least_step",
            "least-step",
            "least distance of planes, from any to more than the city has",
            Values::FromZero { least: 1e-3, greatest: 1e4, per_decade: 1 },
            5.0,
        )
    }
}

/// Levels that clusters hidden in part are divided.
const DIVISIONS: &[(&str, Changes)] = &[
    ("all", &[("divisions", "-1")]),
    ("0", &[("divisions", "0")]),
    ("1", &[("divisions", "1")]),
    ("4", &[("divisions", "4")]),
    ("64", &[("divisions", "64")]),
];
const DIVISION_WORDS: [&str; DIVISIONS.len()] = words(DIVISIONS);

fn divisions(knobs: Usual) -> Axis {
    Axis {
        setting: Box::new(|setting, value| with_all(setting, DIVISIONS.get(position(value))?.1)),
        ..knobs.axis(
            "divisions",
            "levels that a cluster hidden in part is divided, down to single lights or not at all",
            Values::Words(&DIVISION_WORDS),
            0.0,
        )
    }
}

fn edge(knobs: Usual) -> Axis {
    knobs.of_knob(
        "edge",
        "edge",
        "the upper edge of shadows",
        Values::Words(&["flat", "sloped", "hull"]),
        0.0,
    )
}

/// Boxes around buildings hide what is seen: judged as changes of the city are.
fn occluders(usual: Usual, solids: &'static [&'static str]) -> Axis {
    usual.of_knob(
        "occluders",
        "occluders",
        "what stands for buildings; boxes around clusters of them are not sound",
        Values::Words(solids),
        0.0,
    )
}
