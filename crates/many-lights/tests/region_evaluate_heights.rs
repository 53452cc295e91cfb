//! Heights below which nodes of a list are hidden: no light that is seen from below them.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod region_evaluate_support;

use dapple_many_lights::region::{Direction, FacadeCluster, Turn, ViewCell, union};
use glam::dvec3;
use proptest::prelude::*;
use region_evaluate_support::{Case, facing, omni, precut, random, settings, upright};

/// The part of a cell up to a height; `None` where there is nothing.
fn up_to(cell: &ViewCell, top: f64) -> Option<ViewCell> {
    let mut low = cell.clone();
    for face in low.faces.iter_mut().flatten() {
        face.max.y = face.max.y.min(top);
        face.region.max.y = face.region.max.y.min(top);
        if face.max.y < face.min.y {
            return None;
        }
    }
    Some(low)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn no_light_that_is_seen_from_below_a_height_is_left_out(
        seed in any::<u32>(),
        degrees in prop_oneof![3 => Just(0_u32), 1 => 0_u32..90],
        scale in prop_oneof![6 => Just(1.0), 1 => Just(1e-4), 1 => Just(1e4)],
        heights in 0_u32..5,
        settings in settings(),
    ) {
        // Every light counts, however weak.
        let settings = FacadeCluster { threshold: 0.0, ..settings };
        let Case { world, tree, occluders, cell } = random(seed, scale, Turn::degrees(degrees));
        let mut case = Case { world, tree, occluders, cell };
        let whole = case.cell.clone();
        let mut evaluator = case.evaluator(settings);
        let precuts = Direction::ALL.map(|d| precut(&mut evaluator, &whole, d));
        let lists: Vec<&[u32]> = precuts.iter().map(Vec::as_slice).collect();
        let mut nodes = vec![];
        union(&lists, |node| case.tree.nodes[node as usize].size, &mut nodes);
        let mut below = vec![f32::INFINITY; nodes.len()];
        for direction in Direction::ALL {
            evaluator.heights(&whole, direction, heights, &nodes, &mut below);
        }
        let mut tops = below.clone();
        tops.sort_by(f32::total_cmp);
        tops.dedup();
        for top in tops {
            let Some(low) = up_to(&whole, f64::from(top)) else { continue };
            case.cell = low;
            let kept: Vec<u32> =
                nodes.iter().zip(&below).filter(|(_, b)| top > **b).map(|(n, _)| *n).collect();
            for direction in Direction::ALL {
                let found = case.false_culls(&settings, direction, &kept, (16, seed));
                prop_assert_eq!(&found.found, &vec![], "{:?} up to {}", direction, top);
            }
        }
    }
}

/// A light 10 m behind a wall 4 m high and 10 m away is seen from above the line over its top alone.
#[test]
fn a_light_behind_a_wall_is_hidden_up_to_the_line_over_its_top() {
    let wall = upright(dvec3(-500.0, -1.0, 10.0), dvec3(500.0, 4.0, 10.0));
    let place = facing(Turn::NONE, dvec3(0.0, 0.0, 0.0), dvec3(1.0, 16.0, 0.0), Direction::PlusZ);
    let case = Case::new(vec![omni(dvec3(0.5, 0.5, 20.0))], vec![wall], place);
    let mut evaluator = case.evaluator(FacadeCluster { threshold: 0.0, ..Default::default() });
    let nodes = precut(&mut evaluator, &case.cell, Direction::PlusZ);
    assert_eq!(nodes, [0]);
    let mut height = |heights: u32, start: f32| {
        let mut below = [start];
        evaluator.heights(&case.cell, Direction::PlusZ, heights, &nodes, &mut below);
        evaluator.heights(&case.cell, Direction::MinusZ, heights, &nodes, &mut below);
        below[0]
    };
    // The line meets the face at 7.5 m.
    assert_eq!(height(1, f32::INFINITY), f32::NEG_INFINITY);
    assert_eq!(height(3, f32::INFINITY), 4.0);
    assert_eq!(height(7, f32::INFINITY), 6.0);
    assert_eq!(height(31, f32::INFINITY), 7.0);
    assert_eq!(height(31, 3.5), 3.5, "another direction knew less");
}
