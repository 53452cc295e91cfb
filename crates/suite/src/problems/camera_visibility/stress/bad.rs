//! Input that must be refused, each kind with a good one beside it.

use super::{USUAL, made, made::field, of_scene, world::FIELD};
use crate::stress::{
    Axis, Values,
    bad::{self, BadSetting, bad, vertices_and},
    settings::{position, words},
    world::{Kind, changed},
};
use dapple_scene::{Camera, Projection};
use glam::{DAffine3, DVec3, Vec2};

/// The axes, each pushed alone.
pub fn axes() -> Vec<Axis> {
    vec![bad_vertices(), bad_cameras(), bad::bad_settings(USUAL, SETTINGS, &SETTING_WORDS)]
}

const DAMAGES: [Kind; 10] = vertices_and([
    ("uv", |mut scene, _| {
        scene.meshes[0].uvs[0] = Vec2::NAN;
        scene
    }),
    ("placement", |mut scene, _| {
        scene.instances[0].transform = DAffine3::from_scale(DVec3::NAN);
        scene
    }),
    ("mesh", |mut scene, _| {
        scene.instances[0].mesh = 77;
        scene
    }),
    ("texture", |mut scene, _| {
        scene.textures[0].texels.clear();
        scene.textures[0].width = 3;
        scene
    }),
]);
const DAMAGE_WORDS: [&str; DAMAGES.len()] = words(&DAMAGES);

fn bad_vertices() -> Axis {
    let help = "one coordinate of a vertex; an index past the last vertex; a texture coordinate; a \
                placement; a mesh that is not there; a texture without its texels: each must be \
                refused by name";
    Axis {
        prepare: made(|value, case| changed(&DAMAGES, field(FIELD, case.seed), value, case.seed)),
        ..bad::bad_vertices(USUAL, help, &DAMAGE_WORDS)
    }
}

/// What [`bad_cameras`] does to the path's second camera.
type BadCamera = (&'static str, fn(&mut Camera));

const CAMERAS: &[BadCamera] = &[
    ("good", |_| {}),
    ("place-nan", |camera| camera.position.x = f64::NAN),
    ("place-1e30", |camera| camera.position.x = 1e30),
    ("no-direction", |camera| camera.target = camera.position),
    ("up-along", |camera| camera.up = DVec3::Z),
    ("up-zero", |camera| camera.up = DVec3::ZERO),
    ("opening-0", |camera| camera.projection = Projection::Perspective { fov_y_rad: 0.0 }),
    ("opening-180", |camera| {
        camera.projection = Projection::Perspective { fov_y_rad: std::f64::consts::PI }
    }),
    ("height-0", |camera| camera.projection = Projection::Orthographic { height_m: 0.0 }),
    ("height-inf", |camera| {
        camera.projection = Projection::Orthographic { height_m: f64::INFINITY }
    }),
];
const CAMERA_WORDS: [&str; CAMERAS.len()] = words(CAMERAS);

fn bad_cameras() -> Axis {
    Axis {
        must_refuse: bad,
        ..of_scene(
            "bad-cameras",
            "the second camera of a path: a place that is none or too far, no direction, an up that \
             gives none, an opening of none or of all, a height of none or without end",
            Values::Words(&CAMERA_WORDS),
            0.0,
            made(|value, case| {
                let mut scene = field(FIELD, case.seed);
                let (_, damage) = CAMERAS.get(position(value)).unwrap_or(&CAMERAS[0]);
                if let Some(key) = scene.paths.first_mut().and_then(|p| p.keys.get_mut(1)) {
                    damage(key);
                }
                scene
            }),
        )
    }
}

const SETTINGS: &[BadSetting] = &[
    ("good", &[]),
    ("batch-0", &[("batch", "0")]),
    ("batch-201", &[("batch", "201")]),
    ("batch-2^32+50", &[("batch", "4294967346")]),
    ("assumed-visible-61", &[("assumed_visible", "61")]),
    ("assumed-visible-minus-1", &[("assumed_visible", "-1")]),
    ("tau-1001", &[("tau", "1001")]),
    ("tau-minus-1", &[("tau", "-1")]),
    ("tight-depth-5", &[("tight_depth", "5")]),
    ("tight-area-0.5", &[("tight_area", "0.5")]),
    ("tight-area-1e39", &[("tight_area", "1e39")]),
    ("latency-minus-1", &[("latency", "-1")]),
    ("latency-2^32", &[("latency", "4294967296")]),
    ("across-0", &[("across", "0")]),
    ("across-2^32+2", &[("across", "4294967298")]),
    ("buffer-minus-1", &[("buffer", "-1")]),
    ("buffer-16385", &[("buffer", "16385")]),
    ("buffer-2^32+64", &[("buffer", "4294967360")]),
    ("occluders-minus-1", &[("occluder_triangles", "-1")]),
    ("tree-oak", &[("tree", "oak")]),
    ("coverage-guessed", &[("coverage", "guessed")]),
    ("readiness-never", &[("readiness", "never")]),
    ("jitter-maybe", &[("jitter", "maybe")]),
];
const SETTING_WORDS: [&str; SETTINGS.len()] = words(SETTINGS);
