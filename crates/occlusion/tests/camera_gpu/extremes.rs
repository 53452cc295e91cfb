//! Many of everything, few of anything, and what is refused.

use crate::support::*;
use dapple_gpu::testing::live_objects;
use dapple_occlusion::camera::gpu::{Drawing, Renderer, Scene, Settings};
use dapple_occlusion::camera::renderer::Renderer as _;
use dapple_occlusion::camera::{Mask, Objects, Query, Template};
use glam::{Mat3, Vec3};

#[test]
fn five_hundred_batches_in_a_frame() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    // A pixel is 1 m at 4 m: strips of a pixel's width, drawn one after the other.
    let mut objects = Objects::default();
    let strip = add_template(&mut objects, rectangle([0.0, 1.0], [-9.0, 9.0], -4.0));
    for i in 0..500 {
        place(&mut objects, strip, Mat3::IDENTITY, Vec3::new(i as f32 - 256.0, 0.0, 0.0));
    }
    let view = square_on(&objects, 512, 8);
    let boxes = [flat_box([-512.0, 512.0], [-8.0, 8.0], -8.0)];
    let mut renderer = renderer(gpu, &objects, Settings::default());
    for frame in 0..2 {
        renderer.begin(&view).unwrap();
        for i in 0..500 {
            renderer.draw(&[i]).unwrap();
            renderer.ask(&boxes, &one_each(1)).unwrap();
        }
        renderer.end().unwrap();
        let mut counts = Vec::new();
        for _ in 0..500 {
            renderer.collect(&mut counts).unwrap();
        }
        let right: Vec<u32> = (1..=500).map(|k| 2 * 8 * (512 - k)).collect();
        assert_eq!(counts, right, "frame {frame}");
        let counters = renderer.counters();
        assert_eq!((counters.draw_calls, counters.draw_passes), (500, 500));
        assert_eq!((counters.query_passes, counters.submissions), (500, 501));
        let times = renderer.times().unwrap();
        assert_eq!(times.fault, None);
        if gpu.abilities.timestamps {
            let names: Vec<_> = times.passes.iter().map(|(name, _)| *name).collect();
            assert_eq!(names, ["draw", "query"]);
            assert!(times.gpu_ns.unwrap() <= times.wall_ns);
        }
    }
}

#[test]
fn frames_after_the_first_make_nothing() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let objects = heap(40, 3000);
    let view = views(&objects, 64, 64).remove(0);
    let boxes: Vec<_> = objects.objects.iter().map(|o| o.bounds).take(300).collect();
    let mut renderer = renderer(gpu, &objects, Settings::default());
    let frame = |renderer: &mut Renderer<'_>| {
        renderer.begin(&view).unwrap();
        for part in all(&objects).chunks(300) {
            renderer.draw(part).unwrap();
            renderer.ask(&boxes, &one_each(boxes.len())).unwrap();
        }
        renderer.end().unwrap();
        let mut counts = Vec::new();
        for _ in 0..10 {
            renderer.collect(&mut counts).unwrap();
        }
        let image = renderer.image().unwrap();
        gpu.check().unwrap();
        (counts, image, live_objects().unwrap())
    };
    let _ = frame(&mut renderer);
    let first = frame(&mut renderer);
    for _ in 0..5 {
        assert!(frame(&mut renderer) == first);
    }
}

#[test]
fn a_frame_without_draws_is_empty() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    for objects in [heap(41, 5), Objects::default()] {
        let view = square_on(&objects, 8, 4);
        let mut renderer = renderer(gpu, &objects, Settings::default());
        draw_all(&mut renderer, &view, &objects);
        renderer.begin(&view).unwrap();
        renderer.draw(&[]).unwrap();
        renderer.end().unwrap();
        let image = renderer.image().unwrap();
        assert_eq!((image.width, image.height), (8, 4));
        assert_eq!((image.ids, image.depth), (vec![[0, 0]; 32], vec![0.0; 32]));
        // And so is one that only asks.
        renderer.begin(&view).unwrap();
        let boxes = [flat_box([-8.0, 8.0], [-8.0, 8.0], -2.0)];
        assert_eq!(counts(&mut renderer, &boxes), [64]);
        renderer.end().unwrap();
        assert_eq!(renderer.image().unwrap().ids, [[0, 0]; 32]);
    }
}

#[test]
fn one_pixel_and_one_triangle() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let mut objects = Objects::default();
    let triangle = Template {
        positions: vec![Vec3::new(-9.0, -9.0, -2.0), Vec3::new(9.0, -9.0, -2.0), Vec3::Y * 9.0],
        triangles: vec![[0, 1, 2]],
        ..Template::default()
    };
    add(&mut objects, triangle);
    let view = square_on(&objects, 1, 1);
    let mut renderer = renderer(gpu, &objects, Settings::default());
    let image = draw_all(&mut renderer, &view, &objects);
    assert_eq!(image.ids, [[1, 0]]);
    // The ray along -z meets the plane through (0, -9, -2) and (0, 9, 0) at z = -1.
    assert!((f64::from(image.depth[0]) - NEAR).abs() < 1e-6, "{}", image.depth[0]);
    assert_eq!(renderer.bytes(), 24 + Scene::new(gpu, &objects).unwrap().bytes());
}

