//! What is drawn.

use crate::oracle::faults;
use crate::support::*;
use dapple_occlusion::camera::gpu::{Drawing, Scene, Settings};
use dapple_occlusion::camera::renderer::Renderer as _;
use dapple_occlusion::camera::software::Reference;
use dapple_occlusion::camera::{Image, Mask, Objects, Readiness, Template};
use glam::{DVec3, Mat3, Vec2, Vec3};
use std::sync::Arc;

#[test]
fn every_pixel_shows_what_lies_in_front() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let (width, height) = (97, 61);
    for seed in 0..3 {
        let objects = heap(seed, 60);
        let mut renderer = renderer(gpu, &objects, Settings::default());
        for view in views(&objects, width, height) {
            let mut image = draw_all(&mut renderer, &view, &objects);
            let (found, certain) = faults(&view, &objects, &image);
            assert!(found.is_empty(), "seed {seed}: {} of {found:#?}", found.len());
            // Few pixels leave a choice, so that this says something.
            assert!(certain * 10 > (width * height) as usize * 9, "{certain}");
            // Control: an image moved by a pixel is found out.
            image.ids.rotate_right(1);
            image.depth.rotate_right(1);
            let (found, _) = faults(&view, &objects, &image);
            assert!(found.len() > 100, "{}", found.len());
        }
    }
}

#[test]
fn the_image_is_the_software_reference() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let (width, height) = (211, 127);
    let objects = heap(11, 400);
    let mut device = renderer(gpu, &objects, Settings::default());
    let mut reference = Reference::new(Arc::new(objects.clone()), Readiness::Modelled(0)).unwrap();
    for view in views(&objects, width, height) {
        let image = draw_all(&mut device, &view, &objects);
        reference.begin(&view).unwrap();
        reference.draw(&all(&objects)).unwrap();
        reference.end().unwrap();
        // The reference is one of the images that may be; so both differ where there is a choice.
        let (found, certain) = faults(&view, &objects, reference.image());
        assert!(found.is_empty(), "{} of {found:#?}", found.len());
        let (found, _) = faults(&view, &objects, &image);
        assert!(found.is_empty(), "{} of {found:#?}", found.len());
        let pixels = (width * height) as usize;
        let same = (0..pixels).filter(|i| image.ids[*i] == reference.image().ids[*i]).count();
        assert!(same >= certain, "{same} pixels are the same, {certain} must be");
        assert!(same * 200 > pixels * 199, "{same} of {pixels} are the same");
    }
}

#[test]
fn the_deferred_image_maps_every_pixel_to_its_triangle() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let objects = heap(5, 150);
    let mut renderer = renderer(gpu, &objects, Settings::default());
    for view in views(&objects, 160, 90) {
        let image = draw_all(&mut renderer, &view, &objects);
        let surface = renderer.surface().unwrap();
        let (mut covered, unprojected) = (0, view.clip.inverse());
        for (pixel, (&[object, triangle], &depth)) in image.ids.iter().zip(&image.depth).enumerate()
        {
            let (normal, albedo) = (surface.normals[pixel], surface.albedo[pixel]);
            if object == 0 {
                assert_eq!((triangle, depth, normal, albedo), (0, 0.0, [0.0; 3], [0; 3]));
                continue;
            }
            let (x, y) = (pixel as u32 % image.width, pixel as u32 / image.width);
            let ndc = DVec3::new(
                (f64::from(x) + 0.5) / f64::from(image.width) * 2.0 - 1.0,
                1.0 - (f64::from(y) + 0.5) / f64::from(image.height) * 2.0,
                f64::from(depth),
            );
            let p = unprojected.project_point3(ndc);
            let corners = objects.triangles(object - 1).nth(triangle as usize).unwrap();
            let [a, b, c] = corners.map(|corner| corner.as_dvec3());
            let n = (b - a).cross(c - a).normalize();
            let distance = (p - view.eye).dot(view.forward);
            let off = n.dot(p - a).abs();
            // Snapped corners move the plane by that much of a pixel; the rest is rounding.
            assert!(
                off <= view.pixel_m(distance) / 100.0 + 2e-5 * distance.max(1.0),
                "pixel {pixel}: {off} m at {distance} m"
            );
            let seen = Vec3::from(normal).as_dvec3();
            let away = if view.parallel { view.forward } else { p - view.eye };
            // Devices may truncate to 16 bits.
            assert!((seen.length() - 1.0).abs() < 2e-3, "{normal:?}");
            assert!(n.dot(seen.normalize()).abs() > 0.99999, "{normal:?} for {n}");
            assert!(seen.dot(away.normalize()) < 1e-2, "pixel {pixel}: looks away");
            let template =
                &objects.templates[objects.objects[object as usize - 1].template as usize];
            let srgb = template.albedo.to_array().map(|linear| {
                let l = f64::from(linear);
                let s = if l <= 0.0031308 { 12.92 * l } else { 1.055 * l.powf(1.0 / 2.4) - 0.055 };
                255.0 * s
            });
            for (stored, right) in albedo.iter().zip(srgb) {
                assert!((f64::from(*stored) - right).abs() <= 1.0, "{albedo:?} for {srgb:?}");
            }
            covered += 1;
        }
        assert!(covered > 1000, "only {covered} pixels are covered");
    }
}

