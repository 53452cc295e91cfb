//! Hierarchical depth on the processor: the pyramid by size of image, and frames of a city, flat and
//! down the tree, beside drawing all that the frustum holds.
//!
//! What is timed is checked before: the top of the pyramid is the farthest depth, and a frame's
//! depths are those of everything.
#![allow(missing_docs, reason = "criterion_group! writes an undocumented function")]
#![allow(clippy::expect_used, reason = "a bench must not time what is wrong")]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use dapple_occlusion::camera::hierarchical_depth::{Pyramid, Settings, Traversal, cpu};
use dapple_occlusion::camera::software::Fast;
use dapple_occlusion::camera::{Frame, Objects, Readiness, Renderer, Tree, View};
use dapple_scene::generate;
use std::{hint::black_box, sync::Arc};

const NEAR_M: f64 = 0.1;
const NOW: Readiness = Readiness::Modelled(0);

fn pyramids(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("hierarchical_depth_pyramid");
    for (width, height) in [(320_u32, 180_u32), (1920, 1080), (1921, 1081)] {
        let depth: Vec<f32> =
            (0..width * height).map(|i| (i.wrapping_mul(0x9e37_79b9) >> 8) as f32).collect();
        let mut pyramid = Pyramid::default();
        pyramid.build(width, height, &depth);
        let farthest = depth.iter().copied().fold(f32::INFINITY, f32::min);
        assert_eq!(pyramid.texels().last(), Some(&farthest));
        group.throughput(Throughput::Bytes(pyramid.bytes()));
        group.bench_function(format!("{width} x {height}"), |bencher| {
            bencher.iter(|| pyramid.build(width, height, black_box(&depth)));
        });
    }
    group.finish();
}

fn cities(criterion: &mut Criterion) {
    let scene = generate::by_name("city", 1).expect("a generator of that name");
    let (objects, _) = Objects::from_scene(&scene, 1024).expect("a city has triangles");
    let objects = Arc::new(objects);
    let tree = Tree::bottom_up(&objects).expect("fewer than 2^31 objects");
    let mut renderer = Fast::new(objects.clone(), NOW).expect("generated objects are sound");
    let mut group = criterion.benchmark_group("hierarchical_depth_city");
    group.sample_size(10);
    for camera in &scene.cameras {
        let view = View::new(camera, &objects, 320, 180, NEAR_M).expect("a camera of the scene");
        let seen: Vec<u32> = (0..objects.objects.len() as u32)
            .filter(|&o| view.sees(&objects.objects[o as usize].bounds))
            .collect();
        let frustum = |renderer: &mut Fast| {
            renderer.begin(&view).expect("the image has pixels");
            renderer.draw(&seen).expect("the objects are there");
            renderer.end().expect("a software renderer ends");
        };
        frustum(&mut renderer);
        let everything = renderer.image().depth.clone();
        group.bench_function(BenchmarkId::new("frustum", &camera.name), |bencher| {
            bencher.iter(|| frustum(black_box(&mut renderer)));
        });
        for (name, traversal) in [("flat", Traversal::Flat), ("tree", Traversal::Tree)] {
            let settings = Settings { traversal, ..Settings::default() };
            let mut state = cpu::State::new(&objects, &tree);
            let mut frame = Frame::default();
            let mut next = |renderer: &mut Fast| {
                cpu::frame(&settings, &objects, &tree, &view, &mut state, renderer, &mut frame)
                    .expect("the state is of these objects");
                frame.work
            };
            next(&mut renderer);
            let work = next(&mut renderer);
            assert_eq!(renderer.image().depth, everything, "{}", camera.name);
            assert!(work.draws <= seen.len() as u64);
            group.bench_function(BenchmarkId::new(name, &camera.name), |bencher| {
                bencher.iter(|| next(black_box(&mut renderer)));
            });
        }
    }
    group.finish();
}

criterion_group!(hierarchical_depth, pyramids, cities);
criterion_main!(hierarchical_depth);
