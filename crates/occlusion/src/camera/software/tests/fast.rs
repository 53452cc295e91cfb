//! The fast renderer against the reference, and against itself on more threads.

use super::*;
use crate::camera::Query;

/// Every pixel that differs lies near an edge or is a tie. Gives how many differ.
fn compare(objects: &Arc<Objects>, view: &View) -> usize {
    let (slow, quick) = (reference(objects, view), fast(objects, view));
    let (slow, quick) = (slow.image(), quick.image());
    let mut excused = 0;
    for i in 0..slow.ids.len() {
        let depths = [slow.depth[i], quick.depth[i]];
        let close = (depths[0] - depths[1]).abs() <= 1e-6 * depths[0].max(depths[1]);
        if slow.ids[i] == quick.ids[i] {
            let id = slow.ids[i];
            let beside = || edge_of(objects, view, id, i) < 1.0 / 128.0;
            assert!(close || beside(), "pixel {i}: depths {depths:?}");
            continue;
        }
        excused += 1;
        let beside = |id: [u32; 2]| id[0] > 0 && edge_of(objects, view, id, i) < 1.0 / 128.0;
        let (a, b) = (slow.ids[i], quick.ids[i]);
        assert!(close || beside(a) || beside(b), "pixel {i}: {a:?}, fast {b:?}, {depths:?}");
    }
    excused
}

fn edge_of(objects: &Objects, view: &View, id: [u32; 2], pixel: usize) -> f64 {
    let triangle = objects.triangles(id[0] - 1).nth(id[1] as usize).unwrap();
    edge_distance(view, &triangle, pixel)
}

#[test]
fn draws_what_the_reference_draws() {
    let (mut excused, mut pixels) = (0, 0);
    for seed in 0..8 {
        let triangles = soup(seed, 400, 8);
        for chunk in [1, 23] {
            let plain = objects(&triangles, chunk);
            for world in [plain.clone(), masked(&plain)] {
                for (eye, to) in [
                    (DVec3::new(0.3, 0.4, 14.0), DVec3::ZERO),
                    (DVec3::new(0.3, 0.4, 0.2), DVec3::new(1.0, 0.1, -2.0)),
                ] {
                    let view = view(&world, &camera(eye, to), 97, 61);
                    excused += compare(&world, &view);
                    pixels += 97 * 61;
                }
            }
        }
    }
    assert!(excused * 100 < pixels, "{excused} of {pixels} pixels differ");
    assert!(excused > 0, "snapping moves no edge");
}

#[test]
fn draws_cities_as_the_reference_does() {
    for name in ["city_small", "city_trees"] {
        let scene = dapple_scene::generate::by_name(name, 3).unwrap();
        let (world, _) = Objects::from_scene(&scene, 1024).unwrap();
        let world = Arc::new(world);
        assert!(scene.cameras.len() >= 4);
        for camera in &scene.cameras {
            let view = view(&world, camera, 160, 90);
            let excused = compare(&world, &view);
            let covered = drawn(fast(&world, &view).image());
            assert!(covered > 1000, "{name} {}: {covered}", camera.name);
            assert!(excused * 20 < covered, "{name} {}: {excused} of {covered}", camera.name);
        }
    }
}

#[test]
fn a_corner_moved_by_a_pixel_is_told_from_snapping() {
    // The comparison can fail: one corner of one large triangle moves.
    let triangles = soup(2, 40, 8);
    let world = objects(&triangles, 1);
    let view = view(&world, &camera(DVec3::new(0.3, 0.4, 14.0), DVec3::ZERO), 97, 61);
    let mut moved = Objects::clone(&world);
    moved.templates.iter_mut().for_each(|t| t.positions[0].x += 0.2);
    let (slow, quick) = (reference(&world, &view), fast(&Arc::new(moved), &view));
    let differ = |i: &usize| {
        let ids = [slow.image().ids[*i], quick.image().ids[*i]];
        ids[0] != ids[1]
            && ids.iter().all(|&id| id[0] == 0 || edge_of(&world, &view, id, *i) > 1.0 / 128.0)
    };
    assert!((0..slow.image().ids.len()).filter(differ).count() > 20);
}

