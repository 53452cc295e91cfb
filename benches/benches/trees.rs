//! Hierarchies over the objects of cities: by smallest surface, and by the city's own order.
//!
//! What is timed is checked before: every object lies below the root once, within the boxes of all
//! nodes above it.
#![allow(missing_docs, reason = "criterion_group! writes an undocumented function")]
#![allow(clippy::expect_used, reason = "a bench must not time what is wrong")]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use dapple_occlusion::camera::{Objects, Tree, city_keys};
use dapple_scene::generate;
use std::hint::black_box;

fn builds(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("trees");
    group.sample_size(10);
    for name in ["city_small", "city"] {
        let made = generate::city_of(name, 1).expect("a generator of that name").scene();
        let (objects, owners) =
            Objects::from_scene(&made.scene, 1024).expect("a city has triangles");
        assert_eq!(objects.objects.len(), made.parts.len());
        let keys = city_keys(&made.parts, &made.scene, &owners, &objects);
        group.throughput(Throughput::Elements(keys.len() as u64));
        for tree in [Tree::bottom_up(&objects), Tree::by_keys(&objects, &keys)] {
            let tree = tree.expect("generated objects are sound");
            tree.validate(&objects).expect("a tree holds its objects");
        }
        group.bench_function(BenchmarkId::new("bottom-up", name), |bencher| {
            bencher.iter(|| Tree::bottom_up(black_box(&objects)));
        });
        group.bench_function(BenchmarkId::new("city", name), |bencher| {
            bencher.iter(|| Tree::by_keys(black_box(&objects), &keys));
        });
    }
    group.finish();
}

criterion_group!(trees, builds);
criterion_main!(trees);
