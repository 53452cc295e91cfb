//! Which lights may reach a facade: shadows of single houses and their projections, joined shadows on a
//! plane, whole evaluations by how shadows are joined, rivals, and many at once.
//!
//! What is timed is checked before: shadows hide what they are to hide and nothing else, the fast form
//! gives the reference's verdicts and precuts, and rivals' work was done.
#![allow(missing_docs, reason = "criterion_group! writes an undocumented function")]
#![allow(clippy::expect_used, reason = "a bench must not time what is wrong")]

use criterion::{
    BatchSize, BenchmarkGroup, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main,
    measurement::WallTime,
};
use dapple_many_lights::{
    region::{
        Cuboid, Direction, Edge, Fusion, Many, ViewCell,
        fusion::{Horizon, Verdict, reference},
        horizon::{Projection, Umbra, project, reproject, umbra},
        make,
    },
    sample::hash,
};
use dapple_suite::{
    case::Case,
    knob::{self, Knobs},
    problem::{Form, Setting},
    problems::region_light_visibility::{RegionCase, SPEC},
};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::{hint::black_box, sync::Arc, time::Duration};

/// A storey of a facade.
const CELL: Cuboid = Cuboid { u: [-6.0, 6.0], w: [-1.0, 0.0], h: [3.0, 6.0] };

/// Where houses end, and what lies behind them.
const FAR_M: f64 = 26.0;
const NEXT_M: f64 = 42.0;

const FUSIONS: [(&str, Fusion); 3] = [
    ("no-fusion", Fusion::None),
    ("insertion", Fusion::Insertion),
    ("height-ordered", Fusion::HeightOrdered),
];

/// Houses of a long street, of one to seven storeys, one lot in eight empty.
fn street(houses: usize) -> Vec<Cuboid> {
    let lots = (0..).filter(|lot: &u32| !hash(*lot).is_multiple_of(8));
    let house = |lot: u32| {
        let left = 6.0 * f64::from(lot) - 3.0 * houses as f64;
        let top = 3.0 * f64::from(1 + hash(lot ^ 0x5eed) % 7);
        Cuboid { u: [left, left + 6.0], w: [16.0, FAR_M], h: [f64::NEG_INFINITY, top] }
    };
    lots.take(houses).map(house).collect()
}

/// Shadows of those houses that have one on the plane of their far faces.
fn shadows(houses: usize) -> Vec<Umbra> {
    let shadow = |house: &Cuboid| umbra(&CELL, house, FAR_M, Edge::Flat);
    street(houses).iter().filter_map(shadow).collect()
}

/// Facades behind a street, one a storey and lot.
fn windows(lots: usize) -> Vec<Cuboid> {
    let window = |index: usize| {
        let left = 6.0 * (index / 7) as f64 - 3.0 * lots as f64;
        let down = 3.0 * (index % 7) as f64;
        Cuboid { u: [left, left + 6.0], w: [NEXT_M + 1.0; 2], h: [down, down + 3.0] }
    };
    (0..7 * lots).map(window).collect()
}

fn group<'a>(criterion: &'a mut Criterion, name: &str) -> BenchmarkGroup<'a, WallTime> {
    let mut group = criterion.benchmark_group(format!("regions/{name}"));
    group.sample_size(10).warm_up_time(Duration::from_millis(200));
    group.measurement_time(Duration::from_millis(700));
    group
}

