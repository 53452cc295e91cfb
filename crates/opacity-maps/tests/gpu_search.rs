//! The search on the device against the processor's, on the device's own fragments.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]
#![allow(clippy::print_stderr, reason = "tests say what they measured")]

mod gpu_support;

use dapple_gpu::Gpu;
use dapple_gpu::light_space::LightSpaceMesh;
use dapple_opacity_maps::gpu::{OpacityGpuError, SearchRenderer, fragments};
use dapple_opacity_maps::search::{
    Layers, Plan, Precision, Scoring, Search, Shown, SplitTexture, Steps, criteria, with_lambda,
};
use dapple_opacity_maps::{
    Blend, Code, Criterion, Format, Fragments, Layered, Layout, Opaque, Packing, Receiver,
    Settings, Slicing, Split, SplitKind, Storage, Taps, cpu::Maps,
};
use gpu_support::{MODEL, add, bounded, exclusive_gpu, foliage, frame, plain, receivers, sheet};

/// Three parts of a map, and tiles that are cut at its border.
const SIZE: [u32; 2] = [67, 45];

/// Relative error of sums of 32-bit floats over a map (2e-7 seen), and room for a fragment whose
/// layer is a tie.
const FLOATS: f64 = 2e-5;

const CRITERIA: [Criterion; 4] = [
    Criterion::Correlation,
    Criterion::EqualTransmittance,
    Criterion::EqualOpacity,
    Criterion::Sad,
];

/// Runs a whole search and returns what it tried.
fn search(gpu: &Gpu, renderer: &mut SearchRenderer) -> Vec<f32> {
    let mut tried = Vec::new();
    while renderer.is_searching() {
        let mut frame = gpu.frame();
        tried.extend(renderer.record(&mut frame));
        frame.finish().unwrap();
        gpu.check().unwrap();
    }
    tried
}

/// One mesh with its fragments and receivers.
struct Case {
    size: [u32; 2],
    mesh: LightSpaceMesh,
    own: Fragments,
    receivers: Vec<Receiver>,
}

impl Case {
    fn new(gpu: &Gpu) -> Self {
        Self::of(gpu, foliage(3, 200), SIZE)
    }

    fn of(gpu: &Gpu, mesh: LightSpaceMesh, size: [u32; 2]) -> Self {
        let own = fragments(gpu, &mesh, MODEL, size).unwrap();
        Self { size, mesh, own, receivers: receivers(9, 1500) }
    }

    fn renderer(&self, gpu: &Gpu, plan: &Plan) -> Result<SearchRenderer, OpacityGpuError> {
        SearchRenderer::new(gpu, &self.mesh, MODEL, &self.receivers, self.size, plan)
    }

    /// Scores of every step's maps on the processor.
    fn scores(&self, plan: &Plan) -> Vec<f64> {
        let mut search = Search::new(self.size[0], self.size[1], plan.clone()).unwrap();
        let mut scores = Vec::new();
        while search.is_searching() {
            scores.push(search.frame(&self.own).unwrap().trial.unwrap().1);
        }
        scores
    }

