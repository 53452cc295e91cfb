//! Input that must be refused, each kind with a good one beside it.

use super::{CHEAP, FORMS, SEEN, made, made::field, of_scene, unpushed, world::FIELD};
use crate::{
    problem::Setting,
    stress::{
        Axis, Values, edit,
        settings::{position, with},
    },
};
use dapple_scene::{Camera, Projection, Scene};
use glam::{DAffine3, DVec3, Vec2};
use serde_json::Value;

/// The axes, each pushed alone.
pub fn axes() -> Vec<Axis> {
    vec![bad_vertices(), bad_cameras(), bad_settings()]
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
    |mut scene| {
        scene.meshes[0].uvs[0] = Vec2::NAN;
        scene
    },
    |mut scene| {
        scene.instances[0].transform = DAffine3::from_scale(DVec3::NAN);
        scene
    },
    |mut scene| {
        scene.instances[0].mesh = 77;
        scene
    },
    |mut scene| {
        scene.textures[0].texels.clear();
        scene.textures[0].width = 3;
        scene
    },
];

fn bad_vertices() -> Axis {
    Axis {
        must_refuse: bad,
        ..of_scene(
            "bad-vertices",
            "one coordinate of a vertex; an index past the last vertex; a texture coordinate; a \
             placement; a mesh that is not there; a texture without its texels: each must be \
             refused by name",
            Values::Words(&[
                "good",
                "nan",
                "+inf",
                "-inf",
                "1e38",
                "index",
                "uv",
                "placement",
                "mesh",
                "texture",
            ]),
            0.0,
            made(|value, case| {
                let damage = DAMAGES.get(position(value)).unwrap_or(&DAMAGES[0]);
                damage(field(FIELD, case.seed))
            }),
        )
    }
}

/// What [`bad_cameras`] does to the path's second camera.
const CAMERAS: &[fn(&mut Camera)] = &[
    |_| {},
    |camera| camera.position.x = f64::NAN,
    |camera| camera.position.x = 1e30,
    |camera| camera.target = camera.position,
    |camera| camera.up = DVec3::Z,
    |camera| camera.up = DVec3::ZERO,
    |camera| camera.projection = Projection::Perspective { fov_y_rad: 0.0 },
    |camera| camera.projection = Projection::Perspective { fov_y_rad: std::f64::consts::PI },
    |camera| camera.projection = Projection::Orthographic { height_m: 0.0 },
    |camera| camera.projection = Projection::Orthographic { height_m: f64::INFINITY },
];

fn bad_cameras() -> Axis {
    Axis {
        must_refuse: bad,
        ..of_scene(
            "bad-cameras",
            "the second camera of a path: a place that is none or too far, no direction, an up that \
             gives none, an opening of none or of all, a height of none or without end",
            Values::Words(&[
                "good",
                "place-nan",
                "place-1e30",
                "no-direction",
                "up-along",
                "up-zero",
                "opening-0",
                "opening-180",
                "height-0",
                "height-inf",
            ]),
            0.0,
            made(|value, case| {
                let mut scene = field(FIELD, case.seed);
                let damage = CAMERAS.get(position(value)).unwrap_or(&CAMERAS[0]);
                if let Some(key) = scene.paths.first_mut().and_then(|p| p.keys.get_mut(1)) {
                    damage(key);
                }
                scene
            }),
        )
    }
}

/// Knob and value by the position of the word; the first changes nothing.
fn bad_knob(value: f64) -> Option<(&'static str, Value)> {
    Some(match position(value) {
        1 => ("batch", 0.into()),
        2 => ("batch", 201.into()),
        3 => ("batch", ((1_i64 << 32) + 50).into()),
        4 => ("assumed_visible", 61.into()),
        5 => ("assumed_visible", (-1).into()),
        6 => ("tau", 1001.into()),
        7 => ("tau", (-1).into()),
        8 => ("tight_depth", 5.into()),
        9 => ("tight_area", 0.5.into()),
        10 => ("tight_area", 1e39.into()),
        11 => ("latency", (-1).into()),
        12 => ("latency", (1_i64 << 32).into()),
        13 => ("across", 0.into()),
        14 => ("across", ((1_i64 << 32) + 2).into()),
        15 => ("buffer", (-1).into()),
        16 => ("buffer", 16_385.into()),
        17 => ("buffer", ((1_i64 << 32) + 64).into()),
        18 => ("occluder_triangles", (-1).into()),
        19 => ("tree", "oak".into()),
        20 => ("coverage", "guessed".into()),
        21 => ("readiness", "never".into()),
        22 => ("jitter", "maybe".into()),
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
            "batch-0",
            "batch-201",
            "batch-2^32+50",
            "assumed-visible-61",
            "assumed-visible-minus-1",
            "tau-1001",
            "tau-minus-1",
            "tight-depth-5",
            "tight-area-0.5",
            "tight-area-1e39",
            "latency-minus-1",
            "latency-2^32",
            "across-0",
            "across-2^32+2",
            "buffer-minus-1",
            "buffer-16385",
            "buffer-2^32+64",
            "occluders-minus-1",
            "tree-oak",
            "coverage-guessed",
            "readiness-never",
            "jitter-maybe",
        ]),
        home: 0.0,
        parameters: CHEAP,
        forms: FORMS,
        criterion: SEEN,
        must_refuse: bad,
        prepare: unpushed(),
        setting: |setting: &Setting, value| match bad_knob(value) {
            Some((knob, bad)) => with(setting, knob, bad),
            None => Some(setting.clone()),
        },
    }
}
