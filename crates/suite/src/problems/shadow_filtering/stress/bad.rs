//! Input that must be refused, each kind with a good one beside it.

use super::{CHEAP, FORMS, HARDER, pushed, unpushed};
use crate::{
    problem::Setting,
    problems::shadow_filtering::given::Given,
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
];

fn bad_vertices() -> Axis {
    Axis {
        id: "bad-vertices",
        unit: "",
        help: "one coordinate of a vertex; an index past the last vertex; no triangle at all: each \
               must be refused by name",
        values: Values::Words(&["good", "nan", "+inf", "-inf", "1e38", "index", "no-triangle"]),
        home: 0.0,
        parameters: CHEAP,
        forms: FORMS,
        criterion: HARDER,
        must_refuse: bad,
        prepare: pushed(|scene, value, _| {
            let damage = DAMAGES.get(position(value)).unwrap_or(&DAMAGES[0]);
            (damage(scene), Given::default())
        }),
        setting: as_it_is,
    }
}

/// Knob and value by the position of the word; the first changes nothing.
fn bad_knob(value: f64) -> Option<(&'static str, Value)> {
    Some(match position(value) {
        1 => ("resolution", 0.into()),
        2 => ("resolution", (-1).into()),
        3 => ("resolution", 16_385.into()),
        4 => ("resolution", ((1_i64 << 32) + 64).into()),
        // Infinite in f32.
        5 => ("bias", 1e39.into()),
        6 => ("min_variance", 2.0.into()),
        7 => ("moment_bias", 1.0.into()),
        8 => ("exponent", 1e4.into()),
        9 => ("layers", 0.into()),
        10 => ("taps", (-1).into()),
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
            "map-16385",
            "map-2^32+64",
            "bias-1e39",
            "min-variance-2",
            "moment-bias-1",
            "exponent-1e4",
            "layers-0",
            "taps-minus-1",
        ]),
        home: 0.0,
        parameters: CHEAP,
        forms: FORMS,
        criterion: HARDER,
        must_refuse: bad,
        prepare: unpushed(),
        setting: |setting: &Setting, value| match bad_knob(value) {
            Some((knob, bad)) => with(setting, knob, bad),
            None => Some(setting.clone()),
        },
    }
}
