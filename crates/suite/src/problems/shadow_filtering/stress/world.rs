//! Extremes of the scene, its light, and the numbers they are kept in.

use super::{CHEAP, FORMS, HARDER, UNCHANGED, pushed};
use crate::{
    knob::Get,
    problem::Setting,
    problems::shadow_filtering::given::Given,
    stress::{
        Axis, Criterion, Values, edit,
        settings::{as_it_is, never, position, with},
    },
};
use dapple_scene::Scene;

/// The axes, each pushed alone.
pub fn axes() -> Vec<Axis> {
    vec![scale(), offset(), offset_f32(), depth_range(), grazing(), degenerate(), content()]
}

fn scale() -> Axis {
    Axis {
        id: "scale",
        unit: "",
        help: "all lengths of the scene times this; the shadow is the same",
        values: Values::Log { least: 1e-6, greatest: 1e6, per_decade: 1 },
        home: 1.0,
        parameters: CHEAP,
        forms: FORMS,
        criterion: UNCHANGED,
        must_refuse: never,
        prepare: pushed(|scene, value, _| (edit::scaled(scene, value), Given::default())),
        setting: as_it_is,
    }
}

fn offset() -> Axis {
    Axis {
        id: "offset",
        unit: "radii",
        help: "distance of the scene from the origin in its own radii, by placements in f64: \
               tests the way to the map; vertices keep their bits",
        values: Values::FromZero { least: 1.0, greatest: 1e7, per_decade: 1 },
        home: 0.0,
        parameters: CHEAP,
        forms: FORMS,
        criterion: UNCHANGED,
        must_refuse: never,
        prepare: pushed(|scene, value, _| (edit::moved(scene, value), Given::default())),
        setting: as_it_is,
    }
}

fn offset_f32() -> Axis {
    Axis {
        id: "offset-f32",
        unit: "radii",
        help: "the same where maps and receivers have world positions in f32, against the truth \
               of the scene as it is: what a renderer without placements in f64 loses",
        values: Values::FromZero { least: 1.0, greatest: 1e7, per_decade: 1 },
        home: 0.0,
        parameters: CHEAP,
        forms: FORMS,
        criterion: UNCHANGED,
        must_refuse: never,
        prepare: pushed(|scene, value, _| {
            let scene = edit::moved(scene, value);
            let single_precision = Some(edit::in_single_precision(scene.clone()));
            (scene, Given { single_precision, ..Given::default() })
        }),
        setting: as_it_is,
    }
}

fn depth_range() -> Axis {
    Axis {
        id: "depth-range",
        unit: "",
        help: "depth range of the map over the scene's own: the near plane moves towards the sun, \
               as for a distant occluder (a spot's far plane, away from it); below 1 it clips. \
               The bias stays the same length",
        values: Values::Log { least: 1e-3, greatest: 1e6, per_decade: 1 },
        home: 1.0,
        parameters: CHEAP,
        forms: FORMS,
        criterion: HARDER,
        must_refuse: never,
        prepare: pushed(|scene, value, _| {
            (scene, Given { depth_range: value, ..Given::default() })
        }),
        setting: bias_of_one_length,
    }
}

/// The bias is measured in the scene by whoever sets it, and rounding has nothing to do with it:
/// left as a share of the range it would hide all else from the first decade on.
fn bias_of_one_length(setting: &Setting, range: f64) -> Option<Setting> {
    let bias = setting.knobs.float("bias").ok()?;
    with(setting, "bias", (bias / range).min(1.0))
}

/// Cosine of 89.99 degrees: at the axis's end the ground still takes part.
const LEAST_GRAZING: f64 = 1.7e-4;

fn grazing() -> Axis {
    Axis {
        id: "grazing",
        unit: "degrees",
        help: "angle of the light to the vertical; receivers are counted up to 89.99 degrees from \
               their normal, not up to 87 as elsewhere",
        values: Values::Linear { least: 0.0, greatest: 89.9, steps: 9 },
        home: 30.0,
        parameters: CHEAP,
        forms: FORMS,
        criterion: HARDER,
        must_refuse: never,
        prepare: pushed(|scene, value, _| {
            let given = Given { least_n_dot_l: LEAST_GRAZING, ..Given::default() };
            (edit::lit_at(scene, value), given)
        }),
        setting: as_it_is,
    }
}

fn degenerate() -> Axis {
    Axis {
        id: "degenerate",
        unit: "triangles",
        help: "triangles without area added to the largest mesh: a corner three times, a corner \
               twice, corners on a line; nothing may change",
        values: Values::Whole { least: 0, greatest: 100_000, per_decade: 1 },
        home: 0.0,
        parameters: CHEAP,
        forms: FORMS,
        criterion: UNCHANGED,
        must_refuse: never,
        prepare: pushed(|scene, value, case| {
            let count = value as u32;
            (edit::with_degenerate_triangles(scene, count, case.seed), Given::default())
        }),
        setting: as_it_is,
    }
}

/// What [`content`] puts in place of the scene, by the position of the word.
type Content = fn(Scene, u64) -> Scene;

const CONTENTS: &[Content] = &[
    |scene, _| scene,
    |scene, _| edit::one_depth(scene),
    |scene, seed| edit::with_confetti(scene, 1_000, seed),
    |scene, seed| edit::with_confetti(scene, 30_000, seed),
    |scene, _| edit::seen_from_behind(scene),
];

/// Word of [`CONTENTS`] for a camera that sees nothing.
const EMPTY_VIEW: usize = 4;

fn content() -> Axis {
    Axis {
        id: "content",
        unit: "",
        help: "the scene; one square that faces the light, so that every depth is the same; 1,000 \
               and 30,000 small squares strewn over the scene, so that windows hold many depths; a \
               camera that sees nothing, which must be refused",
        values: Values::Words(&[
            "as-it-is",
            "one-depth",
            "confetti-1000",
            "confetti-30000",
            "empty-view",
        ]),
        home: 0.0,
        parameters: CHEAP,
        forms: FORMS,
        // Much harder where it is not much easier: twice the error still says which way the light
        // falls.
        criterion: Criterion { times: 2.0, ..HARDER },
        must_refuse: |value| position(value) == EMPTY_VIEW,
        prepare: pushed(|scene, value, case| {
            let content = CONTENTS.get(position(value)).unwrap_or(&CONTENTS[0]);
            (content(scene, case.seed), Given::default())
        }),
        setting: as_it_is,
    }
}
