//! The reference against rays through the pixels' centres.

use super::*;
use crate::camera::software::owners;
use dapple_scene::{Instance, Material, Mesh, Scene};
use dapple_trace::{Ray, Tracer};

fn scene(triangles: &[[Vec3; 3]]) -> Scene {
    let positions = triangles.as_flattened().to_vec();
    let count = triangles.len() as u32;
    Scene {
        meshes: vec![Mesh {
            positions,
            triangles: (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
            ..Mesh::default()
        }],
        materials: vec![Material::default()],
        instances: vec![Instance { mesh: 0, transform: glam::DAffine3::IDENTITY }],
        ..Scene::default()
    }
}

/// Triangle + 1 and depth through each pixel's centre.
fn rays(triangles: &[[Vec3; 3]], camera: &Camera, view: &View) -> Vec<(u32, f64)> {
    let tracer = Tracer::build(&scene(triangles)).unwrap();
    let aspect = f64::from(view.width) / f64::from(view.height);
    let pixel = |i: u32| {
        let x = (f64::from(i % view.width) + 0.5) / f64::from(view.width);
        let y = (f64::from(i / view.width) + 0.5) / f64::from(view.height);
        let (origin, direction) = camera.ray(x, y, aspect);
        let along = direction.dot(view.forward);
        let ray = Ray { t_min: view.near_m / along, ..Ray::new(origin, direction) };
        tracer.closest(&ray).map_or((0, 0.0), |hit| {
            let distance = hit.t * along - (view.near_m - view.near_distance());
            (hit.triangle + 1, view.depth(distance))
        })
    };
    (0..view.width * view.height).map(pixel).collect()
}

/// Compares and gives the number of pixels that differ near edges and at ties.
fn compare(triangles: &[[Vec3; 3]], chunk: usize, camera: &Camera, sides: [u32; 2]) -> usize {
    let objects = objects(triangles, chunk);
    let view = view(&objects, camera, sides[0], sides[1]);
    let renderer = reference(&objects, &view);
    let image = renderer.image();
    let truth = rays(triangles, camera, &view);
    assert_eq!(truth.len(), image.ids.len());
    let mut excused = 0;
    for (i, &(triangle, depth)) in truth.iter().enumerate() {
        let [object, within] = image.ids[i];
        let seen = object.checked_sub(1).map_or(0, |o| o * chunk as u32 + within + 1);
        let drawn = f64::from(image.depth[i]);
        let near = 1e-6 * depth.max(drawn) + 1e-12;
        if seen == triangle {
            assert!((drawn - depth).abs() <= near, "pixel {i}: depth {drawn}, by rays {depth}");
            continue;
        }
        excused += 1;
        let close = |t: u32| t > 0 && edge_distance(&view, &triangles[t as usize - 1], i) < 1e-9;
        let tie = seen > 0 && triangle > 0 && (drawn - depth).abs() <= near;
        assert!(tie || close(seen) || close(triangle), "pixel {i}: {seen}, by rays {triangle}");
    }
    assert_eq!(owners(image, objects.objects.len()).iter().sum::<u32>() as usize, drawn(image));
    excused
}

#[test]
fn sees_what_rays_see() {
    let mut covered = 0;
    for seed in 0..6 {
        let triangles = soup(seed, 300, 8);
        let camera = camera(DVec3::new(0.25, 0.5, 13.0), DVec3::new(0.0, 0.25, 0.0));
        let excused = compare(&triangles, 7, &camera, [61, 47]);
        assert!(excused <= 4, "{excused} pixels differ");
        covered += 1;
    }
    assert_eq!(covered, 6);
}

#[test]
fn sees_what_rays_see_from_within() {
    // Many triangles cross the near plane and the eye's plane.
    for seed in 10..16 {
        let triangles = soup(seed, 200, 4);
        let camera = camera(DVec3::new(0.5, 0.25, 0.5), DVec3::new(3.0, -0.5, 2.0));
        let excused = compare(&triangles, 200, &camera, [53, 64]);
        assert!(excused <= 4, "{excused} pixels differ");
    }
}

#[test]
fn sees_what_parallel_rays_see() {
    let triangles = soup(20, 300, 8);
    let projection = Projection::Orthographic { height_m: 14.0 };
    let turned = camera(DVec3::new(3.0, 5.0, 21.0), DVec3::new(0.0, 0.25, 0.0));
    let excused = compare(&triangles, 9, &Camera { projection, ..turned }, [64, 40]);
    assert!(excused <= 4, "{excused} pixels differ");
}

#[test]
fn a_shifted_image_is_told_from_rays() {
    // The comparison can fail: half a pixel beside the centres it does.
    let triangles = soup(0, 300, 8);
    let camera = camera(DVec3::new(0.25, 0.5, 13.0), DVec3::new(0.0, 0.25, 0.0));
    let objects = objects(&triangles, 1);
    let view = view(&objects, &camera, 61, 47);
    let mut shifted = view.clone();
    let by = glam::DMat4::from_translation(DVec3::new(1.0 / 61.0, 0.0, 0.0));
    shifted.clip = by * view.clip;
    let image = reference(&objects, &shifted).image().clone();
    let truth = rays(&triangles, &camera, &view);
    let differ = truth.iter().zip(&image.ids).filter(|(t, id)| t.0 != id[0]).count();
    assert!(differ > 100, "{differ}");
}