    /// Holds scores to the processor's, and what is adopted and drawn to the scores.
    fn check(&self, gpu: &Gpu, plan: &Plan) {
        let mut renderer = self.renderer(gpu, plan).unwrap();
        let tried = search(gpu, &mut renderer);
        let values = plan.steps.values();
        assert_eq!(tried, (0..values).map(|step| plan.steps.lambda(step)).collect::<Vec<_>>());
        let got: Vec<f64> =
            renderer.read_scores(gpu).unwrap().iter().map(|s| f64::from(s[0])).collect();
        let expected = self.scores(plan);
        let scale = expected.iter().fold(0.0f64, |m, s| m.max(s.abs()));
        let apart = |a: &[f64], b: &[f64]| {
            a.iter().zip(b).map(|(a, b)| (a - b).abs() / scale).fold(0.0, f64::max)
        };
        let worst = apart(&got, &expected);
        let control = apart(&got[1..], &expected);
        eprintln!("{worst:.1e} (a step off {control:.1e}) {:?}", plan.scoring);
        assert!(worst <= FLOATS, "{worst}: {plan:?}");
        assert!(control > 5.0 * FLOATS, "the control: {control} {plan:?}");

        let lambda = renderer.read_lambdas(gpu).unwrap();
        assert_eq!(lambda.len(), 1);
        assert_eq!(lambda[0], plan.steps.lambda(best(plan, &got) as u32));
        // The processor's choice, or as good a one.
        let known = best(plan, &expected);
        let chosen = best(plan, &got);
        let tie = (expected[chosen] - expected[known]).abs() <= 2.0 * FLOATS * scale;
        assert!(chosen == known || tie, "{chosen} {known}: {plan:?}");

        // The frame that took the last score already draws with it.
        let drawn = renderer.read(gpu).unwrap();
        let with = |lambda| {
            let settings = with_lambda(&plan.settings, lambda).unwrap();
            frame(gpu, &self.mesh, &self.receivers, self.size, &settings).transmittances
        };
        let differ = |other: &[f32]| drawn.iter().zip(other).filter(|(a, b)| a != b).count();
        // Slabs are searched for as whole sums.
        if !is_slabs(plan) {
            assert_eq!(differ(&with(lambda[0])), 0, "{plan:?}");
        }
        let other = if lambda[0] > 0.5 { lambda[0] - 0.5 } else { lambda[0] + 0.5 };
        assert!(differ(&with(other)) > 0, "the control: {plan:?}");
    }
}

fn is_slabs(plan: &Plan) -> bool {
    matches!(&plan.settings.code, Code::Layered(Layered { packing: Packing::Slabs, .. }))
}

/// Step of the best score; of equal ones the first.
fn best(plan: &Plan, scores: &[f64]) -> usize {
    let mut best = 0;
    for (step, score) in scores.iter().enumerate() {
        if criteria::is_better(plan.scoring.criterion, *score, scores[best]) {
            best = step;
        }
    }
    best
}

#[test]
fn every_criterion_finds_the_split_that_the_processor_finds() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let case = Case::new(gpu);
    for criterion in CRITERIA {
        for layers in [4, 16] {
            case.check(gpu, &Plan::plain(plain(bounded(layers)), criterion));
        }
        let base = Plan::plain(plain(bounded(7)), criterion);
        let scoring = base.scoring;
        for scoring in [
            Scoring { precision: Precision::Bytes, ..scoring },
            Scoring { mask: true, ..scoring },
            Scoring { side: 40, ..scoring },
        ] {
            case.check(gpu, &Plan { scoring, ..base.clone() });
        }
    }
}

#[test]
fn every_storage_packing_and_blend_is_searched() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let case = Case::new(gpu);
    let base = bounded(9);
    let positions = Layout::Bounded {
        split: split(SplitKind::Positions),
        bins: dapple_opacity_maps::Bins::Thesis,
    };
    let maps = [
        Layered { storage: Storage::Atomic, format: Format::Fixed, ..base.clone() },
        Layered { packing: Packing::Single, ..base.clone() },
        Layered { packing: Packing::Slabs, ..base.clone() },
        Layered { packing: Packing::Targets(2), ..base.clone() },
        Layered { blend: Blend::Over, ..base.clone() },
        Layered { layout: positions, ..base.clone() },
    ];
    for layered in maps {
        case.check(gpu, &Plan::plain(plain(layered), Criterion::EqualTransmittance));
    }
    let opaque = Opaque::Weight { weight: 1.5, in_bounds: false };
    let weighed = Settings { opaque, taps: Taps::Box3, ..plain(base) };
    let mut plan = Plan::plain(weighed, Criterion::Correlation);
    plan.steps = Steps::of(0.05).unwrap();
    let mut renderer = case.renderer(gpu, &plan).unwrap();
    assert_eq!(search(gpu, &mut renderer).len(), 21);
    let scores: Vec<f64> =
        renderer.read_scores(gpu).unwrap().iter().map(|s| f64::from(s[0])).collect();
    let lambda = plan.steps.lambda(best(&plan, &scores) as u32);
    assert_eq!(renderer.read_lambdas(gpu).unwrap(), [lambda]);
}

