//! The tree against every triangle one by one, and against another triangle test.

use crate::shapes::{mesh, placed, rng, scene, unit_vector};
use dapple_scene::{Mesh, Scene};
use dapple_trace::{Hit, Ray, Tracer};
use glam::{DAffine3, DVec3, Vec3};
use proptest::prelude::*;
use rand::RngExt;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64;

/// Triangles of all sizes; `snapped` ones have corners on a coarse raster, so that rays meet edges,
/// corners, box faces and coplanar and repeated triangles exactly.
fn soup(rng: &mut Pcg64, count: usize, snapped: bool) -> Mesh {
    let mut positions = Vec::new();
    for _ in 0..count {
        let size = 10.0_f64.powf(rng.random_range(-3.0..0.3));
        let centre = unit_vector(rng) * rng.random::<f64>();
        for _ in 0..3 {
            let p = centre + unit_vector(rng) * size;
            positions.push(if snapped { (p * 4.0).round() / 4.0 } else { p }.as_vec3());
        }
    }
    let triangle = |i: usize| [3 * i as u32, 3 * i as u32 + 1, 3 * i as u32 + 2];
    let mut triangles: Vec<_> = (0..count).map(triangle).collect();
    if snapped {
        triangles.extend_from_within(..count / 8);
    }
    mesh(positions, triangles)
}

fn rays(rng: &mut Pcg64, scene: &Scene, count: usize) -> Vec<Ray> {
    let corners: Vec<[DVec3; 3]> = scene.world_triangles().map(|t| t.1).collect();
    let ray = |i: usize| {
        let [a, b, c] = corners[rng.random_range(0..corners.len())];
        let inside = a + (b - a) * 0.25 + (c - a) * 0.5;
        let mut axis = DVec3::ZERO;
        axis[i % 3] = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        let (origin, direction) = match i % 8 {
            0 => (unit_vector(rng) * 2.0, unit_vector(rng)),
            1 => {
                let far = unit_vector(rng) * 2e3;
                (far, inside - far)
            }
            2 => (a, unit_vector(rng)),
            3 => (inside, unit_vector(rng) * 1e-6),
            4 => (a, axis * 1e6),
            5 => (a - axis * 3.0, axis),
            6 => {
                let far = unit_vector(rng) * 5.0;
                (far, (a - far) * 1e6)
            }
            _ => (b * 1e6 + inside, -b),
        };
        let length = direction.length().max(1e-300);
        match i % 5 {
            0 => Ray { origin, direction, t_min: 0.3 / length, t_max: 2.5 / length },
            1 => Ray { origin, direction, t_min: -1.0 / length, t_max: 1.0 / length },
            2 => Ray { origin, direction, t_min: f64::NEG_INFINITY, t_max: f64::INFINITY },
            _ => Ray::new(origin, direction),
        }
    };
    (0..count).map(ray).collect()
}

fn check(tracer: &Tracer, ray: &Ray) -> usize {
    let (mut all, mut expected) = (vec![Hit { t: 0.0, triangle: 9, u: 0.0, v: 0.0 }], Vec::new());
    tracer.all(ray, &mut all);
    tracer.all_brute_force(ray, &mut expected);
    assert_eq!(all, expected, "{ray:?}");
    // Once: all that are not on an edge, in the same order, and nothing else.
    let mut once = Vec::new();
    tracer.all_once(ray, &mut once);
    let on_edge = |hit: &Hit| hit.u == 0.0 || hit.v == 0.0 || hit.u + hit.v >= 1.0 - 1e-12;
    expected.retain(|hit| !on_edge(hit) || once.contains(hit));
    assert_eq!(once, expected, "{ray:?}");
    assert!(all.windows(2).all(|w| w[0].t <= w[1].t));
    let closest = tracer.closest(ray);
    assert_eq!(closest, tracer.closest_brute_force(ray), "{ray:?}");
    assert_eq!(closest, all.first().copied(), "{ray:?}");
    assert_eq!(tracer.any(ray), closest.is_some(), "{ray:?}");
    if let Some(hit) = closest {
        let others = all.iter().any(|other| other.triangle != hit.triangle);
        assert_eq!(tracer.any_except(ray, Some(hit.triangle)), others, "{ray:?}");
    }
    all.len()
}

