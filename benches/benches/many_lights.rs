//! Light by many lights, a frame on one small world: the sum of all by light and pixel, cuts by node
//! visited, bounds by node, samplers by sample, reservoirs and light lists by pixel.
//!
//! What is timed is checked before: the image of the timed form is the reference's, but for pixels
//! where rounding decides a cut or a draw, and it took the work that it is divided by.
#![allow(missing_docs, reason = "criterion_group! writes an undocumented function")]
#![allow(clippy::expect_used, reason = "a bench must not time what is wrong")]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use dapple_many_lights::{
    Absolute, BoundForm, Capped, Clustered, Form, LightBvh, LightTree, Lightcuts, Lighting, Per,
    Reservoirs, Selection, Shaded, StochasticLightcuts, Technique, Work, World,
    bound::packed::{clamp_squared, point},
    clustered::{Grid, Hierarchy, cells},
    make,
    tree::{Build, Representative},
    worlds::{Cloud, WINDOW, cloud},
};
use std::{hint::black_box, sync::Arc, time::Duration};

/// The thesis's threshold.
const THRESHOLD: f64 = 1.0 / 25_500.0;

/// Windows between walls: the pixels of a small frame, and one light in eight lights each well.
fn world(lights: u32) -> Arc<World> {
    let cloud =
        cloud(&Cloud { lights, emissions: vec![WINDOW], size: [128, 96], ..Cloud::default() });
    Arc::new(cloud.world)
}

fn original(world: &World) -> Arc<LightTree> {
    let tree = LightTree::original(&world.lights, Representative::Weighted);
    Arc::new(tree.expect("lights are sound"))
}

fn light(
    form: Form,
    technique: &Technique,
    world: &Arc<World>,
    tree: &Arc<LightTree>,
) -> (Box<dyn Lighting>, Shaded) {
    let mut lighting = make(form, technique, world, tree, None).expect("settings are sound");
    let mut shaded = Shaded::default();
    lighting.reset(0).expect("nothing was lit");
    lighting.shade(0, true).expect("there is a frame");
    lighting.read(&mut shaded).expect("a frame was lit");
    (lighting, shaded)
}

/// The processor's form, checked against the reference in at least that share of the pixels.
fn checked(
    technique: &Technique,
    world: &Arc<World>,
    tree: &Arc<LightTree>,
    share: f64,
) -> (Box<dyn Lighting>, Work) {
    let (_, reference) = light(Form::Reference, technique, world, tree);
    let (lighting, shaded) = light(Form::Cpu, technique, world, tree);
    let pairs = shaded.radiance.iter().zip(&reference.radiance);
    let alike = |(a, b): &(&glam::Vec3, &glam::Vec3)| {
        (**a - **b).abs().max_element() <= 1e-5_f32.max(1e-3 * b.max_element())
    };
    let alike = pairs.filter(alike).count();
    let bright: f32 = reference.radiance.iter().map(|r| r.max_element()).sum();
    assert!(bright > 1.0, "{technique:?}: a dark image");
    let all = shaded.radiance.len() as f64;
    assert!(alike as f64 >= share * all, "{technique:?}: {alike} of {all} pixels agree");
    (lighting, shaded.work)
}

/// Frames of one technique, by what it does most.
fn technique(
    criterion: &mut Criterion,
    group: &str,
    name: BenchmarkId,
    (technique, world, tree): (&Technique, &Arc<World>, &Arc<LightTree>),
    share: f64,
    elements: impl Fn(&Work) -> u64,
) {
    let (mut lighting, work) = checked(technique, world, tree, share);
    let mut group = criterion.benchmark_group(format!("many lights/{group}"));
    group.sample_size(10).warm_up_time(Duration::from_millis(300));
    group.measurement_time(Duration::from_secs(1));
    let elements = elements(&work);
    assert!(elements > 0, "{technique:?}: no work was counted: {work:?}");
    group.throughput(Throughput::Elements(elements));
    group.bench_function(name, |bencher| {
        bencher.iter(|| lighting.shade(black_box(0), false).expect("a frame"));
    });
    group.finish();
}

fn sums(criterion: &mut Criterion) {
    let none = Arc::new(LightTree::default());
    for lights in [100, 1000] {
        let world = world(lights);
        let name = BenchmarkId::new("brute force", lights);
        let all = |work: &Work| work.lights;
        technique(criterion, "sums", name, (&Technique::BruteForce, &world, &none), 1.0, all);
    }
}

fn cuts(criterion: &mut Criterion) {
    let world = world(4000);
    let tree = original(&world);
    for (per, name) in [(Per::Pixel, "a pixel"), (Per::Tile, "a tile")] {
        for bound in [BoundForm::Cheap, BoundForm::Walter] {
            let cut = Technique::Absolute(Absolute { threshold: THRESHOLD, bound, per });
            let name = BenchmarkId::new(name, format!("{bound:?}"));
            // Of a tile the nodes of its one walk, seen by each of its pixels.
            technique(criterion, "cuts", name, (&cut, &world, &tree), 0.99, |work| work.visits);
        }
    }
    for selection in [Selection::Heap, Selection::Scan] {
        let bound = BoundForm::Cheap;
        let cut = Technique::Lightcuts(Lightcuts { epsilon: 0.02, most: 1000, selection, bound });
        let name = BenchmarkId::new("lightcuts", format!("{selection:?}"));
        technique(criterion, "cuts", name, (&cut, &world, &tree), 0.99, |work| work.visits);
    }
}

