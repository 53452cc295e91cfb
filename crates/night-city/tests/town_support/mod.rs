//! A small generated city, its frames traced.
#![allow(dead_code, reason = "every test file uses what it needs")]
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use dapple_many_lights::{
    LightTree, Shaded, World,
    region::Occluders,
    tree::city::{Levels, keys},
    worlds::CLAMP_M,
};
use dapple_night_city::{Device, Given, Night, Pipeline, Town, frame};
use dapple_occlusion::camera::{Objects, View, city_keys};
use dapple_scene::{
    Camera,
    city::{self, City},
    generate,
};
use dapple_trace::Tracer;
use glam::Vec3;
use std::sync::Arc;

/// Most triangles of an object.
const OBJECT_TRIANGLES: u32 = 128;

/// The small city, along so many frames of its tour, every `step`th, in images 4 wide to 3 high.
pub fn small(width: u32, frames: u32, step: u32) -> Arc<Town> {
    along("tour", width, (0..frames).map(|frame| frame * step))
}

/// The small city at frames of a path.
pub fn along(path: &str, width: u32, frames: impl Iterator<Item = u32>) -> Arc<Town> {
    town("city_small", path, width, frames)
}

/// A generated city at frames of a path.
pub fn town(name: &str, path: &str, width: u32, frames: impl Iterator<Item = u32>) -> Arc<Town> {
    of_city(&city::generate(&generate::city_knobs(name).unwrap(), 1).unwrap(), path, width, frames)
}

/// A city at frames of a path.
pub fn of_city(
    city: &City,
    path: &str,
    width: u32,
    frames: impl Iterator<Item = u32>,
) -> Arc<Town> {
    let city::CityScene { scene, parts } = city.scene();
    let (objects, owners) = Objects::from_scene(&scene, OBJECT_TRIANGLES).unwrap();
    let origin = objects.origin;
    let tracer = Arc::new(Tracer::build(&scene).unwrap());
    let path = city.paths.iter().find(|p| p.name == path).unwrap();
    let cameras: Vec<Camera> = frames.map(|frame| path.camera(frame).unwrap()).collect();
    let size = [width, width * 3 / 4];
    let near_m = 1e-4 * scene.bounds().radius();
    let view = |camera| View::new(camera, &objects, size[0], size[1], near_m).unwrap();
    let views = cameras.iter().map(view).collect();
    let trace = |camera| frame(&scene, &tracer, &objects, &owners, camera, size);
    let frames = cameras.iter().map(trace).collect();
    let (lights, paths) = keys(city, origin, Levels::default());
    let tree = Arc::new(LightTree::by_keys(&lights, &paths).unwrap());
    let world = World { origin, lights, frames, clamp_m: CLAMP_M, occluders: None };
    let keys = city_keys(&parts, &scene, &owners, &objects);
    let given = Given {
        objects: Arc::new(objects),
        keys: &keys,
        parts: &parts,
        scene: &scene,
        owners: &owners,
        views,
        world,
        lights: tree,
        occluders: Arc::new(Occluders::of_city(city, origin)),
        tracer,
    };
    Arc::new(Town::new(given).unwrap())
}

/// All frames of a town.
pub fn images(town: &Arc<Town>, night: &Night, device: Option<&Device<'_>>) -> Vec<Vec<Vec3>> {
    let mut pipeline = Pipeline::new(town, night, device).unwrap();
    let mut shaded = Shaded::default();
    let mut images = Vec::new();
    for index in 0..town.views.len() {
        pipeline.frame(index, false).unwrap();
        pipeline.read(&mut shaded).unwrap();
        images.push(shaded.radiance.clone());
    }
    images
}

/// Pixels that get any light.
pub fn lit(image: &[Vec3]) -> usize {
    image.iter().filter(|radiance| **radiance != Vec3::ZERO).count()
}