fn cases() -> u32 {
    std::env::var("PROPTEST_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(128)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(), ..ProptestConfig::default() })]

    #[test]
    fn the_tree_finds_what_asking_every_triangle_finds(
        seed in any::<u64>(),
        count in 1..400_usize,
        snapped in any::<bool>(),
        scale in prop::sample::select(vec![1e-6, 1.0, 1e6]),
        offset in prop::sample::select(vec![0.0, 1e3, 1e7]),
    ) {
        let mut rng = rng(seed);
        // Built around the origin and then moved, rays and all.
        let local = placed(soup(&mut rng, count, snapped));
        let rays = rays(&mut rng, &local, 400);
        let shift = DVec3::splat(offset);
        let transform = DAffine3::from_scale_rotation_translation(
            DVec3::splat(scale), glam::DQuat::IDENTITY, shift);
        let moved = scene(vec![(local.meshes[0].clone(), transform)]);
        let tracer = Tracer::build(&moved).unwrap();
        let mut hits = 0;
        for ray in &rays {
            let placed = Ray {
                origin: ray.origin * scale + shift, direction: ray.direction * scale, ..*ray };
            hits += check(&tracer, &placed);
        }
        // A few snapped triangles may all be degenerate.
        prop_assert!(hits > 0 || count < 20);
    }
}

/// f64 Möller–Trumbore, written apart from the code under test: (t, u, v).
fn moeller_trumbore(ray: &Ray, [a, b, c]: [DVec3; 3]) -> Option<(f64, f64, f64)> {
    let (e1, e2) = (b - a, c - a);
    let p = ray.direction.cross(e2);
    let determinant = e1.dot(p);
    let s = ray.origin - a;
    let q = s.cross(e1);
    let (u, v) = (s.dot(p) / determinant, ray.direction.dot(q) / determinant);
    let t = e2.dot(q) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then_some((t, u, v))
}

#[test]
fn distances_and_weights_agree_with_another_triangle_test() {
    let mut rng = rng(5);
    let scene = placed(soup(&mut rng, 200, false));
    let triangles: Vec<_> = scene.world_triangles().map(|t| t.1).collect();
    let tracer = Tracer::build(&scene).unwrap();
    let mut compared = 0;
    for ray in rays(&mut rng, &scene, 4000) {
        let mut hits = Vec::new();
        tracer.all(&ray, &mut hits);
        for (id, corners) in triangles.iter().enumerate() {
            let Some((t, u, v)) = moeller_trumbore(&ray, *corners) else { continue };
            // At borders and nearly edge-on the two may differ in whether, not in where.
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
            let length = ray.direction.length();
            let clear = 1e-6;
            let doubtful = u < clear
                || v < clear
                || u + v > 1.0 - clear
                || normal.dot(ray.direction / length).abs() < 1e-3
                || (t - ray.t_min).abs() * length < clear
                || (t - ray.t_max).abs() * length < clear;
            if doubtful || t < ray.t_min || t > ray.t_max {
                continue;
            }
            let hit = hits.iter().find(|hit| hit.triangle as usize == id).unwrap();
            let far = 1.0 + ray.origin.length();
            assert!((hit.t - t).abs() * length < 1e-9 * far, "{hit:?} {t}");
            assert!((hit.u - u).abs() < 1e-6 * far && (hit.v - v).abs() < 1e-6 * far, "{hit:?}");
            compared += 1;
        }
    }
    assert!(compared > 2000, "{compared}");
}

#[test]
fn the_order_of_triangles_does_not_matter() {
    let mut rng = rng(8);
    let mesh = soup(&mut rng, 300, false);
    let mut order: Vec<u32> = (0..300).collect();
    order.shuffle(&mut rng);
    let triangles = order.iter().map(|&i| mesh.triangles[i as usize]).collect();
    let shuffled = placed(Mesh { triangles, ..mesh.clone() });
    let scene = placed(mesh);
    let (a, b) = (Tracer::build(&scene).unwrap(), Tracer::build(&shuffled).unwrap());
    let mut hits = 0;
    for ray in rays(&mut rng, &scene, 2000) {
        let back = b.closest(&ray).map(|hit| Hit { triangle: order[hit.triangle as usize], ..hit });
        assert_eq!(a.closest(&ray), back);
        hits += usize::from(back.is_some());
    }
    assert!(hits > 200, "{hits}");
}

#[test]
fn of_equal_distances_the_lowest_triangle_wins() {
    let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
    let scene = placed(mesh(corners, vec![[0, 1, 2]; 40]));
    let tracer = Tracer::build(&scene).unwrap();
    let ray = Ray::new(DVec3::new(0.2, 0.2, 1.0), DVec3::NEG_Z);
    assert_eq!(tracer.closest(&ray).unwrap().triangle, 0);
    let mut hits = Vec::new();
    tracer.all(&ray, &mut hits);
    assert!(hits.iter().map(|hit| hit.triangle).eq(0..40));
}

#[test]
fn a_triangle_without_area_in_line_with_the_origin_is_not_hit_elsewhere() {
    // Exactly on one line: the edge functions are noise, of one sign for some directions.
    let line = DVec3::new(1.0, 3.0, 5.0);
    let corners: Vec<Vec3> = (3..13).map(|k| line.as_vec3() * k as f32).collect();
    let triangles = (0..7).map(|i| [i, i + 1, i + 3]).collect();
    let scene = placed(mesh(corners, triangles));
    let tracer = Tracer::build(&scene).unwrap();
    let mut rng = rng(3);
    for _ in 0..10_000 {
        let direction = unit_vector(&mut rng);
        let along = direction.angle_between(line);
        if along > 0.01 {
            let ray = Ray::new(DVec3::ZERO, direction);
            assert_eq!(tracer.closest(&ray), None);
            assert_eq!(tracer.closest_brute_force(&ray), None);
        }
    }
}

#[test]
fn both_ends_of_the_range_count() {
    let scene = placed(mesh(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]));
    let tracer = Tracer::build(&scene).unwrap();
    let ray = Ray::new(DVec3::new(0.25, 0.25, 1.0), DVec3::NEG_Z * 0.5);
    assert_eq!(tracer.closest(&ray).unwrap().t, 2.0);
    for (t_min, t_max, hit) in [
        (2.0, 3.0, true),
        (0.0, 2.0, true),
        (2.1, 3.0, false),
        (0.0, 1.9, false),
        (3.0, 1.0, false),
    ] {
        assert_eq!(tracer.any(&Ray { t_min, t_max, ..ray }), hit, "{t_min} {t_max}");
    }
}