fn split(kind: SplitKind) -> Split {
    Split { lambda: 0.0, kind, width: 512 }
}

#[test]
fn maps_of_many_parts_and_of_many_layers_are_searched() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    // More parts than a workgroup has lanes.
    let wide = Case::of(gpu, foliage(5, 120), [290, 260]);
    for criterion in [Criterion::Correlation, Criterion::EqualTransmittance] {
        wide.check(gpu, &Plan::plain(plain(bounded(4)), criterion));
    }
    let case = Case::of(gpu, foliage(3, 200), [33, 20]);
    case.check(gpu, &Plan::plain(plain(bounded(256)), Criterion::EqualOpacity));
    case.check(gpu, &Plan::plain(plain(bounded(2)), Criterion::EqualTransmittance));
    // One layer has no split to choose, and no neighbour: the first of equal scores wins.
    for (size, criterion) in
        [([33, 20], Criterion::Correlation), ([1, 1], Criterion::EqualTransmittance)]
    {
        let case = Case::of(gpu, foliage(3, 200), size);
        let plan = Plan::plain(plain(bounded(1)), criterion);
        let mut renderer = case.renderer(gpu, &plan).unwrap();
        search(gpu, &mut renderer);
        let scores = renderer.read_scores(gpu).unwrap().concat();
        assert!(scores.iter().all(|s| *s == scores[0]), "{scores:?}");
        assert!((f64::from(scores[0]) - case.scores(&plan)[0]).abs() < 1e-6, "{scores:?}");
        assert_eq!(renderer.read_lambdas(gpu).unwrap(), [0.0]);
    }
}

