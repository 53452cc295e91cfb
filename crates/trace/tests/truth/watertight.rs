//! A closed mesh holds every ray from its inside, at every scale and offset.

use crate::shapes::{cube, icosphere, rng, scene, star, unit_vector};
use dapple_scene::{Mesh, Scene};
use dapple_trace::{Ray, Tracer};
use glam::{DAffine3, DQuat, DVec3};
use obvhs::BvhBuildParams;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::ray::RayHit;
use obvhs::triangle::Triangle;
use rand::RngExt;
use std::time::Duration;

const RAYS: usize = 21_000;

/// Rays from near `centre` at corners exactly, at edges, and at points inside triangles (a third
/// each), through bit-exact world positions.
fn rays_from_inside(scene: &Scene, centre: DVec3, spread: f64, seed: u64) -> Vec<Ray> {
    let mut rng = rng(seed);
    let triangles: Vec<[DVec3; 3]> = scene.world_triangles().map(|t| t.1).collect();
    let ray = |i: usize| {
        let [a, b, c] = triangles[rng.random_range(0..triangles.len())];
        let s = rng.random::<f64>();
        let target = match i % 3 {
            0 => a,
            1 => a + (b - a) * if i.is_multiple_of(2) { 0.5 } else { s },
            _ => a + (b - a) * (0.5 * s) + (c - a) * (0.5 * rng.random::<f64>()),
        };
        let origin = centre + unit_vector(&mut rng) * (spread * rng.random::<f64>());
        Ray::new(origin, target - origin)
    };
    (0..RAYS).map(ray).collect()
}

fn misses(mesh: &Mesh, transform: DAffine3, spread: f64) -> (usize, usize) {
    let scene = scene(vec![(mesh.clone(), transform)]);
    let tracer = Tracer::build(&scene).unwrap();
    let rays = rays_from_inside(&scene, transform.translation, spread, 7);
    let missed = rays.iter().filter(|ray| tracer.closest(ray).is_none() || !tracer.any(ray));
    (missed.count(), rays.len())
}

#[test]
fn no_ray_leaks_out_of_a_closed_mesh_at_any_scale_and_offset() {
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    let meshes = [
        ("icosphere", icosphere(3), turn),
        ("cube", cube(), DQuat::IDENTITY),
        ("turned cube", cube(), turn),
        ("star", star(3, 1), turn),
        ("fine star", star(5, 2), DQuat::IDENTITY),
    ];
    let mut configurations = 0;
    for scale in [1e-6, 1e-3, 1.0, 1e3, 1e6] {
        for offset in [0.0, 1e3, 1e7] {
            for (name, mesh, turn) in &meshes {
                let translation = DVec3::new(offset, -0.7 * offset, 0.3 * offset);
                let transform = DAffine3::from_scale_rotation_translation(
                    DVec3::splat(scale),
                    *turn,
                    translation,
                );
                let (missed, rays) = misses(mesh, transform, 0.05 * scale);
                assert_eq!(missed, 0, "{name}, scale {scale:e}, offset {offset:e}");
                assert!(rays >= 20_000);
                configurations += 1;
            }
        }
    }
    assert_eq!(configurations, 75);
}

#[test]
fn vertices_of_a_convex_mesh_are_hit_where_they_are() {
    for (scale, offset) in [(1e-6, 0.0), (1.0, 0.0), (1e6, 0.0), (1.0, 1e7), (1e6, 1e7)] {
        let transform = DAffine3::from_scale_rotation_translation(
            DVec3::splat(scale),
            DQuat::IDENTITY,
            DVec3::splat(offset),
        );
        let scene = scene(vec![(icosphere(3), transform)]);
        let tracer = Tracer::build(&scene).unwrap();
        // The mesh itself moves by the rounding of its world coordinates.
        let bound = 1e-12 + 1e-15 * offset / scale * 100.0;
        for (_, [a, ..]) in scene.world_triangles() {
            let hit = tracer.closest(&Ray::new(transform.translation, a - transform.translation));
            let t = hit.unwrap().t;
            assert!((t - 1.0).abs() < bound, "scale {scale:e}, offset {offset:e}: {t}");
        }
    }
}

/// The control: the same rays against f32 boxes and the f32 Möller–Trumbore test do leak.
#[test]
fn plain_obvhs_leaks() {
    let scene = scene(vec![(icosphere(3), DAffine3::IDENTITY)]);
    let triangles: Vec<Triangle> = scene
        .world_triangles()
        .map(|(_, t)| t.map(|p| glam::Vec3A::from(p.as_vec3())))
        .map(|[v0, v1, v2]| Triangle { v0, v1, v2 })
        .collect();
    let parameters = BvhBuildParams::medium_build();
    let bvh = build_bvh2_from_tris(&triangles, parameters, &mut Duration::default());
    let rays = rays_from_inside(&scene, DVec3::ZERO, 0.05, 7);
    let leaks = rays
        .iter()
        .filter(|ray| {
            let (o, d) = (ray.origin.as_vec3().into(), ray.direction.as_vec3().into());
            let mut hit = RayHit::none();
            bvh.ray_traverse(obvhs::ray::Ray::new_inf(o, d), &mut hit, |ray, slot| {
                triangles[bvh.primitive_indices[slot] as usize].intersect(ray)
            });
            hit.t.is_infinite()
        })
        .count();
    assert!(leaks > RAYS / 100, "{leaks} of {RAYS}");
}
