//! How well trees cluster, and that they are the same on any machine.

use crate::{
    shapes::depth,
    support::{WEIGHTED, builds, cloud, omni, spot, windows},
};
use dapple_many_lights::{
    Light, LightTree,
    tree::{Build, EXACT, Representative},
};
use glam::DVec3;

const GREEDY: Build<'_> = Build::Greedy { spread: 1.0 };
const LOCALLY_ORDERED: Build<'_> = Build::LocallyOrdered { spread: 1.0 };

fn build(lights: &[Light], build: Build<'_>) -> LightTree {
    let tree = LightTree::build(lights, build, WEIGHTED).unwrap();
    tree.check(lights).unwrap();
    tree
}

/// The metric of Walter et al. 2005 over all clusters.
fn cost(tree: &LightTree) -> f64 {
    let root = &tree.nodes[0];
    let c_squared = (root.max - root.min).length_squared();
    let of = |node: &dapple_many_lights::Node| {
        let open = 1.0 - node.cone_rad.cos();
        let diagonal = (node.max - node.min).length_squared();
        node.intensity.element_sum() * (diagonal + c_squared * open * open)
    };
    tree.nodes.iter().filter(|node| !node.is_leaf()).map(of).sum()
}

#[test]
fn what_is_most_alike_is_joined_by_the_original_tree() {
    for lights in [cloud(3000, 1), windows(60, 20)] {
        let [greedy, local, median] =
            [GREEDY, LOCALLY_ORDERED, Build::Median].map(|b| build(&lights, b));
        assert!(cost(&greedy) < 0.9 * cost(&median), "{} {}", cost(&greedy), cost(&median));
        assert!(cost(&local) < 0.9 * cost(&median), "{} {}", cost(&local), cost(&median));
        assert!(cost(&local) < 1.5 * cost(&greedy), "{} {}", cost(&local), cost(&greedy));
        assert_eq!(greedy.nodes.len(), 2 * lights.len() - 1);
        assert_eq!(local.nodes.len(), 2 * lights.len() - 1);
    }
}

#[test]
fn the_weight_of_directions_decides_what_is_alike() {
    // Two directions at each of two places.
    let lights = [
        spot(DVec3::ZERO, DVec3::X),
        spot(DVec3::ZERO, DVec3::Y),
        spot(DVec3::Z, DVec3::X),
        spot(DVec3::Z, DVec3::Y),
    ];
    let first = |spread| {
        let tree = build(&lights, Build::Greedy { spread });
        let below = tree.nodes.iter().filter(|n| n.size == 3).map(|n| n.cone_rad > 0.1);
        below.collect::<Vec<_>>()
    };
    assert_eq!(first(0.0), [true, true], "places alone");
    assert_eq!(first(100.0), [false, false], "directions first");
}

#[test]
fn the_original_tree_is_exact_up_to_a_limit_for_each_kind() {
    let few = cloud(500, 2);
    let original = |lights: &[Light]| LightTree::original(lights, WEIGHTED).unwrap().nodes;
    assert_eq!(original(&few), build(&few, GREEDY).nodes);
    let many: Vec<Light> = (0..=EXACT).map(|i| omni(DVec3::X * (i * i) as f64, 1.0)).collect();
    assert_eq!(original(&many), build(&many, LOCALLY_ORDERED).nodes);
    // Each kind counts for itself.
    let both = [many.clone(), few.clone()].concat();
    let nodes = original(&both);
    assert_eq!(nodes.len(), 2 * both.len() - 2);
    let shape =
        |nodes: &[dapple_many_lights::Node]| nodes.iter().map(|n| n.size).collect::<Vec<_>>();
    assert_eq!(shape(&nodes[2 * many.len() - 1..]), shape(&build(&few, GREEDY).nodes));
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let mut lights = cloud(9000, 4);
    lights.extend(windows(40, 50));
    let keys: Vec<Vec<u32>> = (0..lights.len() as u32).map(|i| vec![i / 900, i / 30]).collect();
    let with = |threads: usize, build: Build<'_>, representative| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| LightTree::build(&lights, build, representative).unwrap().nodes)
    };
    for build in builds(&keys) {
        let representative = Representative::Random { seed: 3 };
        let one = with(1, build, representative);
        for threads in [2, 5] {
            assert!(with(threads, build, representative) == one, "{build:?}, {threads} threads");
        }
    }
}

#[test]
fn equal_lights_make_no_deep_trees() {
    let count = 20_000;
    let same = vec![spot(DVec3::ONE, DVec3::X); count];
    let dark: Vec<Light> = cloud(count, 7)
        .into_iter()
        .map(|light| Light { intensity: DVec3::ZERO, ..light })
        .collect();
    // Each ten times as far as the one before, as far as numbers go.
    let apart: Vec<Light> =
        (0..count).map(|i| omni(DVec3::Y * 10_f64.powi(6 - i as i32 % 300), 1.0)).collect();
    for lights in [same, dark, apart] {
        for (how, limit) in [(LOCALLY_ORDERED, 40), (Build::SurfaceArea, 90), (Build::Median, 15)] {
            let tree = build(&lights, how);
            assert!(depth(&tree) <= limit, "{how:?}: {}", depth(&tree));
        }
    }
}

#[test]
fn directions_turn_a_split_for_sampling() {
    // Two walls of 4 m by 4 m that are 2 m apart.
    let at = |i: usize| DVec3::new((i % 5) as f64, (i / 5 % 5) as f64, (i / 25) as f64 * 2.0);
    let all_sides: Vec<Light> = (0..50).map(|i| omni(at(i), 1.0)).collect();
    let opposite: Vec<Light> =
        (0..50).map(|i| spot(at(i), if i < 25 { -DVec3::Z } else { DVec3::Z })).collect();
    let first_split = |lights: &[Light]| {
        let tree = build(lights, Build::SurfaceArea);
        let child = tree.nodes[1];
        child.max - child.min
    };
    assert_eq!(first_split(&all_sides).z, 2.0, "through both walls");
    assert_eq!(first_split(&opposite), DVec3::new(4.0, 4.0, 0.0), "between the directions");
}

#[test]
fn a_million_lights_are_clustered() {
    let lights = cloud(1_000_000, 1);
    for how in [LOCALLY_ORDERED, Build::Median] {
        let tree = LightTree::build(&lights, how, WEIGHTED).unwrap();
        tree.check(&lights).unwrap();
        assert_eq!(tree.nodes.len(), 1_999_999);
        assert!(depth(&tree) <= 60, "{}", depth(&tree));
    }
}