#[test]
fn each_tile_gets_the_split_that_is_best_there() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let case = Case::new(gpu);
    let layers = 8;
    let settings = plain(bounded(layers));
    let trials: Vec<Maps> = (0..=10)
        .map(|step| {
            let settings = with_lambda(&settings, Steps::THESIS.lambda(step)).unwrap();
            let mut maps = Maps::new(SIZE[0], SIZE[1], &settings).unwrap();
            maps.build(&case.own).unwrap();
            maps
        })
        .collect();
    for (criterion, side) in [
        (Criterion::EqualTransmittance, 1),
        (Criterion::EqualTransmittance, 8),
        (Criterion::EqualTransmittance, 40),
        (Criterion::EqualOpacity, 5),
        (Criterion::Sad, 16),
        (Criterion::Correlation, 16),
    ] {
        let plan = Plan { tile: side, ..Plan::plain(settings.clone(), criterion) };
        let mut renderer = case.renderer(gpu, &plan).unwrap();
        search(gpu, &mut renderer);
        let scores = renderer.read_scores(gpu).unwrap();
        let lambdas = renderer.read_lambdas(gpu).unwrap();
        let texture = SplitTexture::new(SIZE[0], SIZE[1], side, Steps::THESIS).unwrap();
        assert_eq!(lambdas.len(), texture.len());
        assert_eq!(renderer.counters().tiles, texture.len() as u64);
        let (mut ties, mut kinds) = (0, Vec::new());
        for (tile, lambda) in lambdas.iter().enumerate() {
            let expected: Vec<f64> = trials
                .iter()
                .map(|maps| {
                    let words = maps.code().words();
                    let n = layers as usize;
                    let size = (SIZE[0], SIZE[1]);
                    let layers = Layers::new(size, n, words, words - n, maps.words()).unwrap();
                    criteria::score_region(&plan.scoring, &layers, texture.region(tile)).unwrap()
                })
                .collect();
            let got: Vec<f64> = scores.iter().map(|step| f64::from(step[tile])).collect();
            let scale = expected.iter().fold(1e-3f64, |m, s| m.max(s.abs()));
            for (a, b) in got.iter().zip(&expected) {
                // A tile has few texels: a tie between layers weighs more.
                assert!((a - b).abs() <= 1e-3 * scale, "{plan:?} {tile}: {a} {b}");
            }
            assert_eq!(*lambda, Steps::THESIS.lambda(best(&plan, &got) as u32));
            ties += usize::from(best(&plan, &got) != best(&plan, &expected));
            if !kinds.contains(&lambda.to_bits()) {
                kinds.push(lambda.to_bits());
            }
        }
        eprintln!("{} of {} ties, {} splits: {plan:?}", ties, lambdas.len(), kinds.len());
        // A ray's few fragments leave most splits alike; larger tiles tell them apart.
        assert!(side == 1 || 10 * ties <= lambdas.len(), "{ties} of {}", lambdas.len());
        assert!(kinds.len() > 1, "{plan:?}");

        // Receivers read with the split that their texel was written with.
        let mut search = Search::new(SIZE[0], SIZE[1], plan.clone()).unwrap();
        while search.is_searching() {
            search.frame(&case.own).unwrap();
        }
        let mut expected = vec![0.0; case.receivers.len()];
        search.maps().shade(&case.receivers, &mut expected).unwrap();
        let got = renderer.read(gpu).unwrap();
        let known = search.texture();
        let (mut compared, mut beyond) = (0, 0);
        for ((receiver, a), b) in case.receivers.iter().zip(&got).zip(&expected) {
            if !receiver.in_map() {
                continue;
            }
            let place = |x: f32, n: u32| ((x * n as f32) as u32).min(n - 1);
            let (x, y) = (place(receiver.u, SIZE[0]), place(receiver.v, SIZE[1]));
            let tile = y / side.min(SIZE[0]) * SIZE[0].div_ceil(side) + x / side;
            if lambdas[tile as usize] == known.lambda((y * SIZE[0] + x) as usize) {
                compared += 1;
                beyond += usize::from((a - b).abs() > 1e-4);
            }
        }
        assert!(compared > 500 && 100 * beyond <= compared, "{beyond} of {compared}: {plan:?}");
    }
}

#[test]
fn a_search_takes_eleven_frames_and_rests_until_something_changes() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let case = Case::new(gpu);
    let plan = Plan::plain(plain(bounded(6)), Criterion::EqualTransmittance);
    let mut renderer = case.renderer(gpu, &plan).unwrap();
    let step = |renderer: &mut SearchRenderer| {
        let mut frame = gpu.frame();
        let tried = renderer.record(&mut frame);
        let times = frame.finish().unwrap();
        gpu.check().unwrap();
        let passes: Vec<_> = times.passes.iter().map(|p| p.0).collect();
        let of_search = passes.iter().filter(|name| name.starts_with("search-")).count();
        let opacity = passes.iter().filter(|name| **name == "search-opacity").count() as u64;
        if !passes.is_empty() {
            assert_eq!(of_search > 0, tried.is_some(), "{passes:?}");
            // One further set of opacity passes at most.
            assert!(opacity <= renderer.counters().trial_passes, "{passes:?}");
        }
        (tried, renderer.read_lambdas(gpu).unwrap()[0])
    };
    let mut before = 0.0;
    for cycle in 0..2 {
        for i in 0..10 {
            let (tried, drawn) = step(&mut renderer);
            assert_eq!(tried, Some(plan.steps.lambda(i)));
            assert_eq!(drawn, before, "cycle {cycle}, frame {i}");
        }
        let (tried, adopted) = step(&mut renderer);
        assert_eq!(tried, Some(1.0));
        assert!(!renderer.is_searching());
        assert!(adopted > 0.0 && (cycle == 0 || adopted == before), "{adopted}");
        before = adopted;
        for _ in 0..3 {
            assert_eq!(step(&mut renderer), (None, adopted));
        }
        // Half a search is forgotten.
        renderer.needs_recompute();
        assert_eq!(step(&mut renderer).0, Some(0.0));
        assert_eq!(step(&mut renderer).0, Some(0.1));
        renderer.needs_recompute();
    }
    let counters = renderer.counters();
    assert_eq!((counters.trial_passes, counters.settled.geometry_passes), (1, 2));
    // What this test read, one a frame.
    assert_eq!(renderer.read_backs(), 2 * (11 + 3 + 2));
    assert_eq!(counters.scored_bytes, 4 * 6 * u64::from(SIZE[0] * SIZE[1]));

    let mut ever = case.renderer(gpu, &Plan { repeat: true, ..plan }).unwrap();
    let tried: Vec<_> = (0..23).map(|_| step(&mut ever).0.unwrap()).collect();
    assert_eq!((tried[10], tried[11], tried[22]), (1.0, 0.0, 0.0));
}

