//! Input that must be refused, each kind with a good one beside it.

use super::{USUAL, both, pushed};
use crate::stress::{
    Axis,
    bad::{self, BadSetting, vertices_and},
    edit,
    settings::words,
    world::{Kind, changed},
};
use dapple_scene::Scene;

/// The axes, each pushed alone.
pub fn axes() -> Vec<Axis> {
    vec![bad_vertices(), bad::bad_settings(USUAL, SETTINGS, &SETTING_WORDS)]
}

const DAMAGES: [Kind; 10] = vertices_and([
    ("no-triangle", |scene, _| edit::without_triangles(scene)),
    ("opacity-nan", |scene, _| with_opacity(scene, f32::NAN)),
    ("opacity-minus-0.1", |scene, _| with_opacity(scene, -0.1)),
    ("opacity-1.5", |scene, _| with_opacity(scene, 1.5)),
]);
const DAMAGE_WORDS: [&str; DAMAGES.len()] = words(&DAMAGES);

fn with_opacity(mut scene: Scene, opacity: f32) -> Scene {
    if let Some(material) = scene.materials.first_mut() {
        material.opacity = opacity;
    }
    scene
}

fn bad_vertices() -> Axis {
    let help = "one coordinate of a vertex; an index past the last vertex; no triangle at all; an \
                opacity that is none: each must be refused by name";
    Axis {
        prepare: pushed(|loaded, value, case| {
            both(loaded, |scene| changed(&DAMAGES, scene, value, case.seed))
        }),
        ..bad::bad_vertices(USUAL, help, &DAMAGE_WORDS)
    }
}

const SETTINGS: &[BadSetting] = &[
    ("good", &[]),
    ("map-0", &[("resolution", "0")]),
    ("map-minus-1", &[("resolution", "-1")]),
    ("map-8193", &[("resolution", "8193")]),
    ("map-2^32+64", &[("resolution", "4294967360")]),
    ("bias-minus-1e-3", &[("bias", "-1e-3")]),
    // Infinite in f32.
    ("bias-1e39", &[("bias", "1e39")]),
    ("weight-0", &[("opaque", "weight"), ("opaque_weight", "0")]),
    ("layers-0", &[("layers", "0")]),
    ("layers-257", &[("layers", "257")]),
    ("lambda-1.5", &[("lambda", "1.5")]),
    ("lambda-minus-0.5", &[("lambda", "-0.5")]),
    ("span-11", &[("span", "11")]),
    ("growth-0.5", &[("growth", "0.5")]),
    ("nodes-1", &[("nodes", "1")]),
    ("samples-65", &[("samples", "65")]),
    ("pairs-16", &[("pairs", "16")]),
    ("moment-bias-0.6", &[("moment_bias", "0.6")]),
    ("tolerance-minus-0.1", &[("tolerance", "-0.1")]),
];
const SETTING_WORDS: [&str; SETTINGS.len()] = words(SETTINGS);