/// Single shadows: nanoseconds each.
fn shapes(criterion: &mut Criterion) {
    let houses = street(400);
    let mut group = group(criterion, "one");
    group.throughput(Throughput::Elements(houses.len() as u64));
    for (name, edge) in [("flat", Edge::Flat), ("sloped", Edge::Sloped), ("hull", Edge::Hull)] {
        let all: Vec<_> = houses.iter().map(|house| umbra(&CELL, house, FAR_M, edge)).collect();
        for (house, shadow) in houses.iter().zip(&all) {
            let Some(shadow) = shadow else { continue };
            // No higher than where the lowest and rearmost point sees the roof's near edge.
            let [rise, way] = [house.h[1] - CELL.h[0], house.w[0] - CELL.w[0]];
            let most = CELL.h[0] + rise / way * (FAR_M - CELL.w[0]);
            assert!(shadow.highest() <= most + 1e-9, "{shadow:?} of {house:?}");
            assert!(shadow.lowest() > shadow.foot, "{shadow:?} of {house:?}");
        }
        let some = all.iter().flatten().count();
        assert!(some > 100, "{name}: {some} shadows");
        group.bench_function(BenchmarkId::new("umbra", name), |bencher| {
            bencher.iter(|| {
                let all = houses.iter().filter_map(|h| umbra(black_box(&CELL), h, FAR_M, edge));
                all.map(|shadow| shadow.u[0]).sum::<f64>()
            });
        });
        let shadows: Vec<Umbra> = all.into_iter().flatten().collect();
        group.throughput(Throughput::Elements(shadows.len() as u64));
        group.bench_function(BenchmarkId::new("reproject", name), |bencher| {
            bencher.iter(|| {
                let all = shadows
                    .iter()
                    .filter_map(|shadow| reproject(black_box(&CELL), shadow, FAR_M, NEXT_M));
                all.map(|shadow| shadow.u[0]).sum::<f64>()
            });
        });
        group.throughput(Throughput::Elements(houses.len() as u64));
    }
    let windows = windows(60);
    group.throughput(Throughput::Elements(windows.len() as u64));
    for window in &windows {
        let p = project(&CELL, window, FAR_M);
        assert!(p.u[0] <= p.u[1] && p.u[0].is_finite() && p.h[0] <= p.h[1], "{window:?}: {p:?}");
    }
    group.bench_function("project", |bencher| {
        bencher.iter(|| {
            let all = windows.iter().map(|window| project(black_box(&CELL), window, FAR_M));
            all.map(|p| p.u[0]).sum::<f64>()
        });
    });
    group.finish();
}

/// Verdicts of the fast form are the reference's; how many projections are hidden.
fn verdicts(fusion: Fusion, shadows: &[Umbra], projections: &[Projection]) -> usize {
    let (mut fast, mut clear) = (Horizon::new(fusion), reference::Horizon::new(fusion));
    fast.add(shadows);
    clear.add(shadows);
    fast.reproject(&CELL, FAR_M, NEXT_M);
    clear.reproject(&CELL, FAR_M, NEXT_M);
    let verdict = |p: &Projection| {
        let verdict = fast.test(p, &mut 0);
        assert_eq!(verdict, clear.test(p, &mut 0), "{fusion:?}: {p:?}");
        verdict
    };
    projections.iter().filter(|p| verdict(p) == Verdict::Hidden).count()
}

/// All shadows on a plane: made, moved, and asked.
fn horizons(criterion: &mut Criterion) {
    for houses in [40, 400, 4000] {
        let shadows = shadows(houses);
        let windows = windows(houses);
        let on = |plane: f64| windows.iter().map(move |window| project(&CELL, window, plane));
        let projections: Vec<Projection> = on(NEXT_M).collect();
        for (name, fusion) in FUSIONS {
            // The clear form looks at every shadow: fewer questions where there are many.
            let step = if houses > 400 { 997 } else { 7 };
            let some: Vec<Projection> = projections.iter().step_by(step).copied().collect();
            let hidden = verdicts(fusion, &shadows, &some);
            assert!(houses > 400 || hidden > 0, "{name}, {houses} houses: nothing is hidden");
            let mut empty = Horizon::new(fusion);
            empty.add(&shadows);
            let full = empty.clone();
            empty.clear();
            let mut group = group(criterion, "horizon");
            group.throughput(Throughput::Elements(shadows.len() as u64));
            group.bench_function(BenchmarkId::new(format!("{name}/add"), houses), |bencher| {
                bencher.iter(|| {
                    empty.clear();
                    empty.add(black_box(&shadows));
                });
            });
            group.bench_function(
                BenchmarkId::new(format!("{name}/reproject"), houses),
                |bencher| {
                    bencher.iter_batched_ref(
                        || full.clone(),
                        |horizon| horizon.reproject(&CELL, FAR_M, NEXT_M),
                        BatchSize::SmallInput,
                    );
                },
            );
            let mut moved = full;
            moved.reproject(&CELL, FAR_M, NEXT_M);
            group.throughput(Throughput::Elements(projections.len() as u64));
            group.bench_function(BenchmarkId::new(format!("{name}/test"), houses), |bencher| {
                bencher.iter(|| {
                    let mut compared = 0;
                    let hidden = projections
                        .iter()
                        .filter(|p| moved.test(black_box(p), &mut compared) == Verdict::Hidden);
                    (hidden.count(), compared)
                });
            });
            group.finish();
        }
    }
}

/// Faces of the city's street; a few lights of one face are looked for, nothing is judged.
fn city() -> RegionCase {
    let small = [("width", 64), ("truth_faces", 1), ("truth_lights", 1), ("truth_points", 8)];
    let small: Knobs = small.into_iter().map(|(name, value)| (name.into(), value.into())).collect();
    let case = Case {
        problem: SPEC.id.into(),
        scene: "city".into(),
        view: "street".into(),
        seed: 0,
        parameters: knob::complete("parameter", SPEC.parameters, &small).expect("in range"),
    };
    RegionCase::prepare(&case).expect("a generated city")
}

