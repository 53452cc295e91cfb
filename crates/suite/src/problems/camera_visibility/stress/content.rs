//! Extremes of what is placed at all.

use super::{made, made::field, of_scene, world::FIELD};
use crate::{
    case::Case,
    stress::{Axis, Values, edit, settings::position},
};
use dapple_scene::{Instance, Scene};
use glam::{DAffine3, DVec3, Vec3};

/// What [`content`] does to a field of cubes.
type Content = (&'static str, fn(Scene, &Case) -> Scene);

const CONTENTS: &[Content] = &[
    ("as-it-is", |scene, _| scene),
    ("one-cube", |_, case| field(1, case.seed)),
    ("one-square", |_, case| field(0, case.seed)),
    ("points", |scene, _| flattened(scene, Vec3::ZERO)),
    ("flat", |scene, _| flattened(scene, Vec3::new(1.0, 0.0, 1.0))),
    ("inside-a-cube", around_the_eye),
    ("empty-view", |scene, _| edit::seen_from_behind(scene)),
    ("nothing", |scene, _| edit::without_triangles(scene)),
];

/// The first of [`CONTENTS`] that must be refused.
const EMPTY_VIEW: usize = 6;

const CONTENT_WORDS: [&str; CONTENTS.len()] = {
    let mut words = [""; CONTENTS.len()];
    let mut i = 0;
    while i < words.len() {
        words[i] = CONTENTS[i].0;
        i += 1;
    }
    words
};

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
            super::made(|value, case| {
                let (_, content) = CONTENTS.get(position(value)).unwrap_or(&CONTENTS[0]);
                content(field(FIELD, case.seed), case)
            }),
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
fn around_the_eye(mut scene: Scene, _: &Case) -> Scene {
    let transform = DAffine3::from_scale(DVec3::splat(1.5));
    scene.instances.push(Instance { mesh: made::CUBE, transform });
    scene
}
