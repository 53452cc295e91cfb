//! Extremes of the camera's steps.

use super::{SEEN, of_scene, pushed};
use crate::{
    case::Case,
    city::Loaded,
    knob::Get,
    stress::{Axis, Criterion, Values},
};
use dapple_scene::{Camera, CameraPath, Scene};
use glam::DQuat;

/// Enough for what a technique remembers to grow old.
const FRAMES: &[(&str, &str)] = &[("width", "64"), ("frames", "10"), ("truth_samples", "1")];

/// Other places along the way show less: drawing everything alone has 2.4 times the overdraw there.
const HARDER: Criterion = Criterion { metric: "overdraw", times: 3.0, plus: 1.0 };

/// The axes, each pushed alone.
pub fn axes() -> Vec<Axis> {
    vec![
        speed("speed", SEEN),
        speed("speed-overdraw", HARDER),
        turn("turn", SEEN),
        turn("turn-overdraw", HARDER),
    ]
}

fn speed(id: &'static str, criterion: Criterion) -> Axis {
    Axis {
        unit: "m a frame",
        criterion,
        parameters: FRAMES,
        ..of_scene(
            id,
            "the camera's way along the scene's path in a frame, from standing still to jumping \
             about; past the path's end it starts again, and a step longer than the path leads \
             anywhere",
            Values::FromZero { least: 1e-3, greatest: 1e4, per_decade: 1 },
            1.0,
            pushed(|loaded, value, case| with_path(loaded, case, |scene, i| walk(scene, value, i))),
        )
    }
}

fn turn(id: &'static str, criterion: Criterion) -> Axis {
    Axis {
        unit: "degrees a frame",
        criterion,
        parameters: FRAMES,
        ..of_scene(
            id,
            "the camera's turn about its up in a frame, on one spot",
            Values::FromZero { least: 1e-3, greatest: 180.0, per_decade: 1 },
            1.0,
            pushed(|loaded, value, case| with_path(loaded, case, |scene, i| spin(scene, value, i))),
        )
    }
}

/// The scene with one path of the case's frames.
fn with_path(
    mut loaded: Loaded,
    case: &Case,
    at: impl Fn(&Scene, u32) -> Option<Camera>,
) -> Loaded {
    let frames = case.parameters.int("frames").unwrap_or(1) as u32;
    let keys: Vec<Camera> = (0..frames).filter_map(|i| at(&loaded.scene, i)).collect();
    if !keys.is_empty() {
        let frames = keys.len() as u32;
        // By the name that the case asks for.
        let name = loaded.scene.paths.first().map_or_else(String::new, |path| path.name.clone());
        loaded.scene.paths = vec![CameraPath { name, keys, frames }];
    }
    loaded
}

/// Multiples of the golden ratio fill an interval evenly and repeat nowhere.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// Frame `index` of a walk along the first path at `speed` metres a frame.
pub(super) fn walk(scene: &Scene, speed: f64, index: u32) -> Option<Camera> {
    let path = scene.paths.first()?;
    // A fine walk: straight between its steps, and not past its keys.
    let fine = CameraPath { frames: 1000.max(path.keys.len() as u32), ..path.clone() };
    let cameras: Vec<Camera> = (0..fine.frames).filter_map(|i| fine.camera(i)).collect();
    let step = |pair: &[Camera]| pair[0].position.distance(pair[1].position);
    let length: f64 = cameras.windows(2).map(step).sum();
    let index = f64::from(index);
    // A step longer than the path leads anywhere, and not back to nearly the same place.
    let mut left = match speed < length {
        true => (speed * index) % length,
        false => length * (index * GOLDEN).fract(),
    };
    for pair in cameras.windows(2) {
        let step = step(pair);
        if left <= step && step > 0.0 {
            let t = left / step;
            return Some(Camera {
                position: pair[0].position.lerp(pair[1].position, t),
                target: pair[0].target.lerp(pair[1].target, t),
                ..pair[0].clone()
            });
        }
        left -= step;
    }
    cameras.last().cloned()
}

/// The first camera of the first path turned by `index` steps.
pub(super) fn spin(scene: &Scene, degrees: f64, index: u32) -> Option<Camera> {
    let camera = scene.paths.first()?.camera(0)?;
    let angle = (degrees * f64::from(index)).to_radians();
    let turn = DQuat::from_axis_angle(camera.up.normalize_or(glam::DVec3::Y), angle);
    let target = camera.position + turn * (camera.target - camera.position);
    Some(Camera { target, ..camera })
}