#[test]
fn all_ways_of_drawing_give_the_same_image() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let objects = heap(8, 500);
    let scene = Scene::new(gpu, &objects).unwrap();
    for view in views(&objects, 120, 80) {
        let mut images: Vec<(Image, u64)> = Vec::new();
        for drawing in [Drawing::PerObject, Drawing::Instanced, Drawing::PerQuad] {
            let settings = Settings { drawing, ..Settings::default() };
            let mut renderer =
                dapple_occlusion::camera::gpu::Renderer::new(gpu, &scene, settings).unwrap();
            let image = draw_all(&mut renderer, &view, &objects);
            images.push((image, renderer.counters().draw_calls));
        }
        let [(each, calls), (instanced, few), (quads, many)] = &images[..] else { unreachable!() };
        assert!(each == instanced && each == quads);
        assert_eq!((*calls, *few), (500, objects.templates.len() as u64));
        let quads: usize = (0..500).map(|i| objects.triangle_count(i).div_ceil(2) as usize).sum();
        assert_eq!(*many, quads as u64);
    }
}

#[test]
fn a_mask_cuts_holes_where_its_texels_are_not() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    // 4 x 2 texels, repeated twice each way over 64 x 64 pixels at 32 m: 8 x 16 pixels a texel.
    let mask = Mask { width: 4, height: 2, words: vec![0b0101_1010] };
    let wall = rectangle([-40.0, 40.0], [-40.0, 40.0], -40.0);
    let mut leaf = Template { mask: Some(0), ..rectangle([-32.0, 32.0], [-32.0, 32.0], -32.0) };
    for uv in &mut leaf.uvs {
        *uv *= 2.0;
    }
    let mut objects = Objects { masks: vec![mask.clone()], ..Objects::default() };
    let (leaf, wall) = (add(&mut objects, leaf), add(&mut objects, wall));
    let view = square_on(&objects, 64, 64);
    let image = draw_all(&mut renderer(gpu, &objects, Settings::default()), &view, &objects);
    let mut holes = 0;
    for (pixel, id) in (0..).zip(&image.ids) {
        // Rows of pixels go down, v up.
        let (x, y) = (pixel % 64, 63 - pixel / 64);
        let uv = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / 32.0;
        let there = mask.at(uv);
        holes += u32::from(!there);
        assert_eq!(id[0], 1 + if there { leaf } else { wall }, "pixel {x}, {y}");
    }
    assert_eq!(holes, 64 * 64 / 2);
}

#[test]
fn the_first_drawn_wins_ties() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let mut objects = Objects::default();
    let template = add_template(&mut objects, rectangle([-9.0, 9.0], [-9.0, 9.0], -10.0));
    for _ in 0..2 {
        place(&mut objects, template, Mat3::IDENTITY, Vec3::ZERO);
    }
    let view = square_on(&objects, 8, 8);
    let mut renderer = renderer(gpu, &objects, Settings::default());
    for order in [[0, 1], [1, 0]] {
        renderer.begin(&view).unwrap();
        renderer.draw(&order).unwrap();
        renderer.end().unwrap();
        let image = renderer.image().unwrap();
        assert_eq!(image.ids[8 * 4 + 4][0], order[0] + 1);
    }
}
