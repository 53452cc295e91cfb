//! The translucent scenes: sizes, seeds and places as described.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed step fails its test")]

use dapple_scene::{Aabb, Facing, Light, Mesh, Scene, generate, inspect::inspect};
use glam::DVec3;

/// Name, placed triangles, and the hash of the geometry for seed 7.
const SCENES: [(&str, usize, &str); 13] = [
    ("grass", 2 + 2_000 * 8, "39a5a9ca9711b0c7"),
    ("grass_sparse", 2 + 500 * 8, "c96fdd3c06b392b7"),
    ("grass_dense", 2 + 8_000 * 8, "0c2d4463c80561c2"),
    ("mixed", 2 + 4_250 * 8, "9df597980affb4a6"),
    // A trunk of four rings of eight sides: 3 * 16 and 6 for its top.
    ("tree", 2 + 54 + 4_000 * 2, "f14aad2050196d34"),
    ("willow", 2 + 54 + 20_000 * 2, "2a80a66d7cf84c1c"),
    ("trees", 2 + 108 + 24_000 * 2 + 90 * 16, "5a5f12a9897dd242"),
    ("two_far", 2 + 2 * 1_500 * 2, "3ffe656350a93a38"),
    ("hair", 2 + 5_120 + 5_000 * 32, "748d0f835f55edac"),
    ("hair_50k", 2 + 5_120 + 50_000 * 32, "71df6c120cb5f3aa"),
    ("slab", 2 + 20_000 * 2, "d7cdccd2ff791dbb"),
    ("sphere_cloud", 2 + 20_000 * 2, "322fd83e0c49a3d0"),
    ("metaballs", 2 + 30 * 1_280, "9e805100650acd34"),
];

fn scene(name: &str) -> Scene {
    generate::by_name(name, 7).unwrap()
}

fn is_translucent(scene: &Scene, instance: u32) -> bool {
    let mesh = &scene.meshes[scene.instances[instance as usize].mesh as usize];
    scene.materials[mesh.material as usize].opacity < 1.0
}

#[test]
fn sizes_and_hashes_are_those_of_the_list() {
    let found: Vec<(String, usize, String)> = SCENES
        .iter()
        .map(|(name, ..)| {
            let s = scene(name);
            ((*name).to_owned(), s.triangle_count(), s.geometry_hash())
        })
        .collect();
    let wanted = SCENES.map(|(name, triangles, hash)| (name.into(), triangles, hash.into()));
    assert_eq!(found, wanted, "geometry hashes change only when a scene is meant to");
    let mut hashes: Vec<&String> = found.iter().map(|f| &f.2).collect();
    hashes.sort();
    hashes.dedup();
    assert_eq!(hashes.len(), SCENES.len(), "two scenes are the same");
}

#[test]
fn light_falls_straight_down_on_an_opaque_ground_of_the_stated_size() {
    for (name, ..) in SCENES {
        let s = scene(name);
        let Light::Directional { direction } = s.lights[0] else { panic!("{name}: no sun") };
        assert_eq!((direction, s.lights.len()), (DVec3::NEG_Y, 1), "{name}");
        let ground = &s.meshes[0];
        assert_eq!(s.materials[ground.material as usize].opacity, 1.0, "{name}");
        let reach = ground.positions.iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
        assert!(reach == 8.21 && ground.positions.iter().all(|p| p.y == 0.0), "{name}");
        assert!(s.has_ground(), "{name}");
        // Nothing stands beyond the ground, so that every shadow has a receiver.
        let b = s.bounds();
        assert!(b.min.abs().max(b.max.abs()).with_y(0.0).max_element() < 8.211, "{name} {b:?}");
        assert_eq!(inspect(&s).needs("translucency"), Some(true), "{name}");
    }
}

#[test]
fn opacities_are_those_of_the_thesis() {
    for (name, opacity) in [
        ("grass", 176.0 / 255.0),
        ("mixed", 176.0 / 255.0),
        ("trees", 176.0 / 255.0),
        ("two_far", 176.0 / 255.0),
        ("hair", 70.0 / 255.0),
        ("metaballs", 127.0 / 255.0),
        ("slab", 0.1),
    ] {
        let s = scene(name);
        let translucent: Vec<f32> =
            s.materials.iter().map(|m| m.opacity).filter(|o| *o < 1.0).collect();
        assert_eq!(translucent, [opacity], "{name}");
    }
}

/// Translucent surfaces on vertical rays through the centres of 256 x 256 cells of the box around
/// them: how many in the mean, and at most.
fn layers(s: &Scene) -> (f64, u32) {
    const SIDE: usize = 256;
    let translucent: Vec<[DVec3; 3]> =
        s.world_triangles().filter(|((i, _), _)| is_translucent(s, *i)).map(|(_, t)| t).collect();
    let bounds = translucent.iter().flatten().fold(Aabb::EMPTY, |b, p| b.grow(*p));
    let cell = (bounds.max - bounds.min) / SIDE as f64;
    let mut counts = vec![0u32; SIDE * SIDE];
    for t in translucent {
        let t = t.map(|p| (p - bounds.min) / cell - 0.5).map(|p| glam::DVec2::new(p.x, p.z));
        let (low, high) = (t[0].min(t[1]).min(t[2]), t[0].max(t[1]).max(t[2]));
        let range = |low: f64, high: f64| low.ceil().max(0.0) as usize..=high.floor() as usize;
        let side = |a: usize, b: usize, p: glam::DVec2| (t[b] - t[a]).perp_dot(p - t[a]) > 0.0;
        for z in range(low.y, high.y) {
            for x in range(low.x, high.x) {
                let p = glam::DVec2::new(x as f64, z as f64);
                let sides = [side(0, 1, p), side(1, 2, p), side(2, 0, p)];
                counts[z * SIDE + x] += u32::from(sides[0] == sides[1] && sides[1] == sides[2]);
            }
        }
    }
    let sum: u32 = counts.iter().sum();
    (f64::from(sum) / (SIDE * SIDE) as f64, counts.into_iter().max().unwrap())
}