/// One bound after the other, as a walk meets nodes; every one is held to what the f64 form gives.
fn bounds(criterion: &mut Criterion) {
    let world = world(1000);
    let tree = original(&world);
    let packed = tree.pack();
    let receiver = world.frames[0].points.iter().rfind(|p| p.is_there()).expect("ground");
    let clamp = clamp_squared(world.clamp_m);
    let mut group = criterion.benchmark_group("many lights/bounds");
    group.throughput(Throughput::Elements(packed.nodes.len() as u64));
    for form in [BoundForm::Cheap, BoundForm::Walter] {
        for (node, small) in tree.nodes.iter().zip(&packed.nodes) {
            let exact = dapple_many_lights::bound::point(form, node, receiver, world.clamp_m);
            let ours = f64::from(point(form, small, receiver, clamp));
            assert!((ours - exact).abs() <= 1e-3 * exact + 1e-9, "{ours} for {exact}");
        }
        group.bench_function(format!("{form:?}"), |bencher| {
            bencher.iter(|| {
                let nodes = packed.nodes.iter();
                nodes.map(|node| point(form, node, black_box(receiver), clamp)).sum::<f32>()
            });
        });
    }
    group.finish();
}

fn samplers(criterion: &mut Criterion) {
    let world = world(4000);
    let build = LightTree::build(&world.lights, Build::SurfaceArea, Representative::Weighted);
    let bvh = Arc::new(build.expect("lights are sound"));
    let tree = original(&world);
    let draws = Technique::LightBvh(LightBvh { samples: 16 });
    let name = || BenchmarkId::from_parameter("light BVH, a sample");
    technique(criterion, "samplers", name(), (&draws, &world, &bvh), 0.98, |w| w.samples);
    for (real_time, name) in [(false, "offline"), (true, "real-time")] {
        let draws = Technique::StochasticLightcuts(StochasticLightcuts { cut: 16, real_time });
        let name = BenchmarkId::new("stochastic lightcuts, a sample", name);
        technique(criterion, "samplers", name, (&draws, &world, &tree), 0.98, |w| w.samples);
    }
    for (temporal, neighbours, name) in [(false, 0, "candidates"), (true, 5, "reuse")] {
        let settings = Reservoirs {
            candidates: 32,
            temporal,
            history: 20,
            neighbours,
            radius_px: 30.0,
            unbiased: true,
        };
        let resampling = Technique::Reservoirs(settings);
        let name = BenchmarkId::new("reservoirs, a pixel", name);
        let given = (&resampling, &world, &tree);
        technique(criterion, "samplers", name, given, 0.9, |work| work.pixels);
    }
}

fn lists(criterion: &mut Criterion) {
    let world = world(4000);
    let median = Arc::new(LightTree::median(&world.lights).expect("lights are sound"));
    let clustered = Clustered { cutoff: 1e-3, tile: 32, slices: 24, window: true };
    let name = BenchmarkId::from_parameter("clustered, a light evaluated");
    let given = (&Technique::Clustered(clustered), &world, &median);
    technique(criterion, "lists", name, given, 0.99, |work| work.lights);
    let name = BenchmarkId::from_parameter("capped, a light evaluated");
    let given = (&Technique::Capped(Capped { most: 256 }), &world, &median);
    technique(criterion, "lists", name, given, 0.99, |work| work.lights);

    // Cells of the frame and their lists alone, by entry.
    let frame = &world.frames[0];
    let grid = Grid::of(frame, &clustered).expect("few cells");
    let hierarchy = Hierarchy::new(&world.lights, clustered.cutoff);
    let build = |list: &mut Vec<u32>| {
        let occupied = cells(&grid, frame).into_iter().filter(|cell| !cell.is_empty());
        occupied.fold(0, |entries, cell| {
            list.clear();
            hierarchy.list(&cell, list);
            entries + list.len() as u64
        })
    };
    let mut list = Vec::new();
    let entries = build(&mut list);
    let (_, shaded) = light(Form::Reference, &Technique::Clustered(clustered), &world, &median);
    assert_eq!(entries, shaded.work.entries, "lists hold what the reference's hold");
    let mut group = criterion.benchmark_group("many lights/lists");
    group.throughput(Throughput::Elements(entries));
    group.bench_function("clustered, an entry listed", |bencher| {
        bencher.iter(|| build(black_box(&mut list)));
    });
    group.finish();
}

criterion_group!(many_lights, sums, cuts, bounds, samplers, lists);
criterion_main!(many_lights);
