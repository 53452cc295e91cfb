//! Extremes of what is placed at all.

use super::{made, made::field, of_scene, world::FIELD};
use crate::stress::{
    Axis, Values, edit,
    settings::{position, words},
    world::{Kind, changed},
};
use dapple_scene::{Instance, Scene};
use glam::{DAffine3, DVec3, Vec3};

/// What [`content`] does to a field of cubes.
const CONTENTS: &[Kind] = &[
    ("as-it-is", |scene, _| scene),
    ("one-cube", |_, seed| field(1, seed)),
    ("one-square", |_, seed| field(0, seed)),
    ("points", |scene, _| flattened(scene, Vec3::ZERO)),
    ("flat", |scene, _| flattened(scene, Vec3::new(1.0, 0.0, 1.0))),
    ("inside-a-cube", |scene, _| around_the_eye(scene)),
    ("empty-view", |scene, _| edit::seen_from_behind(scene)),
    ("nothing", |scene, _| edit::without_triangles(scene)),
];

/// The first of [`CONTENTS`] that must be refused.
const EMPTY_VIEW: usize = 6;

const CONTENT_WORDS: [&str; CONTENTS.len()] = words(CONTENTS);

/// The axis.
pub fn content() -> Axis {
    Axis {
        must_refuse: |value| position(value) >= EMPTY_VIEW,
        ..of_scene(
            "content",
            "cubes before a wall; one of them, or none; half of them of no size, or of none upwards; \
             all of them around a cube that holds the eye; a camera that sees nothing, and nothing \
             at all, which must be refused",
            Values::Words(&CONTENT_WORDS),
            0.0,
            super::made(|value, case| changed(CONTENTS, field(FIELD, case.seed), value, case.seed)),
        )
    }
}

/// Every second cube of a mesh whose corners lie at one point, or in a plane.
fn flattened(mut scene: Scene, by: Vec3) -> Scene {
    let mut flat = scene.meshes[made::CUBE as usize].clone();
    for position in &mut flat.positions {
        *position *= by;
    }
    scene.meshes.push(flat);
    let mesh = scene.meshes.len() as u32 - 1;
    let cubes = scene.instances.iter_mut().filter(|instance| instance.mesh == made::CUBE);
    for instance in cubes.step_by(2) {
        instance.mesh = mesh;
    }
    scene
}

/// A cube that holds all places of the camera and hides all else.
fn around_the_eye(mut scene: Scene) -> Scene {
    let transform = DAffine3::from_scale(DVec3::splat(1.5));
    scene.instances.push(Instance { mesh: made::CUBE, transform });
    scene
}