#[test]
fn a_world_far_away_draws_the_same() {
    let scene = dapple_scene::generate::by_name("city_small", 3).unwrap();
    let image = |by: DVec3| {
        let mut scene = scene.clone();
        scene.instances.iter_mut().for_each(|i| i.transform.translation += by);
        let (world, _) = Objects::from_scene(&scene, 1024).unwrap();
        let world = Arc::new(world);
        let near = &scene.cameras[0];
        let camera =
            Camera { position: near.position + by, target: near.target + by, ..near.clone() };
        let view = view(&world, &camera, 80, 45);
        fast(&world, &view).image().clone()
    };
    let (here, there) = (image(DVec3::ZERO), image(DVec3::new(1e9, -2e9, 3e9)));
    // World coordinates of 10^9 m have steps of 10^-7 m.
    let differ = here.ids.iter().zip(&there.ids).filter(|(a, b)| a != b).count();
    assert!(drawn(&here) > 1000 && differ * 100 < drawn(&here), "{differ}");
}

#[test]
fn corners_far_off_the_image_are_clipped_soundly() {
    let mut checked = 0;
    for seed in 0..40 {
        let mut random = random(seed);
        let corner = |far: f32, random: &mut Pcg64Mcg| {
            Vec3::new(dyadic(random, 9) * far, dyadic(random, 9) * far, dyadic(random, 3))
        };
        let triangles: Vec<[Vec3; 3]> = (0..40)
            .map(|i| {
                let far = [1.0, 1e3, 1e6, 1e8][i % 4];
                std::array::from_fn(|_| corner(far, &mut random))
            })
            .collect();
        let world = objects(&triangles, 5);
        let view = view(&world, &camera(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO), 64, 48);
        let excused = compare(&world, &view);
        assert!(excused < 64, "{excused} pixels differ");
        checked += drawn(fast(&world, &view).image());
    }
    assert!(checked > 40 * 1000, "{checked}");
}

#[test]
fn the_image_does_not_depend_on_threads_or_on_how_the_list_is_cut() {
    let triangles = soup(9, 30_000, 12);
    let world = objects(&triangles, 4);
    let view = view(&world, &camera(DVec3::new(0.0, 2.0, 20.0), DVec3::ZERO), 160, 90);
    let boxes: Vec<Bounds> = world.objects.iter().take(300).map(|o| o.bounds).collect();
    let queries: Vec<Query> = (0..100).map(|i| Query { boxes: 3 * i..3 * i + 3 }).collect();
    let draw = |threads: usize, step: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut renderer = Fast::new(world.clone(), NOW).unwrap();
            renderer.begin(&view).unwrap();
            for part in all(&world).chunks(step) {
                renderer.draw(part).unwrap();
            }
            renderer.ask(&boxes, &queries).unwrap();
            let mut counts = Vec::new();
            renderer.collect(&mut counts).unwrap();
            (renderer.image().clone(), counts)
        })
    };
    let whole = draw(1, usize::MAX);
    assert!(drawn(&whole.0) > 5000 && whole.1.iter().any(|&n| n > 0));
    for (threads, step) in [(4, usize::MAX), (3, 1000), (1, 1)] {
        assert_eq!(draw(threads, step), whole);
    }
}

#[test]
fn coordinates_of_any_size_draw_the_same() {
    let triangles = soup(4, 200, 8);
    let image = |scale: f32| {
        let scaled: Vec<[Vec3; 3]> = triangles.iter().map(|t| t.map(|p| p * scale)).collect();
        let world = objects(&scaled, 3);
        let eye = DVec3::new(0.25, 0.5, 14.0) * f64::from(scale);
        let view =
            View::new(&camera(eye, DVec3::ZERO), &world, 64, 64, NEAR * f64::from(scale)).unwrap();
        (reference(&world, &view).image().clone(), fast(&world, &view).image().clone())
    };
    let (slow, quick) = image(1.0);
    assert!(drawn(&slow) > 500);
    for exponent in [-20, 20] {
        // Powers of two: nothing is rounded differently.
        let (small, small_quick) = image(2.0_f32.powi(exponent));
        assert_eq!(small.ids, slow.ids);
        assert_eq!(small_quick.ids, quick.ids);
    }
}
