//! Generated scenes are valid, repeatable, of the promised size, and show a shadow.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed step fails its test")]

use dapple_scene::{Camera, Light, Scene, generate};
use glam::DVec3;

fn scene(name: &str) -> Scene {
    generate::by_name(name, 7).unwrap()
}

/// Distance along the ray to a triangle, brute force (Moeller and Trumbore).
fn hit(o: DVec3, d: DVec3, [a, b, c]: [DVec3; 3]) -> Option<f64> {
    let (ab, ac) = (b - a, c - a);
    let p = d.cross(ac);
    let det = ab.dot(p);
    if det == 0.0 {
        return None;
    }
    let s = o - a;
    let u = s.dot(p) / det;
    let q = s.cross(ab);
    let v = d.dot(q) / det;
    let t = ac.dot(q) / det;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 1e-4).then_some(t)
}

/// Shares of an image's pixels that see lit and shadowed surfaces, translucent ones as if opaque.
fn lit_and_dark(scene: &Scene, camera: &Camera) -> (f64, f64) {
    let triangles: Vec<_> = scene.world_triangles().map(|t| t.1).collect();
    let Light::Directional { direction } = scene.lights[0] else { panic!("no sun") };
    // Every ray meets every triangle: fewer rays where there are many.
    let (width, height) = if triangles.len() < 1_000_000 { (32, 18) } else { (16, 9) };
    let (mut lit, mut dark) = (0, 0);
    for i in 0..width * height {
        let (x, y) = (f64::from(i % width) + 0.5, f64::from(i / width) + 0.5);
        let (o, d) = camera.ray(x / f64::from(width), y / f64::from(height), 16.0 / 9.0);
        let Some(t) = triangles.iter().filter_map(|&t| hit(o, d, t)).min_by(f64::total_cmp) else {
            continue;
        };
        let p = o + d * t;
        let shadowed = triangles.iter().any(|&t| hit(p, -direction, t).is_some());
        *(if shadowed { &mut dark } else { &mut lit }) += 1;
    }
    let share = |n: i32| f64::from(n) / f64::from(width * height);
    (share(lit), share(dark))
}

#[test]
fn every_name_gives_a_valid_scene_with_sun_camera_and_path() {
    assert!(generate::NAMES.len() >= 22);
    for (name, what) in generate::NAMES {
        let s = scene(name);
        s.validate().unwrap();
        assert_eq!(&s.name, name);
        assert!(!what.is_empty());
        assert!(matches!(s.lights[0], Light::Directional { .. }), "{name}");
        assert!(!s.cameras.is_empty() && !s.paths.is_empty(), "{name}");
        assert_eq!(s.degenerate_triangles(), 0, "{name}");
        assert!(s.meshes.iter().all(|m| m.normals.len() == m.positions.len()), "{name}");
    }
    assert!(generate::by_name("no such scene", 1).is_none());
}

#[test]
fn sizes_are_as_described() {
    assert_eq!(scene("spheres").triangle_count(), 16 * 1280 + 2);
    assert_eq!(scene("chairs").triangle_count(), 16 * 26 * 12 + 2);
    let car = scene("car").triangle_count();
    assert!((9_000..11_000).contains(&car), "{car}");
    assert_eq!(scene("cube").triangle_count(), 14);
    assert_eq!(scene("three_planes").triangle_count(), 6);
}

#[test]
fn seeds_repeat_and_differ() {
    for name in ["spheres", "chairs", "car", "grass_sparse", "tree", "two_far", "metaballs"] {
        let hash = |seed| generate::by_name(name, seed).unwrap().hash();
        assert_eq!(hash(1), hash(1));
        assert_ne!(hash(1), hash(2));
        for seed in 0..20 {
            let s = generate::by_name(name, seed).unwrap();
            s.validate().unwrap();
            assert!(s.bounds().min.y >= -1e-9, "{name} {seed} dips below its floor");
        }
    }
}

#[test]
fn first_cameras_see_light_and_shadow_in_plenty() {
    // The larger cities are the small one again.
    let large = ["city", "city_flat", "city_9", "city_15"];
    for (name, _) in generate::NAMES.iter().filter(|(name, _)| !large.contains(name)) {
        let s = scene(name);
        // One of a city's views is a facade and nothing else.
        for camera in s.cameras.iter().filter(|c| c.name != "facade") {
            let (lit, dark) = lit_and_dark(&s, camera);
            println!("{name} \"{}\": {lit:.2} lit, {dark:.2} dark", camera.name);
            if *name == "empty_plane" {
                assert!(lit > 0.5 && dark == 0.0, "{lit} {dark}");
            } else {
                // Translucent scenes are about the inside of what casts, not its shadow; sparse
                // grass and two small clusters cast little.
                let translucent = s.materials.iter().any(|m| m.opacity < 1.0);
                let least = match (translucent, *name) {
                    // A city from above is roofs.
                    _ if camera.name == "birds_eye" => 0.01,
                    (_, "grass_sparse" | "two_far") => 0.01,
                    (true, _) => 0.05,
                    (false, _) => 0.12,
                };
                assert!(lit > 0.15 && dark > least, "{name} \"{}\": {lit} {dark}", camera.name);
            }
        }
    }
}

#[test]
fn planes_have_the_depths_of_the_analysis() {
    let s = scene("three_planes");
    let (down, at) = (DVec3::NEG_Y, |x: f64| DVec3::new(x, 20.0, 0.3));
    let heights = |x: f64| {
        let mut t: Vec<f64> = s.world_triangles().filter_map(|t| hit(at(x), down, t.1)).collect();
        t.sort_by(f64::total_cmp);
        t.into_iter().map(|t| 20.0 - t).collect::<Vec<_>>()
    };
    assert_eq!(heights(-1.0), [10.0, 2.0, 0.0]);
    assert_eq!(heights(1.0), [2.0, 0.0]);
    assert_eq!(heights(3.0), [0.0]);
}
