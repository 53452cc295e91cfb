//! Worlds whose answer is known, and extremes.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod region_evaluate_support;

use dapple_many_lights::{
    Emission, Light, LightTree,
    region::{
        Direction, FacadeCluster, Fusion, Occluders, Precuts, Split, Steps, Turn, ViewCell,
        evaluate::Evaluator,
    },
};
use glam::{DVec3, dvec3};
use region_evaluate_support::{
    Case, below, cell, facing, is_antichain, omni, precut, upright, window, world,
};
use std::sync::Arc;

const ALL: FacadeCluster = FacadeCluster {
    fusion: Fusion::HeightOrdered,
    edge: dapple_many_lights::region::Edge::Flat,
    occluders: dapple_many_lights::region::OccluderMode::Leaf,
    planes: dapple_many_lights::region::Planes::FarFaces,
    least_step_m: 0.0,
    threshold: 0.0,
    split: Split::All,
    cached: false,
};

/// A grid of lights from z = 5 to z = 24.
fn grid() -> Vec<Light> {
    let at = |i: u32| dvec3(f64::from(i % 10), f64::from(i / 10 % 5), 5.0 + f64::from(i / 50));
    (0..1000).map(|i| omni(at(i))).collect()
}

/// Five metres wide, at z = 0.
fn wall(turn: Turn) -> ViewCell {
    facing(turn, dvec3(2.0, 0.0, 0.0), dvec3(7.0, 3.0, 0.0), Direction::PlusZ)
}

#[test]
fn nothing_is_culled_where_nothing_occludes() {
    let case = Case::new(grid(), vec![], wall(Turn::NONE));
    for degrees in [0, 17] {
        let mut evaluator = case.evaluator(ALL);
        let nodes = precut(&mut evaluator, &wall(Turn::degrees(degrees)), Direction::PlusZ);
        assert_eq!(nodes, [0], "{degrees} degrees");
        let one = Steps {
            evaluations: 1,
            iterations: 1,
            potential: 1,
            last: 1,
            last_output: 1,
            output: 1,
            ..Steps::default()
        };
        assert_eq!(*evaluator.steps(), one);
    }
}

#[test]
fn a_direction_without_a_face_has_no_lights() {
    let case = Case::new(grid(), vec![], wall(Turn::NONE));
    let mut evaluator = case.evaluator(ALL);
    assert!(precut(&mut evaluator, &case.cell, Direction::MinusZ).is_empty());
    assert_eq!(*evaluator.steps(), Steps::default());
}

/// P10. The wall is made of parts that touch, and no part hides anything alone.
#[test]
fn a_closed_wall_culls_everything_behind_it() {
    let parts: Vec<_> = (-40..40)
        .map(|i| f64::from(i) * 0.5)
        .map(|x| upright(dvec3(x, -1.0, 14.0), dvec3(x + 0.5, 40.0, 14.5)))
        .collect();
    for fusion in [Fusion::Insertion, Fusion::HeightOrdered] {
        let case = Case::new(grid(), parts.clone(), wall(Turn::NONE));
        let mut evaluator = case.evaluator(FacadeCluster { fusion, ..ALL });
        let nodes = precut(&mut evaluator, &case.cell, Direction::PlusZ);
        let lights: usize = nodes.iter().map(|&n| leaves(&case.tree, n)).sum();
        assert_eq!(lights, 500, "all before it, none behind it: {fusion:?}");
        assert!(nodes.iter().all(|&n| case.tree.nodes[n as usize].max.z < 14.5));
    }
    let case = Case::new(grid(), parts, wall(Turn::NONE));
    let mut evaluator = case.evaluator(FacadeCluster { fusion: Fusion::None, ..ALL });
    let nodes = precut(&mut evaluator, &case.cell, Direction::PlusZ);
    let lights: usize = nodes.iter().map(|&n| leaves(&case.tree, n)).sum();
    assert!(lights > 950, "parts narrower than the cell hide little and not far: {lights}");
}

fn leaves(tree: &LightTree, node: u32) -> usize {
    let end = node + tree.nodes[node as usize].size;
    tree.nodes[node as usize..end as usize].iter().filter(|n| n.is_leaf()).count()
}