#[test]
fn fragments_on_a_ray_are_as_many_as_the_scene_is_for() {
    let mut of = std::collections::BTreeMap::new();
    for (name, low, high, most) in [
        ("grass_sparse", 0.1, 0.4, 1..10),
        ("grass", 0.4, 2.0, 4..20),
        ("grass_dense", 2.0, 6.0, 8..40),
        ("tree", 1.0, 8.0, 5..40),
        ("willow", 0.5, 8.0, 5..40),
        ("two_far", 1.5, 10.0, 5..40),
        ("hair", 0.4, 10.0, 5..100),
        ("hair_50k", 1.0, 40.0, 10..300),
        ("slab", 11.0, 12.6, 20..40),
        ("sphere_cloud", 7.0, 9.0, 20..50),
        ("metaballs", 3.0, 20.0, 8..60),
    ] {
        let (mean, found) = layers(&scene(name));
        println!("{name}: {mean:.2} layers, at most {found}");
        assert!((low..high).contains(&mean), "{name}: {mean}");
        assert!(most.contains(&found), "{name}: {found}");
        of.insert(name, mean);
    }
    // The same field: layers go with the number of blades.
    let ratio = of["grass_dense"] / of["grass_sparse"];
    assert!((12.0..18.0).contains(&ratio), "{ratio}");
}

#[test]
fn hair_that_faces_the_light_stops_more_of_it() {
    let camera_facing = scene("hair");
    let mut light_facing = camera_facing.clone();
    let hair = light_facing.meshes.iter_mut().find(|m| m.name == "hair").unwrap();
    let ribbons = generate::hair_strands(5_000, 7).ribbons(Facing::Direction(DVec3::NEG_Y)).mesh;
    assert_eq!(ribbons.triangles.len(), hair.triangles.len());
    *hair = Mesh { material: hair.material, ..ribbons };
    let (narrow, wide) = (layers(&camera_facing), layers(&light_facing));
    println!("{narrow:?} facing the camera, {wide:?} facing the light");
    assert!(wide.0 > 1.2 * narrow.0, "{wide:?} {narrow:?}");
}

#[test]
fn mixed_grass_is_denser_on_the_left() {
    let s = scene("mixed");
    let left = s.world_triangles().filter(|((i, _), t)| is_translucent(&s, *i) && t[0].x < 0.0);
    let (left, all) = (left.count(), s.triangle_count() - 2);
    assert!(left > 9 * all / 10 && left < 19 * all / 20 + 1_000, "{left} of {all}");
}

#[test]
fn clusters_far_apart_leave_the_gap_empty() {
    let s = scene("two_far");
    let heights = s.world_triangles().filter(|((i, _), _)| is_translucent(&s, *i));
    let (mut low, mut high) = (Aabb::EMPTY, Aabb::EMPTY);
    for (_, t) in heights {
        let cluster = if t[0].y < 6.0 { &mut low } else { &mut high };
        *cluster = t.into_iter().fold(*cluster, Aabb::grow);
    }
    let (gap, depth) = (high.min.y - low.max.y, low.max.y - low.min.y);
    assert!(low.min.y > 0.0 && gap > 3.0 * depth && depth > 1.8, "gap {gap}, depth {depth}");
}

#[test]
fn the_first_camera_sees_all_that_casts_a_translucent_shadow() {
    for (name, ..) in SCENES {
        let s = scene(name);
        let camera = &s.cameras[0];
        let (_, forward) = camera.ray(0.5, 0.5, 4.0 / 3.0);
        // A point is in the image if it is nearer to the axis than the edges' rays, both ways.
        let right = forward.cross(camera.up).normalize();
        let up = right.cross(forward);
        let (_, corner) = camera.ray(1.0, 0.0, 4.0 / 3.0);
        let edge = |axis: DVec3, d: DVec3| d.dot(axis).abs() / d.dot(forward);
        for ((i, _), corners) in s.world_triangles() {
            if !is_translucent(&s, i) {
                continue;
            }
            for d in corners.map(|p| p - camera.position) {
                let inside = d.dot(forward) > 0.0
                    && edge(right, d) < edge(right, corner)
                    && edge(up, d) < edge(up, corner);
                assert!(inside, "{name}: {} is outside the image", camera.position + d);
            }
        }
    }
}

#[test]
fn strands_of_a_scene_are_those_of_its_mesh() {
    let mut with_strands = 0;
    for (name, ..) in SCENES {
        let Some(strands) = generate::strands_of(name, 7) else { continue };
        with_strands += 1;
        let s = scene(name);
        let ribbons = strands.ribbons(Facing::Point(s.cameras[0].position)).mesh;
        let mesh = s.meshes.iter().find(|m| m.name == strands.name).unwrap();
        assert_eq!((&mesh.positions, &mesh.triangles), (&ribbons.positions, &ribbons.triangles));
    }
    assert_eq!(with_strands, 2, "hair and hair_50k");
    assert_eq!(generate::strands_of("grass", 7), None);
}
