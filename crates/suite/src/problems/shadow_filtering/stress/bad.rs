//! Input that must be refused, each kind with a good one beside it.

use super::{USUAL, pushed};
use crate::{
    problems::shadow_filtering::given::Given,
    stress::{
        Axis,
        bad::{self, BadSetting, vertices_and},
        edit,
        settings::words,
        world::{Kind, changed},
    },
};

/// The axes, each pushed alone.
pub fn axes() -> Vec<Axis> {
    vec![bad_vertices(), bad::bad_settings(USUAL, SETTINGS, &SETTING_WORDS)]
}

const DAMAGES: [Kind; 7] =
    vertices_and([("no-triangle", |scene, _| edit::without_triangles(scene))]);
const DAMAGE_WORDS: [&str; DAMAGES.len()] = words(&DAMAGES);

fn bad_vertices() -> Axis {
    let help = "one coordinate of a vertex; an index past the last vertex; no triangle at all: \
                each must be refused by name";
    Axis {
        prepare: pushed(|scene, value, case| {
            (changed(&DAMAGES, scene, value, case.seed), Given::default())
        }),
        ..bad::bad_vertices(USUAL, help, &DAMAGE_WORDS)
    }
}

const SETTINGS: &[BadSetting] = &[
    ("good", &[]),
    ("map-0", &[("resolution", "0")]),
    ("map-minus-1", &[("resolution", "-1")]),
    ("map-16385", &[("resolution", "16385")]),
    ("map-2^32+64", &[("resolution", "4294967360")]),
    // Infinite in f32.
    ("bias-1e39", &[("bias", "1e39")]),
    ("min-variance-2", &[("min_variance", "2.0")]),
    ("moment-bias-1", &[("moment_bias", "1.0")]),
    ("exponent-1e4", &[("exponent", "1e4")]),
    ("layers-0", &[("layers", "0")]),
    ("taps-minus-1", &[("taps", "-1")]),
];
const SETTING_WORDS: [&str; SETTINGS.len()] = words(SETTINGS);