#[test]
fn lights_behind_the_rearmost_surface_are_dropped_and_those_beside_it_are_kept() {
    let lights: Vec<Light> =
        [-3.0, -1.0, 0.0, 0.5, 2.0].iter().map(|&z| omni(dvec3(9.0, 1.0, z))).collect();
    let place = cell(Turn::NONE, dvec3(0.0, 0.0, -1.0), dvec3(1.0, 2.0, 1.0));
    // Keys that part every light from the rest.
    let keys: Vec<Vec<u32>> = (0..5).map(|i| vec![i]).collect();
    let tree = Arc::new(LightTree::by_keys(&lights, &keys).unwrap());
    let boxes = vec![upright(dvec3(-9.0, 0.0, 3.0), dvec3(9.0, 9.0, 4.0))];
    let occluders = Arc::new(Occluders::of_boxes(boxes));
    let mut evaluator = Evaluator::new(tree.clone(), occluders, 0.1, ALL);
    let nodes = precut(&mut evaluator, &place, Direction::PlusZ);
    // All end before the first plane: the root is put out whole, for lights behind give nothing.
    assert_eq!(nodes, [0]);
    let near = vec![upright(dvec3(-9.0, 0.0, 1.25), dvec3(9.0, 9.0, 1.5))];
    let occluders = Arc::new(Occluders::of_boxes(near));
    let mut evaluator = Evaluator::new(tree.clone(), occluders, 0.1, ALL);
    let nodes = precut(&mut evaluator, &place, Direction::PlusZ);
    assert_eq!(nodes, [1, 2, 3].map(|light: usize| tree.leaves[light]));
}

#[test]
fn lights_without_a_place_always_stay() {
    let sun = Light {
        position: DVec3::ZERO,
        axis: -DVec3::Y,
        intensity: DVec3::ONE,
        emission: Emission::Directional,
    };
    let mut lights = vec![omni(dvec3(4.0, 1.0, 20.0))];
    lights.extend([sun; 3]);
    let boxes = vec![upright(dvec3(-90.0, -1.0, 5.0), dvec3(90.0, 90.0, 6.0))];
    let case = Case::new(lights, boxes, wall(Turn::NONE));
    let nodes = precut(&mut case.evaluator(ALL), &case.cell, Direction::PlusZ);
    assert_eq!(nodes, [case.tree.roots[1]]);
}

#[test]
fn what_is_too_weak_is_left_out_before_it_is_tested() {
    let behind = window(dvec3(4.0, 1.0, 5.0), DVec3::Z);
    let towards = window(dvec3(5.0, 1.0, 5.0), DVec3::NEG_Z);
    let case = Case::new(vec![behind, towards], vec![], wall(Turn::NONE));
    let keys = [vec![0], vec![1]];
    let tree = Arc::new(LightTree::by_keys(&case.world.lights, &keys).unwrap());
    let make = |threshold| {
        let settings = FacadeCluster { threshold, ..ALL };
        Evaluator::new(tree.clone(), case.occluders.clone(), 0.1, settings)
    };
    let mut evaluator = make(1e3);
    assert!(precut(&mut evaluator, &case.cell, Direction::PlusZ).is_empty());
    assert_eq!((evaluator.steps().potential_culled, evaluator.steps().last), (1, 0));
    let mut evaluator = make(1e-3);
    assert_eq!(precut(&mut evaluator, &case.cell, Direction::PlusZ), [0]);
}

#[test]
fn partly_hidden_clusters_are_divided_as_often_as_asked() {
    let boxes = vec![upright(dvec3(-20.0, -1.0, 3.0), dvec3(6.0, 40.0, 4.0))];
    let case = Case::new(grid(), boxes, wall(Turn::NONE));
    let mut counts = vec![];
    for split in [Split::Levels(0), Split::Levels(1), Split::Levels(3), Split::All] {
        let mut evaluator = case.evaluator(FacadeCluster { split, ..ALL });
        let nodes = precut(&mut evaluator, &case.cell, Direction::PlusZ);
        assert!(is_antichain(&case.tree, &nodes));
        let lights: usize = nodes.iter().map(|&n| leaves(&case.tree, n)).sum();
        counts.push((nodes.len(), lights));
    }
    assert_eq!(counts[0], (1, 1000), "one cluster, hidden in part");
    assert!(counts.windows(2).all(|c| c[0].1 >= c[1].1 && c[0].0 <= c[1].0), "{counts:?}");
    assert!(counts[3].1 < 900, "{counts:?}");
}

