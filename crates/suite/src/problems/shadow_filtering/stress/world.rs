//! Extremes of the scene, its light, and the numbers they are kept in.

use super::{HARDER, SAME, USUAL, pushed};
use crate::{
    knob::Get,
    problem::Setting,
    problems::shadow_filtering::given::Given,
    stress::{
        Axis, Criterion, Values, edit,
        settings::{position, with, words},
        world::{self, Kind, changed},
    },
};

/// The axes, each pushed alone.
pub fn axes() -> Vec<Axis> {
    vec![scale(), offset(), offset_f32(), depth_range(), grazing(), degenerate(), content()]
}

fn scale() -> Axis {
    let help = "all lengths of the scene times this; the shadow is the same";
    let scaled = pushed(|scene, value, _| (edit::scaled(scene, value), Given::default()));
    world::scale(SAME, help, scaled)
}

fn offset() -> Axis {
    let help = "distance of the scene from the origin in its own radii, by placements in f64: \
                tests the way to the map; vertices keep their bits";
    let moved = pushed(|scene, value, _| (edit::moved(scene, value), Given::default()));
    world::offset(SAME, help, moved)
}

fn offset_f32() -> Axis {
    let help = "the same where maps and receivers have world positions in f32, against the truth \
                of the scene as it is: what a renderer without placements in f64 loses";
    let moved = pushed(|scene, value, _| {
        let scene = edit::moved(scene, value);
        let single_precision = Some(edit::in_single_precision(scene.clone()));
        (scene, Given { single_precision, ..Given::default() })
    });
    Axis { id: "offset-f32", ..world::offset(SAME, help, moved) }
}

fn depth_range() -> Axis {
    let help = "depth range of the map over the scene's own: the near plane moves towards the sun, \
                as for a distant occluder (a spot's far plane, away from it); below 1 it clips. \
                The bias stays the same length";
    let ranged =
        pushed(|scene, value, _| (scene, Given { depth_range: value, ..Given::default() }));
    Axis { setting: Box::new(bias_of_one_length), ..world::depth_range(USUAL, help, ranged) }
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
        unit: "degrees",
        prepare: pushed(|scene, value, _| {
            let given = Given { least_n_dot_l: LEAST_GRAZING, ..Given::default() };
            (edit::lit_at(scene, value), given)
        }),
        ..USUAL.axis(
            "grazing",
            "angle of the light to the vertical; receivers are counted up to 89.99 degrees from \
             their normal, not up to 87 as elsewhere",
            Values::Linear { least: 0.0, greatest: 89.9, steps: 9 },
            30.0,
        )
    }
}

fn degenerate() -> Axis {
    let help = "triangles without area added to the largest mesh: a corner three times, a corner \
                twice, corners on a line; nothing may change";
    let added = pushed(|scene, value, case| {
        (edit::with_degenerate_triangles(scene, value as u32, case.seed), Given::default())
    });
    world::degenerate(SAME, help, added)
}

const CONTENTS: &[Kind] = &[
    ("as-it-is", |scene, _| scene),
    ("one-depth", |scene, _| edit::one_depth(scene)),
    ("confetti-1000", |scene, seed| edit::with_confetti(scene, 1_000, seed)),
    ("confetti-30000", |scene, seed| edit::with_confetti(scene, 30_000, seed)),
    ("empty-view", |scene, _| edit::seen_from_behind(scene)),
];
const CONTENT_WORDS: [&str; CONTENTS.len()] = words(CONTENTS);

/// The one of [`CONTENTS`] that must be refused.
const EMPTY_VIEW: usize = 4;

fn content() -> Axis {
    Axis {
        // Much harder where it is not much easier: twice the error still says which way the light
        // falls.
        criterion: Criterion { times: 2.0, ..HARDER },
        must_refuse: |value| position(value) == EMPTY_VIEW,
        prepare: pushed(|scene, value, case| {
            (changed(CONTENTS, scene, value, case.seed), Given::default())
        }),
        ..USUAL.axis(
            "content",
            "the scene; one square that faces the light, so that every depth is the same; 1,000 \
             and 30,000 small squares strewn over the scene, so that windows hold many depths; a \
             camera that sees nothing, which must be refused",
            Values::Words(&CONTENT_WORDS),
            0.0,
        )
    }
}
