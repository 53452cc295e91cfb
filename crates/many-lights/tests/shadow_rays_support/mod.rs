//! Worlds that cast shadows, and shadow rays alone, on the processor and on a device.

use dapple_gpu::Gpu;
use dapple_many_lights::{
    Emission, Eye, Frame, Light, Point, World,
    gpu::{Occluders, Scene},
    radiance,
};
use dapple_scene::{Camera, city::City};
use dapple_trace::{Ray, Tracer};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::{
    sync::Arc,
    time::{Duration, Instant},
};

/// The share that the shader has for itself.
pub const EDGE_SLACK: f64 = 2.4e-7;

/// Rays of a pixel.
pub const RAYS: usize = 16;

/// A city at night as one camera sees it.
pub fn night(city: &City, camera: &Camera, [width, height]: [u32; 2]) -> World {
    let scene = city.scene().scene;
    let origin = scene.bounds().centre();
    let tracer = Tracer::build(&scene).unwrap();
    let aspect = f64::from(width) / f64::from(height);
    let point = |pixel: u32| {
        let x = (f64::from(pixel % width) + 0.5) / f64::from(width);
        let y = (f64::from(pixel / width) + 0.5) / f64::from(height);
        let (from, direction) = camera.ray(x, y, aspect);
        let ray = Ray::new(from, direction);
        let Some(hit) = tracer.closest(&ray) else { return Point::nothing() };
        let surface = tracer.surface(&ray, &hit);
        Point {
            position: (surface.position - origin).as_vec3(),
            object: surface.instance,
            normal: surface.normal.as_vec3(),
            albedo: Vec3::splat(0.5),
            ..Point::default()
        }
    };
    let points = (0..width * height).into_par_iter().map(point).collect();
    let eye = Eye::new(camera, origin, aspect);
    let windows = city.lights.iter().map(|w| Light {
        position: w.position - origin,
        axis: w.direction,
        intensity: w.intensity.as_dvec3(),
        emission: Emission::Spot { half_angle_rad: w.half_angle_rad },
    });
    let lamps = city.lamps.iter().map(|lamp| Light {
        position: lamp.position - origin,
        axis: DVec3::NEG_Y,
        intensity: lamp.intensity.as_dvec3(),
        emission: Emission::Omni,
    });
    World {
        origin,
        lights: windows.chain(lamps).collect(),
        frames: vec![Frame { width, height, eye, points }],
        clamp_m: 0.1,
        occluders: Some(Arc::new(tracer)),
    }
}

/// For each pixel the first [`RAYS`] lights, in leaps through all of them, that give it anything
/// where nothing is in between; `None` beyond those.
pub fn targets(world: &World) -> Vec<Option<u32>> {
    let count = world.lights.len() as u64;
    let one = |(pixel, point): (usize, &Point)| {
        let leap = |k: u64| ((pixel as u64 * 7919 + k * 104_729) % count) as u32;
        let gives = |i: &u32| {
            point.is_there()
                && radiance(point, &world.lights[*i as usize], world.clamp_m) != DVec3::ZERO
        };
        let given = (0..count.min(2000)).map(leap).filter(gives);
        given.map(Some).chain(std::iter::repeat(None)).take(RAYS).collect::<Vec<_>>()
    };
    world.frames[0].points.par_iter().enumerate().flat_map_iter(one).collect()
}

/// Whether the light of each target is seen, in f64; false where there is no target.
pub fn exact(world: &World, targets: &[Option<u32>]) -> Vec<bool> {
    let one = |(i, target): (usize, &Option<u32>)| {
        let point = &world.frames[0].points[i / RAYS];
        target.is_some_and(|light| world.sees(point, &world.lights[light as usize]))
    };
    targets.iter().enumerate().map(one).collect()
}

/// The same by a device, and the time that it took. Edges are wider than they are by a share of
/// what they are computed from.
pub fn traced(
    gpu: &Gpu,
    scene: &Scene<'_>,
    occluders: &Occluders,
    edge_slack: f64,
    targets: &[Option<u32>],
) -> (Vec<bool>, Duration) {
    let rays = [("RAYS", RAYS as f64), ("EDGE_SLACK", edge_slack)];
    let pipeline = gpu.compute("many-lights/shadow_rays.wgsl", "trace", &rays).unwrap();
    let output = scene.output().unwrap();
    let frames = scene.bind(&pipeline, &output);
    let list: Vec<u32> = targets.iter().map(|target| target.unwrap_or(0)).collect();
    let list = gpu.upload("targets", &list).unwrap();
    let own = gpu.bind(&pipeline, 1, &[&list]);
    let [params, nodes, triangles] = occluders.buffers();
    let shadows = gpu.bind(&pipeline, 2, &[params, nodes, triangles, scene.lights()]);
    let start = Instant::now();
    let mut frame = gpu.frame();
    frame.compute("shadow rays", |pass| {
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &frames[0], &[]);
        pass.set_bind_group(1, &own, &[]);
        pass.set_bind_group(2, &shadows, &[]);
        let [columns, rows] = scene.tiles(0).unwrap();
        pass.dispatch_workgroups(columns, rows, 1);
    });
    frame.finish().unwrap();
    let counts = scene.read_counts(&output, 0).unwrap();
    let took = start.elapsed();
    gpu.check().unwrap();
    let bit = |(i, target): (usize, &Option<u32>)| {
        target.is_some() && counts[i / RAYS][0] >> (i % RAYS) & 1 == 1
    };
    (targets.iter().enumerate().map(bit).collect(), took)
}

/// Of all targets: how many are seen in f64 and not by the device, and the other way round.
#[derive(Debug)]
pub struct Differences {
    pub rays: usize,
    pub darker: Vec<usize>,
    pub brighter: Vec<usize>,
}

/// Where two answers differ.
pub fn differences(targets: &[Option<u32>], exact: &[bool], found: &[bool]) -> Differences {
    let at = |wanted: (bool, bool)| {
        (0..targets.len()).filter(|&i| (exact[i], found[i]) == wanted).collect()
    };
    Differences {
        rays: targets.iter().flatten().count(),
        darker: at((true, false)),
        brighter: at((false, true)),
    }
}