/// 0, 1 and 2 lights; lights in one point; a cell that is a point; a cell within an occluder, with
/// lights within it too; 10^4 occluders; 10^4 children of one node.
#[test]
fn extremes_give_what_is_seen() {
    let point = dvec3(1.0, 1.0, 1.0);
    let boxes = [
        vec![],
        vec![upright(dvec3(-2.0, 0.0, -2.0), dvec3(3.0, 3.0, 3.0))],
        vec![upright(point, point)],
        vec![upright(dvec3(0.0, 0.0, 1.0), dvec3(2.0, 2.0, 1.0))],
    ];
    let lights = [
        vec![],
        vec![omni(point)],
        vec![omni(point); 50],
        vec![omni(dvec3(2.0, 1.0, 4.0)), omni(dvec3(2.0, 1.0, -4.0))],
        vec![Light { intensity: DVec3::ZERO, ..omni(dvec3(0.0, 1.0, 9.0)) }],
    ];
    for boxes in &boxes {
        for lights in &lights {
            for max in [point, dvec3(1.0, 1.0, 2.0), dvec3(1.0, 2.0, 1.0), dvec3(9.0, 9.0, 9.0)] {
                let case = Case::new(lights.clone(), boxes.clone(), cell(Turn::NONE, point, max));
                let mut evaluator = case.evaluator(ALL);
                for direction in Direction::ALL {
                    let nodes = precut(&mut evaluator, &case.cell, direction);
                    let found = case.false_culls(&ALL, direction, &nodes, (64, 1));
                    assert_eq!(found.found, [], "{boxes:?} {lights:?} {max}");
                }
            }
        }
    }
}

#[test]
fn ten_thousand_occluders_and_ten_thousand_children_are_looked_at_in_good_time() {
    let mut draws = dapple_many_lights::sample::Random::new(3, 0, 0);
    let boxes: Vec<_> = (0..10_000)
        .map(|i| {
            let corner = dvec3(f64::from(i % 100) * 7.0, -1.0, f64::from(i / 100) * 9.0);
            let size = dvec3(5.0, 4.0 + f64::from(below(&mut draws, 20)), 5.0);
            let shift = dvec3(0.0, 0.0, f64::from(below(&mut draws, 200)) * 0.01);
            upright(corner + shift, corner + shift + size)
        })
        .collect();
    let lights: Vec<Light> = (0..10_000)
        .map(|i| omni(dvec3(f64::from(i % 100) * 7.0 + 6.0, 2.0, f64::from(i / 100) * 9.0 + 8.5)))
        .collect();
    let keys: Vec<Vec<u32>> = (0..10_000).map(|i| vec![i]).collect();
    let tree = Arc::new(LightTree::by_keys(&lights, &keys).unwrap());
    assert_eq!(tree.nodes.len(), 10_001);
    let occluders = Arc::new(Occluders::of_boxes(boxes));
    let place = cell(Turn::NONE, dvec3(300.0, 0.0, 424.0), dvec3(305.0, 3.0, 424.0));
    let settings = FacadeCluster { threshold: 1e-3, ..ALL };
    let mut evaluator = Evaluator::new(tree.clone(), occluders.clone(), 0.1, settings);
    let case = Case { world: world(lights), tree, occluders, cell: place };
    for direction in Direction::ALL {
        let nodes = precut(&mut evaluator, &case.cell, direction);
        assert!(!nodes.is_empty());
        if direction == Direction::PlusX {
            let found = case.false_culls(&settings, direction, &nodes, (2, 5));
            assert_eq!(found.found, []);
        }
    }
    assert!(evaluator.steps().is_consistent());
    assert!(evaluator.bytes() < 10_000_000, "{}", evaluator.bytes());
}
