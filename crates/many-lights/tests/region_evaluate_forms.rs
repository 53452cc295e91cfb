//! The fast evaluation beside the clear one, on one thread and on several.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod region_evaluate_support;

use dapple_many_lights::region::{
    Direction, FacadeCluster, Many, OccluderMode, Precuts, RegionTechnique, Steps, Turn, ViewCell,
    make,
};
use proptest::prelude::*;
use region_evaluate_support::{Case, cell, precut, random, settings};
use std::sync::Arc;

/// Work less what depends on how shadows are kept.
fn kept_alike(steps: &Steps) -> Steps {
    Steps { compared: 0, ..*steps }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn both_forms_agree_on_precuts_and_work(
        seed in any::<u32>(),
        degrees in prop_oneof![3 => Just(0_u32), 1 => 0_u32..90],
        scale in prop_oneof![6 => Just(1.0), 1 => Just(1e-4), 1 => Just(1e4)],
        settings in settings(),
    ) {
        let case = random(seed, scale, Turn::degrees(degrees));
        let mut fast = case.evaluator(settings);
        let (world, technique) = (Arc::new(case.world.clone()), RegionTechnique::FacadeCluster(settings));
        let mut clear = make(&technique, true, &world, &case.tree, &case.occluders).unwrap();
        for direction in Direction::ALL {
            let nodes = precut(&mut fast, &case.cell, direction);
            prop_assert_eq!(nodes, precut(clear.as_mut(), &case.cell, direction));
            prop_assert_eq!(kept_alike(fast.steps()), kept_alike(clear.steps()));
        }
    }
}

/// Row 30.
#[test]
fn kept_projections_cull_the_same_with_fewer_projections() {
    let (mut first, mut kept) = (Steps::default(), Steps::default());
    for seed in 0..200 {
        let case = random(seed, 1.0, Turn::degrees(seed % 2 * 20));
        let settings = FacadeCluster { threshold: 0.0, ..FacadeCluster::default() };
        let mut anew = case.evaluator(settings);
        let mut cached = case.evaluator(FacadeCluster { cached: true, ..settings });
        for direction in Direction::ALL {
            let nodes = precut(&mut anew, &case.cell, direction);
            assert_eq!(nodes, precut(&mut cached, &case.cell, direction));
        }
        first += *anew.steps();
        kept += *cached.steps();
    }
    let without = |steps: &Steps| Steps { early_projected: 0, last_projected: 0, ..*steps };
    assert_eq!(without(&first), without(&kept));
    let projections = |steps: &Steps| steps.early_projected + steps.last_projected;
    let (first, kept) = (projections(&first), projections(&kept));
    assert!(kept * 10 < first * 9, "{kept} of {first}");
}

/// The first random world of many lights and boxes.
fn rich() -> Case {
    let is_rich = |case: &Case| {
        let turned = case.occluders.turned(Turn::NONE, OccluderMode::Leaf);
        case.world.lights.len() > 50 && turned.solids.len() > 30
    };
    (0..1000).map(|seed| random(seed, 1.0, Turn::NONE)).find(is_rich).unwrap()
}

/// Cells of several sizes and turns all over a world.
fn cells() -> Vec<ViewCell> {
    let at = |i: u32| {
        let min = glam::dvec3(f64::from(i % 9) * 4.0 - 18.0, f64::from(i % 4), f64::from(i) - 20.0);
        cell(Turn::degrees(i % 3 * 25), min, min + f64::from(i % 5))
    };
    (0..40).map(at).collect()
}

#[test]
fn any_number_of_threads_finds_the_same() {
    let Case { world, tree, occluders, .. } = &rich();
    let world = Arc::new(world.clone());
    let cells = cells();
    let questions: Vec<(&ViewCell, Direction)> =
        cells.iter().flat_map(|cell| Direction::ALL.map(|direction| (cell, direction))).collect();
    let technique = RegionTechnique::FacadeCluster(FacadeCluster::default());
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut many = Many::new(|| make(&technique, false, &world, tree, occluders)).unwrap();
            assert_eq!(many.threads(), threads);
            let mut precuts = vec![vec![9; 4]; 500];
            many.all(&questions, &mut precuts);
            many.all(&questions, &mut precuts);
            (precuts, many.steps())
        })
    };
    let one = with(1);
    assert_eq!(one.0.len(), questions.len());
    assert!(one.0.iter().any(|nodes| nodes.len() > 3), "there is something to compare");
    assert_eq!(one.1.evaluations, 2 * questions.len() as u64);
    for threads in [2, 3, 7] {
        assert_eq!(with(threads), one, "{threads} threads");
    }
}

#[test]
fn settings_and_trees_that_mean_nothing_are_refused() {
    let Case { world, tree, occluders, .. } = random(7, 1.0, Turn::NONE);
    let mut world = Arc::new(world);
    let ask = |technique: RegionTechnique, world: &Arc<_>| {
        make(&technique, false, world, &tree, &occluders).map(|_| ()).map_err(|e| e.to_string())
    };
    let weak = FacadeCluster { threshold: f64::NAN, ..FacadeCluster::default() };
    let refused = ask(RegionTechnique::FacadeCluster(weak), &world);
    assert!(refused.is_err_and(|e| e.contains("threshold")));
    assert_eq!(ask(RegionTechnique::Everything, &world), Ok(()));
    Arc::make_mut(&mut world).lights.pop();
    let refused = ask(RegionTechnique::Everything, &world);
    assert!(refused.is_err_and(|e| e.contains("light tree")));
}

#[test]
fn all_lights_are_the_roots_wherever_there_is_a_face() {
    let Case { world, tree, occluders, mut cell } = random(7, 1.0, Turn::NONE);
    cell.faces[0] = None;
    let world = Arc::new(world);
    let mut all = make(&RegionTechnique::Everything, false, &world, &tree, &occluders).unwrap();
    assert!(precut(all.as_mut(), &cell, Direction::PlusX).is_empty());
    assert_eq!(precut(all.as_mut(), &cell, Direction::MinusZ), tree.roots);
    assert_eq!(all.steps().evaluations, 1);
}