#[test]
fn two_hundred_thousand_objects() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let mut objects = Objects::default();
    let tiles = [-6.0, -7.0].map(|z| rectangle([0.0, 0.02], [0.0, 0.02], z));
    let tiles = tiles.map(|tile| add_template(&mut objects, tile));
    for i in 0..200_000 {
        let (x, y) = ((i % 500) as f32 * 0.02 - 5.0, (i / 500) as f32 * 0.02 - 4.0);
        place(&mut objects, tiles[i % 2], Mat3::IDENTITY, Vec3::new(x, y, i as f32 * 1e-6));
    }
    let scene = Scene::new(gpu, &objects).unwrap();
    assert_eq!(
        (scene.objects(), scene.triangles(), scene.stored_triangles()),
        (200_000, 400_000, 4)
    );
    assert_eq!(scene.object_bytes(), 200_000 * 76);
    let view = square_on(&objects, 64, 64);
    let mut images = Vec::new();
    for (drawing, calls) in [(Drawing::PerObject, 200_000), (Drawing::Instanced, 2)] {
        let settings = Settings { drawing, ..Settings::default() };
        let mut renderer = Renderer::new(gpu, &scene, settings).unwrap();
        images.push(draw_all(&mut renderer, &view, &objects));
        assert_eq!(renderer.counters().draw_calls, calls);
    }
    assert!(images[0] == images[1]);
    assert!(images[0].ids.iter().filter(|id| id[0] > 0).count() > 500);
}

#[test]
fn scenes_of_any_size_anywhere_draw_the_same() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let objects = heap(43, 200);
    let view = views(&objects, 64, 48).remove(0);
    let image = draw_all(&mut renderer(gpu, &objects, Settings::default()), &view, &objects);
    for scale in [2f32.powi(-20), 2f32.powi(20)] {
        let mut scaled = objects.clone();
        for object in &mut scaled.objects {
            object.linear *= scale;
            object.translation *= scale;
            object.bounds.min *= scale;
            object.bounds.max *= scale;
        }
        let factor = f64::from(scale);
        let opening = dapple_scene::Projection::Perspective { fov_y_rad: 1.1 };
        let camera = camera([3.0 * factor, 5.0 * factor, 45.0 * factor], [0.0; 3], opening);
        let view =
            dapple_occlusion::camera::View::new(&camera, &scaled, 64, 48, NEAR * factor).unwrap();
        let other = draw_all(&mut renderer(gpu, &scaled, Settings::default()), &view, &scaled);
        // Powers of two change no bit.
        assert!(image == other, "scale {scale}");
    }
}

#[test]
fn what_is_wrong_is_refused_by_name() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let refused = |objects: &Objects| Scene::new(gpu, objects).unwrap_err().to_string();
    let good = heap(44, 3);

    let mut objects = good.clone();
    objects.objects[1].template = 9;
    assert!(refused(&objects).starts_with("object 1: "), "{}", refused(&objects));
    let mut objects = good.clone();
    objects.templates[2].triangles[0][1] = 99;
    assert!(refused(&objects).starts_with("template 2: "), "{}", refused(&objects));
    let mut objects = good.clone();
    objects.templates[0].positions[0].y = f32::NAN;
    assert!(refused(&objects).starts_with("template 0: "), "{}", refused(&objects));
    let mut objects = good.clone();
    objects.masks[0] = Mask { width: 5, height: 7, words: vec![0] };
    assert!(refused(&objects).contains("mask 0"), "{}", refused(&objects));

    let mut renderer = renderer(gpu, &good, Settings::default());
    assert_eq!(renderer.end().unwrap_err().to_string(), "frame: not begun");
    assert_eq!(renderer.ask(&[], &[]).unwrap_err().to_string(), "frame: not begun");
    assert!(renderer.image().is_err());
    renderer.begin(&square_on(&good, 4, 4)).unwrap();
    assert!(renderer.draw(&[0, 3]).unwrap_err().to_string().contains('3'));
    let boxes = [flat_box([0.0, 1.0], [0.0, 1.0], -1.0)];
    assert!(renderer.ask(&boxes, &[Query { boxes: 0..2 }]).is_err());
    // A refusal leaves the frame as it was.
    assert_eq!(counts(&mut renderer, &boxes).len(), 1);
    renderer.end().unwrap();
    let mut view = square_on(&good, 4, 4);
    view.width = gpu.limits().max_texture_dimension_2d + 1;
    let error = renderer.begin(&view).unwrap_err().to_string();
    assert!(error.contains("max_texture_dimension_2d"), "{error}");
}
