//! A city at night, stage by stage: cells of a frame, whole frames on the processor and on a device,
//! from nothing and standing still, and lights that move.
//!
//! What is timed is checked before: cells hold what is visible once, frames are lit, a device's are the
//! processor's, and lights that move make them brighter.
#![allow(missing_docs, reason = "criterion_group! writes an undocumented function")]
#![allow(clippy::expect_used, reason = "a bench must not time what is wrong")]

use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use criterion::{BenchmarkId, measurement::WallTime};
use dapple_gpu::{AdapterChoice, Gpu};
use dapple_many_lights::{
    Emission, Light, LightTree, Shaded,
    tree::{Build, Representative},
};
use dapple_night_city::{Device, Night, Part, Pipeline, Town};
use dapple_occlusion::camera::{CellLimits, exact_coverage, view_cells};
use dapple_suite::{
    case::Case,
    knob::{self, Knobs},
    night,
    problems::night_city::SPEC,
};
use glam::{DVec3, Vec3};
use std::{hint::black_box, sync::Arc, time::Duration};

/// Cuts on a device differ where a bound is within rounding of the threshold.
const WITHIN: f32 = 4.0 / 25_500.0;

fn city() -> night::Night {
    let given: Knobs = [("width".into(), 64.into()), ("frames".into(), 2.into())].into();
    let case = Case {
        problem: SPEC.id.into(),
        scene: "city_small".into(),
        view: "street".into(),
        seed: 0,
        parameters: knob::complete("parameter", SPEC.parameters, &given).expect("in range"),
    };
    night::Night::load(&case).expect("a generated city")
}

fn group<'a>(criterion: &'a mut Criterion, name: &str) -> BenchmarkGroup<'a, WallTime> {
    let mut group = criterion.benchmark_group(format!("night/{name}"));
    group.sample_size(10).warm_up_time(Duration::from_millis(200));
    group.measurement_time(Duration::from_millis(700));
    group
}

/// From what is covered to cells.
fn cells(criterion: &mut Criterion) {
    let night = city();
    let town = &night.town;
    let pixels = night.pixels(0);
    let objects = 0..pixels.len() as u32;
    let visible: Vec<u32> = objects.filter(|object| pixels[*object as usize] > 0).collect();
    let mut coverage = vec![0; town.tree.nodes.len()];
    let limits = |part| CellLimits { tau_px: 1, most_level: town.most_level(part) };
    let mut group = group(criterion, "cells");
    group.throughput(Throughput::Elements(visible.len() as u64));
    for (name, part) in [("any", Part::Any), ("facade", Part::Facade)] {
        let mut divide = || {
            exact_coverage(&town.tree, &pixels, &mut coverage).expect("its own tree");
            view_cells(&town.tree, &coverage, town.levels(), &visible, limits(part))
                .expect("its own tree")
        };
        let found = divide();
        let mut held: Vec<u32> =
            (0..found.cells.len()).flat_map(|cell| found.objects_of(cell)).copied().collect();
        held.sort_unstable();
        assert_eq!(held, visible, "{name}: each visible object is in one cell");
        group.bench_function(name, |bencher| bencher.iter(&mut divide));
    }
    group.finish();
}

fn lit(pipeline: &mut Pipeline<'_>, index: usize) -> Vec<Vec3> {
    let mut shaded = Shaded::default();
    pipeline.frame(index, false).expect("a frame");
    pipeline.read(&mut shaded).expect("it was lit");
    let lit = shaded.radiance.iter().filter(|radiance| **radiance != Vec3::ZERO).count();
    assert!(10 * lit > shaded.radiance.len(), "frame {index}: {lit} pixels are lit");
    shaded.radiance
}

/// The first frame with nothing known of it, and again.
fn times(
    group: &mut BenchmarkGroup<'_, WallTime>,
    name: &str,
    town: &Arc<Town>,
    device: Option<&Device<'_>>,
) -> Vec<Vec3> {
    let mut pipeline = Pipeline::new(town, &Night::default(), device).expect("sound settings");
    let image = lit(&mut pipeline, 0);
    group.bench_function(BenchmarkId::new("from nothing", name), |bencher| {
        bencher.iter(|| {
            pipeline.reset().expect("a device");
            pipeline.frame(black_box(0), false).expect("a frame")
        });
    });
    group.bench_function(BenchmarkId::new("standing still", name), |bencher| {
        bencher.iter(|| pipeline.frame(black_box(0), false).expect("a frame"));
    });
    image
}

fn frames(criterion: &mut Criterion) {
    let night = city();
    let town = &night.town;
    let mut group = group(criterion, "frame");
    let processor = times(&mut group, "cpu", town, None);
    match Gpu::open(&AdapterChoice::Auto) {
        Ok(gpu) => {
            let device = Device::new(&gpu, town.world(false)).expect("a device large enough");
            let image = times(&mut group, "gpu", town, Some(&device));
            let pairs = image.iter().zip(&processor);
            let off = pairs.map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max);
            assert!(off <= WITHIN, "the device's frame is {off} from the processor's");
        }
        Err(error) => eprintln!("gpu forms are not run: {error}"),
    }
    group.finish();
}

/// Cars' lights: a tree of their own, made anew every frame and put beside the city's.
fn moving(criterion: &mut Criterion) {
    let night = city();
    let town = &night.town;
    let mut pipeline = Pipeline::new(town, &Night::default(), None).expect("sound settings");
    let without = lit(&mut pipeline, 0);
    let points = &town.world(false).frames[0].points;
    let mut group = group(criterion, "moving");
    for count in [64_u32, 512] {
        let at = |index: u32| points[index as usize * points.len() / count as usize];
        let shown = (0..count).map(at).filter(|point| point.is_there());
        let lights: Vec<Light> = shown
            .map(|point| Light {
                position: (point.position + point.normal).as_dvec3(),
                axis: DVec3::NEG_Y,
                intensity: DVec3::ONE,
                emission: Emission::Omni,
            })
            .collect();
        let mut replace = || {
            let tree = LightTree::build(&lights, Build::Median, Representative::Weighted);
            let tree = tree.expect("lights are sound");
            pipeline.replace_moving(black_box(&lights), &tree).expect("lights are sound")
        };
        replace();
        group.throughput(Throughput::Elements(lights.len() as u64));
        group.bench_function(BenchmarkId::from_parameter(count), |bencher| {
            bencher.iter(&mut replace);
        });
        let with = lit(&mut pipeline, 0);
        let brighter = with.iter().zip(&without).filter(|(a, b)| a.cmpgt(**b).any()).count();
        assert!(10 * brighter > with.len(), "{count} lights: {brighter} pixels are brighter");
    }
    group.finish();
}

criterion_group!(benches, cells, frames, moving);
criterion_main!(benches);
