//! Cameras that walk or turn at the pace that an axis pushes.

use crate::{case::Case, knob::Get};
use dapple_scene::{Camera, CameraPath, Scene};
use glam::{DQuat, DVec3};

/// The scene with one path of the case's frames, each as `at` has it; the path keeps its name.
pub fn along(mut scene: Scene, case: &Case, at: impl Fn(&Scene, u32) -> Option<Camera>) -> Scene {
    let frames = case.parameters.int("frames").unwrap_or(1) as u32;
    let keys: Vec<Camera> = (0..frames).filter_map(|i| at(&scene, i)).collect();
    if !keys.is_empty() {
        let frames = keys.len() as u32;
        // By the name that the case asks for.
        let name = scene.paths.first().map_or_else(String::new, |path| path.name.clone());
        scene.paths = vec![CameraPath { name, keys, frames }];
    }
    scene
}

/// Multiples of the golden ratio fill an interval evenly and repeat nowhere.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// Frame `index` of a walk along the first path at `speed` metres a frame.
pub fn walk(scene: &Scene, speed: f64, index: u32) -> Option<Camera> {
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
pub fn spin(scene: &Scene, degrees: f64, index: u32) -> Option<Camera> {
    let camera = scene.paths.first()?.camera(0)?;
    let angle = (degrees * f64::from(index)).to_radians();
    let turn = DQuat::from_axis_angle(camera.up.normalize_or(DVec3::Y), angle);
    let target = camera.position + turn * (camera.target - camera.position);
    Some(Camera { target, ..camera })
}
