//! Depth maps and item buffers against planes and spheres.

use crate::shapes::{icosphere, patch, placed, scene};
use dapple_scene::{Camera, LightView, Projection};
use dapple_trace::{Tracer, depth_map, item_buffer};
use glam::{DAffine3, DVec3};

fn texels(n: u32) -> impl Iterator<Item = (f64, f64)> {
    let centre = move |i: u32| (f64::from(i) + 0.5) / f64::from(n);
    (0..n * n).map(move |i| (centre(i % n), centre(i / n)))
}

#[test]
fn the_depth_map_of_a_plane_is_its_formula() {
    let corners = [(-5.0, -5.0), (5.0, -5.0), (5.0, 5.0), (-5.0, 5.0)];
    let height = |x: f64, z: f64| 0.5 * x - 0.25 * z;
    let slanted = patch(corners.map(|(x, z)| DVec3::new(x, height(x, z), z)), 7);
    let normal = DVec3::new(-0.5, 1.0, 0.25);
    let mut covered = 0;
    for offset in [0.0, 1e7] {
        let shift = DVec3::new(offset, 0.0, -offset);
        let scene = scene(vec![(slanted.clone(), DAffine3::from_translation(shift))]);
        let tracer = Tracer::build(&scene).unwrap();
        let bounds = scene.bounds();
        let views = [
            LightView::fit_directional(DVec3::new(0.3, -1.0, 0.2), &bounds).unwrap(),
            LightView::fit_spot(shift + DVec3::Y * 12.0, DVec3::NEG_Y, 0.5, &bounds).unwrap(),
        ];
        for view in views {
            let map = depth_map(&tracer, &view, 64, 64);
            for ((u, v), &z) in texels(64).zip(&map) {
                let (o, d) = view.ray(u, v);
                let expected = normal.dot(shift - o) / normal.dot(d);
                let p = o + d * expected - shift;
                let edge = p.x.abs().max(p.z.abs()) - 5.0;
                if edge > 1e-6 {
                    assert_eq!(z, 1.0, "{p}");
                } else if edge < -1e-6 {
                    assert!((f64::from(z) - expected).abs() < 1e-6, "{z} {expected}");
                    covered += 1;
                }
            }
        }
    }
    assert!(covered > 8000, "{covered}");
}

#[test]
fn a_map_is_addressed_by_rows_from_the_top() {
    // A small patch at a known place of the map: light straight down, v runs along z or against it.
    let tile = patch(
        [(2.0, 2.0), (3.0, 2.0), (3.0, 3.0), (2.0, 3.0)].map(|(x, z)| DVec3::new(x, 1.0, z)),
        1,
    );
    let floor = patch(
        [(-4.0, -4.0), (4.0, -4.0), (4.0, 4.0), (-4.0, 4.0)].map(|(x, z)| DVec3::new(x, 0.0, z)),
        1,
    );
    let scene = scene(vec![(tile, DAffine3::IDENTITY), (floor, DAffine3::IDENTITY)]);
    let view = LightView::fit_directional(DVec3::NEG_Y, &scene.bounds()).unwrap();
    let (w, h) = (96, 48);
    let map = depth_map(&Tracer::build(&scene).unwrap(), &view, w, h);
    let at = view.project(DVec3::new(2.5, 1.0, 2.5));
    let (x, y) = ((at.x * f64::from(w)) as usize, (at.y * f64::from(h)) as usize);
    assert!((f64::from(map[y * w as usize + x]) - at.z).abs() < 1e-6);
    let closer = map.iter().filter(|&&z| f64::from(z) < at.z + 0.01).count();
    // One square metre of (2 * half_extent)^2 over all texels.
    let expected = f64::from(w * h) / (4.0 * view.half_extent * view.half_extent);
    assert!((closer as f64 - expected).abs() < 0.3 * expected, "{closer} {expected}");
    assert!(depth_map(&Tracer::build(&scene).unwrap(), &view, 0, 5).is_empty());
}

#[test]
fn a_sphere_has_its_silhouette_and_distance() {
    let centre = DVec3::new(1e3, 2.0, -5.0);
    let transform = DAffine3::from_translation(centre);
    let scene = scene(vec![(icosphere(6), transform)]);
    let tracer = Tracer::build(&scene).unwrap();
    let camera = Camera {
        name: String::new(),
        position: centre + DVec3::new(0.0, 0.0, 4.0),
        target: centre,
        up: DVec3::Y,
        projection: Projection::Perspective { fov_y_rad: 0.6 },
    };
    let (mut inside, mut outside) = (0, 0);
    let n = 128;
    for ((x, y), item) in texels(n).zip(item_buffer(&tracer, &camera, n, n)) {
        let (o, d) = camera.ray(x, y, 1.0);
        let along = d.dot(centre - o);
        let miss = (o + d * along - centre).length();
        // The mesh lies within 1 - 1e-3 and 1.
        if miss > 1.0 {
            assert!(item.is_none());
            outside += 1;
        } else if miss < 0.998 {
            let (ray, hit) = item.unwrap();
            assert_eq!((ray.origin, ray.direction), (o, d));
            let expected = along - (1.0 - miss * miss).sqrt();
            let normal_cosine = (1.0 - miss * miss).sqrt();
            assert!((hit.t - expected).abs() < 1e-3 / normal_cosine, "{} {expected}", hit.t);
            inside += 1;
        }
    }
    assert!(inside > 5000 && outside > 3000, "{inside} {outside}");
}

#[test]
fn thread_counts_do_not_matter() {
    let scene = placed(icosphere(3));
    let view = LightView::fit_directional(DVec3::new(1.0, -2.0, 0.5), &scene.bounds()).unwrap();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| depth_map(&Tracer::build(&scene).unwrap(), &view, 61, 47))
    };
    assert_eq!(with(1), with(3));
}