/// Of a technique with one variant, the variant's name is left out.
fn setting(form: Form, technique: &str, variant: &str, given: Knobs) -> Setting {
    let technique = SPEC.technique(technique).expect("a technique of the problem");
    Setting {
        technique: technique.id.into(),
        variant: if variant.is_empty() { technique.variants[0].id } else { variant }.into(),
        form,
        knobs: knob::complete("knob", technique.knobs, &given).expect("in range"),
    }
}

type Asked<'a> = [(&'a ViewCell, Direction)];

/// So many threads, and what answers on them.
struct Threads {
    pool: ThreadPool,
    many: Many,
}

impl Threads {
    fn new(count: usize, case: &RegionCase, setting: &Setting) -> Self {
        let technique = case.technique(setting).expect("settings are sound");
        let occluders = case.occluders(setting).expect("settings are sound");
        let town = Arc::clone(&case.night().town);
        let reference = setting.form == Form::Reference;
        let pool = ThreadPoolBuilder::new().num_threads(count).build().expect("threads");
        let made = || make(&technique, reference, town.world(true), &town.lights, &occluders);
        let many = pool.install(|| Many::new(made)).expect("settings are sound");
        Self { pool, many }
    }

    fn all(&mut self, asked: &Asked<'_>, precuts: &mut Vec<Vec<u32>>) {
        let Self { pool, many } = self;
        pool.install(|| many.all(asked, precuts));
    }
}

/// Precuts by one technique, checked: there are some, and its steps add up.
fn evaluated(
    threads: usize,
    case: &RegionCase,
    setting: &Setting,
    asked: &Asked<'_>,
) -> (Threads, Vec<Vec<u32>>) {
    let mut made = Threads::new(threads, case, setting);
    let mut precuts = Vec::new();
    made.all(asked, &mut precuts);
    let steps = made.many.steps();
    assert!(steps.is_consistent() && steps.output > 0, "{steps:?}");
    assert_eq!(steps.evaluations, asked.len() as u64);
    (made, precuts)
}

/// Whole evaluations at the city: microseconds each.
fn evaluations(criterion: &mut Criterion) {
    let case = city();
    let asked: Vec<_> = case.frames()[0].iter().map(|question| question.asked()).collect();
    let mut group = group(criterion, "evaluation");
    for (name, _) in FUSIONS {
        let few = &asked[..asked.len().min(8)];
        let [fast, clear] = [Form::Cpu, Form::Reference].map(|form| {
            let setting = setting(form, "facade-cluster", name, Knobs::new());
            evaluated(2, &case, &setting, few).1
        });
        assert_eq!(fast, clear, "{name}: precuts are the reference's");
        let setting = setting(Form::Cpu, "facade-cluster", name, Knobs::new());
        bench(&mut group, name, 1, &case, &setting, &asked);
    }
    let setting_of = |name: &str, knob: &str, value: i64| {
        setting(Form::Cpu, name, "", Knobs::from([(knob.into(), value.into())]))
    };
    let few = &asked[..asked.len().min(4)];
    for texels in [64, 256] {
        let raster = setting_of("extended-projection", "texels", texels);
        bench(&mut group, &format!("raster of {texels}"), 1, &case, &raster, few);
    }
    let rays = setting_of("sampled", "rays", 16);
    bench(&mut group, "16 rays a light", 1, &case, &rays, few);
    let many = setting(Form::Cpu, "facade-cluster", "height-ordered", Knobs::new());
    let alone = evaluated(1, &case, &many, &asked).1;
    assert_eq!(alone, evaluated(2, &case, &many, &asked).1, "threads change nothing");
    bench(&mut group, "two threads", 2, &case, &many, &asked);
    group.finish();
}

fn bench(
    group: &mut BenchmarkGroup<'_, WallTime>,
    name: &str,
    threads: usize,
    case: &RegionCase,
    setting: &Setting,
    asked: &Asked<'_>,
) {
    let (mut made, mut precuts) = evaluated(threads, case, setting, asked);
    group.throughput(Throughput::Elements(asked.len() as u64));
    group.bench_function(name, |bencher| {
        bencher.iter(|| made.all(black_box(asked), &mut precuts));
    });
}

criterion_group!(regions, shapes, horizons, evaluations);
criterion_main!(regions);
