//! The evaluation in its clear form: by hand and against rays.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod region_evaluate_support;

use dapple_many_lights::region::{
    Direction, Edge, FacadeCluster, Fusion, Precuts, Reference, Split, Steps, Turn,
};
use glam::dvec3;
use proptest::prelude::*;
use region_evaluate_support::{
    Case, cell, facing, is_antichain, omni, precut, random, settings, upright,
};

fn config() -> ProptestConfig {
    let cases = std::env::var("PROPTEST_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(300);
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

fn reference(case: &Case, settings: FacadeCluster) -> Reference {
    Reference::new(case.tree.clone(), case.occluders.clone(), case.world.clamp_m, settings)
}

proptest! {
    #![proptest_config(config())]

    /// P1: nothing that is left out is seen.
    #[test]
    fn what_the_clear_form_leaves_out_is_not_seen(seed in any::<u32>(), settings in settings()) {
        let case = random(seed, 1.0, Turn::NONE);
        let mut clear = reference(&case, settings);
        for direction in Direction::ALL {
            let nodes = precut(&mut clear, &case.cell, direction);
            prop_assert!(clear.steps().is_consistent() && is_antichain(&case.tree, &nodes));
            let found = case.false_culls(&settings, direction, &nodes, (8, seed));
            prop_assert!(found.found.is_empty(), "{found:?}");
        }
    }
}

const ALL: FacadeCluster = FacadeCluster {
    fusion: Fusion::None,
    edge: Edge::Flat,
    occluders: dapple_many_lights::region::OccluderMode::Leaf,
    planes: dapple_many_lights::region::Planes::FarFaces,
    least_step_m: 0.0,
    threshold: 0.0,
    split: Split::All,
    cached: false,
};

/// A wall before two of three lights.
fn behind_a_wall() -> Case {
    let lights = vec![
        omni(dvec3(0.0, 1.0, 20.0)),
        omni(dvec3(0.0, 2.0, 21.0)),
        omni(dvec3(0.0, 30.0, 22.0)),
    ];
    let wall = upright(dvec3(-20.0, -1.0, 5.0), dvec3(20.0, 9.0, 6.0));
    let face = facing(Turn::NONE, dvec3(-1.0, 0.0, 0.0), dvec3(1.0, 3.0, 0.0), Direction::PlusZ);
    Case::new(lights, vec![wall], face)
}

/// Counted by hand. Plane at z = 6: the root lies behind it, and nothing is there to test it against.
/// Then the wall is projected, and the root is hidden in part; so is each inner node that holds the
/// light above the wall; both lights behind it are culled.
#[test]
fn steps_are_those_counted_by_hand() {
    let case = behind_a_wall();
    let mut clear = reference(&case, ALL);
    let nodes = precut(&mut clear, &case.cell, Direction::PlusZ);
    assert_eq!(nodes, [case.tree.leaves[2]]);
    let steps = *clear.steps();
    // A binary tree of three leaves: the light above stands alone, or beside one of the others.
    let depth = if case.tree.nodes[case.tree.leaves[2] as usize - 1].size == 2 { 2 } else { 1 };
    let looked = 1 + 2 * depth;
    let expected = Steps {
        evaluations: 1,
        iterations: 2,
        potential: 1 + looked,
        last: looked,
        last_culled: depth,
        last_divided: depth,
        last_output: 1,
        last_projected: looked,
        early: 1,
        reprojections: 1,
        projections: 1,
        projected: 1,
        compared: looked,
        output: 1,
        ..Steps::default()
    };
    assert_eq!(steps, expected);
}

/// What is hidden in part is put out whole where it is not to be divided.
#[test]
fn undivided_clusters_are_put_out_whole() {
    let case = behind_a_wall();
    let mut clear = reference(&case, FacadeCluster { split: Split::Levels(0), ..ALL });
    assert_eq!(precut(&mut clear, &case.cell, Direction::PlusZ), [0]);
    assert_eq!((clear.steps().last_divided, clear.steps().last_culled), (0, 0));
    let mut clear = reference(&case, FacadeCluster { split: Split::Levels(9), ..ALL });
    assert_eq!(precut(&mut clear, &case.cell, Direction::PlusZ), [case.tree.leaves[2]]);
}

/// No lights, no face, no occluders.
#[test]
fn nothing_is_made_of_nothing() {
    let face = cell(Turn::NONE, dvec3(-1.0, 0.0, 0.0), dvec3(1.0, 3.0, 0.0));
    let dark = Case::new(vec![], vec![], face.clone());
    assert!(precut(&mut reference(&dark, ALL), &face, Direction::PlusZ).is_empty());
    let mut blind = face.clone();
    blind.faces = [None; 4];
    let lit = Case::new(vec![omni(dvec3(0.0, 1.0, 20.0))], vec![], blind);
    let mut clear = reference(&lit, ALL);
    assert!(precut(&mut clear, &lit.cell, Direction::PlusZ).is_empty());
    assert_eq!(*clear.steps(), Steps::default());
    assert_eq!(precut(&mut clear, &face, Direction::PlusZ), [0]);
    // Behind the face's rearmost surface.
    assert!(precut(&mut clear, &face, Direction::MinusZ).is_empty());
    assert!(clear.bytes() > 0);
}
