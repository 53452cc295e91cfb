//! Light trees beside a bounding volume hierarchy over as many boxes, on the same threads; what follows
//! a light, and a small tree made anew every frame.
//!
//! What is timed is checked before: every light is in one leaf, in the boxes and cones above it. Sizes
//! are small; `DAPPLE_LIGHTS=1000000` (any number) times that many instead.
#![allow(missing_docs, reason = "criterion_group! writes an undocumented function")]
#![allow(clippy::expect_used, reason = "a bench must not time what is wrong")]

use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use dapple_many_lights::{
    Emission, Light, LightTree, Node, PackedNode,
    sample::hash,
    tree::{Build, EXACT, Representative},
};
use glam::{DVec3, Vec3A};
use obvhs::{BvhBuildParams, aabb::Aabb, bvh2::builder::build_bvh2};
use std::{hint::black_box, time::Duration};

const WEIGHTED: Representative = Representative::Weighted;

/// Windows of blocks of buildings: axes to four sides, three a storey, any height up to 7.
fn windows(count: usize) -> Vec<Light> {
    let side = (count as f64 / 84.0).sqrt().ceil() as usize;
    let emission = Emission::Spot { half_angle_rad: std::f64::consts::FRAC_PI_4 };
    (0..count)
        .map(|i| {
            let (building, facade, storey, window) = (i / 84, i / 21 % 4, i / 3 % 7, i % 3);
            let [axis, along] = match facade {
                0 => [DVec3::X, DVec3::Z],
                1 => [DVec3::Z, -DVec3::X],
                2 => [-DVec3::X, -DVec3::Z],
                _ => [-DVec3::Z, DVec3::X],
            };
            let middle = DVec3::new((building % side) as f64, 0.0, (building / side) as f64) * 30.0;
            let up = DVec3::Y * (3.0 * storey as f64 + 1.5);
            let position = middle + 10.0 * axis + along * (6.0 * window as f64 - 6.0) + up;
            let intensity = DVec3::splat(10.0 + f64::from(hash(i as u32) % 1000) * 0.01);
            Light { position, axis, intensity, emission }
        })
        .collect()
}

/// Paths by building, facade and storey.
fn keys(count: usize) -> Vec<Vec<u32>> {
    (0..count as u32).map(|i| vec![i / 84 / 16, i / 84, i / 21 % 4, i / 3 % 7]).collect()
}

fn sizes() -> Vec<usize> {
    let asked = std::env::var("DAPPLE_LIGHTS").ok();
    asked.map_or(vec![1000, 10_000], |asked| vec![asked.parse().expect("a number of lights")])
}

fn builds(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("light trees");
    group.sample_size(10).warm_up_time(Duration::from_millis(500));
    group.measurement_time(Duration::from_secs(2));
    for count in sizes() {
        let (lights, keys) = (windows(count), keys(count));
        group.throughput(Throughput::Elements(count as u64));
        let ways = [
            ("greedy", Build::Greedy { spread: 1.0 }),
            ("locally ordered", Build::LocallyOrdered { spread: 1.0 }),
            ("median", Build::Median),
            ("given hierarchy", Build::Keys(&keys)),
            ("surface area", Build::SurfaceArea),
        ];
        for (name, build) in ways {
            if matches!(build, Build::Greedy { .. }) && count > EXACT {
                continue;
            }
            let tree = LightTree::build(&lights, build, WEIGHTED).expect("lights are sound");
            tree.check(&lights).expect("a tree holds its lights");
            eprintln!("{name}: {}", bytes(tree.nodes.len(), count));
            group.bench_function(BenchmarkId::new(name, count), |bencher| {
                bencher.iter(|| LightTree::build(black_box(&lights), build, WEIGHTED));
            });
        }
        let boxes: Vec<Aabb> = lights
            .iter()
            .map(|light| {
                let at = light.position.as_vec3();
                let [min, max] = [at - 0.05, at + 0.05].map(Vec3A::from);
                Aabb { min, max }
            })
            .collect();
        let params = BvhBuildParams::fast_build();
        let bvh = build_bvh2(&boxes, params, &mut Duration::default());
        assert_eq!(bvh.primitive_indices.len(), count, "every box is in the hierarchy");
        eprintln!("obvhs: {:.1} bytes a box", size_of_val(&bvh.nodes[..]) as f64 / count as f64);
        group.bench_function(BenchmarkId::new("obvhs fast", count), |bencher| {
            bencher.iter(|| build_bvh2(black_box(&boxes), params, &mut Duration::default()));
        });
    }
    group.finish();
}

/// Bytes a light of a tree as it is fitted and as it is walked.
fn bytes(nodes: usize, lights: usize) -> String {
    let of = |size: usize| (nodes * size) as f64 / lights as f64;
    let (fitted, walked) = (of(size_of::<Node>()), of(size_of::<PackedNode>()));
    format!("{:.2} nodes a light, {fitted:.0} bytes a light, packed {walked:.0}", of(1))
}

fn changes(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("light tree changes");
    group.sample_size(10).warm_up_time(Duration::from_millis(300));
    group.measurement_time(Duration::from_secs(1));
    for count in sizes() {
        let mut lights = windows(count);
        let mut tree = LightTree::median(&lights).expect("lights are sound");
        let mut packed = tree.pack();
        group.bench_function(BenchmarkId::new("pack", count), |bencher| {
            bencher.iter(|| black_box(&tree).pack());
        });
        let mut next = 0;
        group.bench_function(BenchmarkId::new("one light moved", count), |bencher| {
            bencher.iter(|| {
                next = (next + 7919) % count;
                lights[next].position.x += 0.01;
                let visits = tree.moved(&lights, next as u32, WEIGHTED).expect("of its kind");
                packed.moved(&tree, next as u32);
                visits
            });
        });
        tree.check(&lights).expect("the tree followed");
        // A small tree beside it, as for cars: clustered, packed and put in place each frame.
        let moving = windows(512);
        let extent = tree.extent();
        group.bench_function(BenchmarkId::new("512 lights anew", count), |bencher| {
            bencher.iter_batched_ref(
                || moving.clone(),
                |moving| {
                    let second = LightTree::median(moving).expect("lights are sound");
                    tree.replace_after(extent, &second);
                    packed.replace_after(extent, &second.pack());
                },
                BatchSize::SmallInput,
            );
        });
        tree.check(&[lights, moving].concat()).expect("both trees hold their lights");
    }
    group.finish();
}

criterion_group!(trees, builds, changes);
criterion_main!(trees);