#[test]
fn maps_without_differences_correlate_wholly() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let mut mesh = LightSpaceMesh::default();
    for z in [0.2, 0.23, 0.31, 0.6, 0.75] {
        add(&mut mesh, sheet([-0.1, 1.1], [-0.1, 1.1], z), 0.37, None);
    }
    let even = Case::of(gpu, mesh.clone(), SIZE);
    let plan = Plan::plain(plain(bounded(5)), Criterion::Correlation);
    let scores = |case: &Case| {
        let mut renderer = case.renderer(gpu, &plan).unwrap();
        search(gpu, &mut renderer);
        let lambda = renderer.read_lambdas(gpu).unwrap()[0];
        (renderer.read_scores(gpu).unwrap().concat(), lambda)
    };
    // Equal scores: the first wins.
    assert_eq!(scores(&even), (vec![4.0; 11], 0.0));
    // A fault in one texel is not lost beside means that are far larger.
    add(&mut mesh, sheet([0.4, 0.45], [0.4, 0.45], 0.7), 0.004, None);
    let odd = Case::of(gpu, mesh, SIZE);
    let got = scores(&odd).0;
    for (a, b) in got.iter().zip(odd.scores(&plan)) {
        assert!((f64::from(*a) - b).abs() < 1e-3 && b < 3.9, "{a} {b}");
    }
    // Nothing at all.
    let empty = Case::of(gpu, LightSpaceMesh::default(), SIZE);
    assert_eq!(scores(&empty), (vec![4.0; 11], 0.0));
}

#[test]
fn what_the_device_does_not_search_is_refused_by_name() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let case = Case::new(gpu);
    let base = Plan::plain(plain(bounded(4)), Criterion::EqualTransmittance);
    let with = |layered| Plan { settings: plain(layered), ..base.clone() };
    let bins = dapple_opacity_maps::Bins::Full;
    let table = Layout::Bounded { split: split(SplitKind::Table8), bins };
    for (plan, expected) in [
        (Plan::plain(plain(bounded(4)), Criterion::MutualInformation), "mutual information"),
        (Plan::plain(plain(bounded(4)), Criterion::Oracle), "oracle"),
        (Plan { shown: Shown::Trial, ..base.clone() }, "trial maps"),
        (Plan { tile: 1, ..Plan::plain(plain(bounded(4)), Criterion::Correlation) }, "tile"),
        (with(Layered { layout: table, ..bounded(4) }), "lookup textures"),
        (with(Layered { layout: Layout::Planes(Slicing::Uniform), ..bounded(4) }), "bounding"),
        (with(bounded(0)), "layers"),
        (Plan { settings: Settings::plain(Code::Unshadowed), ..base.clone() }, "layered"),
    ] {
        let error = case.renderer(gpu, &plan).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    let none = SearchRenderer::new(gpu, &case.mesh, MODEL, &[], [0, 5], &base);
    assert!(none.is_err());
    assert!(case.renderer(gpu, &base).is_ok());
}
