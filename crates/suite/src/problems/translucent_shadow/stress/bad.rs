//! Input that must be refused, each kind with a good one beside it.

use super::{CHEAP, FORMS, HARDER, both, pushed, unpushed};
use crate::{
    problem::Setting,
    stress::{
        Axis, Values, edit,
        settings::{as_it_is, position, with},
    },
};
use dapple_scene::Scene;
use serde_json::Value;

/// The axes, each pushed alone.
pub fn axes() -> Vec<Axis> {
    vec![bad_vertices(), bad_settings()]
}

/// All but the first word are bad.
fn bad(value: f64) -> bool {
    position(value) > 0
}

/// What [`bad_vertices`] does to the scene, by the position of the word.
const DAMAGES: &[fn(Scene) -> Scene] = &[
    |scene| scene,
    |scene| edit::with_coordinate(scene, f32::NAN),
    |scene| edit::with_coordinate(scene, f32::INFINITY),
    |scene| edit::with_coordinate(scene, f32::NEG_INFINITY),
    |scene| edit::with_coordinate(scene, 1e38),
    edit::with_missing_vertex,
    edit::without_triangles,
    |scene| with_opacity(scene, f32::NAN),
    |scene| with_opacity(scene, -0.1),
    |scene| with_opacity(scene, 1.5),
];

fn with_opacity(mut scene: Scene, opacity: f32) -> Scene {
    if let Some(material) = scene.materials.first_mut() {
        material.opacity = opacity;
    }
    scene
}

fn bad_vertices() -> Axis {
    Axis {
        id: "bad-vertices",
        unit: "",
        help: "one coordinate of a vertex; an index past the last vertex; no triangle at all; an \
               opacity that is none: each must be refused by name",
        values: Values::Words(&[
            "good",
            "nan",
            "+inf",
            "-inf",
            "1e38",
            "index",
            "no-triangle",
            "opacity-nan",
            "opacity-minus-0.1",
            "opacity-1.5",
        ]),
        home: 0.0,
        parameters: CHEAP,
        forms: FORMS,
        criterion: HARDER,
        must_refuse: bad,
        prepare: pushed(|loaded, value, _| {
            both(loaded, DAMAGES.get(position(value)).unwrap_or(&DAMAGES[0]))
        }),
        setting: as_it_is,
    }
}

/// Knob and value by the position of the word; the first changes nothing.
fn bad_knob(value: f64) -> Option<(&'static str, Value)> {
    Some(match position(value) {
        1 => ("resolution", 0.into()),
        2 => ("resolution", (-1).into()),
        3 => ("resolution", 8_193.into()),
        4 => ("resolution", ((1_i64 << 32) + 64).into()),
        5 => ("bias", (-1e-3).into()),
        // Infinite in f32.
        6 => ("bias", 1e39.into()),
        7 => ("opaque_weight", 0.into()),
        8 => ("layers", 0.into()),
        9 => ("layers", 257.into()),
        10 => ("lambda", 1.5.into()),
        11 => ("lambda", (-0.5).into()),
        12 => ("span", 11.into()),
        13 => ("growth", 0.5.into()),
        14 => ("nodes", 1.into()),
        15 => ("samples", 65.into()),
        16 => ("pairs", 16.into()),
        17 => ("moment_bias", 0.6.into()),
        18 => ("tolerance", (-0.1).into()),
        _ => return None,
    })
}

fn bad_settings() -> Axis {
    Axis {
        id: "bad-settings",
        unit: "",
        help: "a setting that no technique can have, each to be refused by name",
        values: Values::Words(&[
            "good",
            "map-0",
            "map-minus-1",
            "map-8193",
            "map-2^32+64",
            "bias-minus-1e-3",
            "bias-1e39",
            "weight-0",
            "layers-0",
            "layers-257",
            "lambda-1.5",
            "lambda-minus-0.5",
            "span-11",
            "growth-0.5",
            "nodes-1",
            "samples-65",
            "pairs-16",
            "moment-bias-0.6",
            "tolerance-minus-0.1",
        ]),
        home: 0.0,
        parameters: CHEAP,
        forms: FORMS,
        criterion: HARDER,
        must_refuse: bad,
        prepare: unpushed(),
        setting: |setting: &Setting, value| match bad_knob(value) {
            Some(("opaque_weight", bad)) => {
                with(&with(setting, "opaque", "weight")?, "opaque_weight", bad)
            }
            Some((knob, bad)) => with(setting, knob, bad),
            None => Some(setting.clone()),
        },
    }
}
