//! The software renderer of cities: frames drawn completely, boxes asked, and its two limits, tiny
//! triangles and large ones.
//!
//! What is timed is checked before: every pixel of the reference's coverage is drawn.
#![allow(missing_docs, reason = "criterion_group! writes an undocumented function")]
#![allow(clippy::expect_used, reason = "a bench must not time what is wrong")]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use dapple_occlusion::camera::software::{Fast, Reference};
use dapple_occlusion::camera::{
    Bounds, Object, Objects, Query, Readiness, Renderer, Template, View,
};
use dapple_scene::{Camera, Projection, generate};
use glam::{DVec3, Mat3, Vec3};
use std::{hint::black_box, sync::Arc};

const NEAR_M: f64 = 0.1;
const NOW: Readiness = Readiness::Modelled(0);

fn list(objects: &Objects) -> Vec<u32> {
    (0..objects.objects.len() as u32).collect()
}

fn draw(renderer: &mut dyn Renderer, view: &View, list: &[u32]) {
    renderer.begin(view).expect("the image has pixels");
    renderer.draw(list).expect("the objects are there");
    renderer.end().expect("a software renderer ends");
}

/// A renderer that has drawn what the reference draws, up to the pixels beside edges.
fn checked(objects: &Arc<Objects>, view: &View, list: &[u32]) -> Fast {
    let mut reference = Reference::new(objects.clone(), NOW).expect("generated objects are sound");
    let mut fast = Fast::new(objects.clone(), NOW).expect("generated objects are sound");
    draw(&mut reference, view, list);
    draw(&mut fast, view, list);
    let pairs = || reference.image().ids.iter().zip(&fast.image().ids);
    let covered = pairs().filter(|(a, _)| a[0] > 0).count();
    let differ = pairs().filter(|(a, b)| (a[0] > 0) != (b[0] > 0)).count();
    assert!(covered > 0 && differ * 50 < covered, "{differ} of {covered} pixels");
    fast
}

fn cities(criterion: &mut Criterion) {
    let scene = generate::by_name("city", 1).expect("a generator of that name");
    let (objects, _) = Objects::from_scene(&scene, 1024).expect("a city has triangles");
    let objects = Arc::new(objects);
    let list = list(&objects);
    let triangles: u64 = list.iter().map(|&i| u64::from(objects.triangle_count(i))).sum();
    let mut group = criterion.benchmark_group("software_city");
    group.sample_size(20);
    for camera in &scene.cameras {
        let view = View::new(camera, &objects, 320, 180, NEAR_M).expect("a camera of the scene");
        let mut fast = checked(&objects, &view, &list);
        group.throughput(Throughput::Elements(triangles));
        group.bench_function(BenchmarkId::new("draw", &camera.name), |bencher| {
            bencher.iter(|| draw(black_box(&mut fast), &view, &list));
        });
        let boxes: Vec<Bounds> =
            objects.objects.iter().map(|o| o.bounds).filter(|b| view.sees(b)).take(1000).collect();
        let queries: Vec<Query> =
            (0..boxes.len() as u32).map(|i| Query { boxes: i..i + 1 }).collect();
        let mut counts = Vec::new();
        group.throughput(Throughput::Elements(boxes.len() as u64));
        group.bench_function(BenchmarkId::new("ask", &camera.name), |bencher| {
            bencher.iter(|| {
                counts.clear();
                fast.ask(&boxes, &queries).expect("finite boxes");
                fast.collect(&mut counts).expect("a batch was asked");
                black_box(&counts);
            });
        });
    }
    group.finish();
}

/// Squares of two triangles, `side` x `side` of them of `size` metres, ten metres away.
fn sheet(side: u32, size: f32, behind: f32) -> (Template, Bounds) {
    let at = |i: u32| (i as f32 - 0.5 * side as f32) * size;
    let corner = |i: u32| Vec3::new(at(i % (side + 1)), at(i / (side + 1)), -10.0 - behind);
    let square = |i: u32| {
        let (a, below) = (i / side * (side + 1) + i % side, side + 1);
        [[a, a + 1, a + below], [a + 1, a + below + 1, a + below]]
    };
    let positions: Vec<Vec3> = (0..(side + 1) * (side + 1)).map(corner).collect();
    let bounds = Bounds { min: positions[0], max: positions[positions.len() - 1] };
    let triangles = (0..side * side).flat_map(square).collect();
    (Template { positions, triangles, ..Template::default() }, bounds)
}

fn limits(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("software_limits");
    group.sample_size(10);
    let projection = Projection::Perspective { fov_y_rad: 1.0 };
    let (position, target, up) = (DVec3::ZERO, DVec3::NEG_Z, DVec3::Y);
    let camera = Camera { name: "front".into(), position, target, up, projection };
    // A pixel of 1080 rows is about 0.0101 m wide there.
    for (name, side, size, sheets) in
        [("sub_pixel", 100, 0.002, 20), ("pixel", 100, 0.0101, 20), ("image", 1, 40.0, 20)]
    {
        let mut objects = Objects::default();
        for i in 0..sheets {
            let (template, bounds) = sheet(side, size, 0.001 * i as f32);
            objects.templates.push(template);
            let (linear, translation) = (Mat3::IDENTITY, Vec3::ZERO);
            objects.objects.push(Object { template: i, linear, translation, bounds });
        }
        let objects = Arc::new(objects);
        let view = View::new(&camera, &objects, 1920, 1080, NEAR_M).expect("a plain camera");
        // Back to front: every pixel is written every time.
        let list: Vec<u32> = list(&objects).into_iter().rev().collect();
        let mut fast = checked(&objects, &view, &list);
        group.throughput(match side {
            1 => Throughput::Elements(1920 * 1080 * u64::from(sheets)),
            _ => Throughput::Elements(2 * u64::from(side * side * sheets)),
        });
        group.bench_function(name, |bencher| {
            bencher.iter(|| draw(black_box(&mut fast), &view, &list));
        });
    }
    group.finish();
}

criterion_group!(software, cities, limits);
criterion_main!(software);
