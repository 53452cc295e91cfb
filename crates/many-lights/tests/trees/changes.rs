//! Trees that follow a light, and trees beside a tree.

use crate::{
    shapes::depth,
    support::{REPRESENTATIVES, WEIGHTED, any_keys, any_lights, builds, cloud, omni, windows},
};
use dapple_many_lights::{
    Emission, Light, LightTree,
    tree::{Build, Representative},
};
use glam::DVec3;
use proptest::prelude::*;

fn near(a: f64, b: f64, scale: f64) -> bool {
    (a - b).abs() <= 1e-9 * scale
}

/// What a tree has to be after a light moved, whatever its shape: as if fitted anew, axes, cones and
/// lights that stand for others aside.
fn agrees(moved: &LightTree, lights: &[Light], shape: &LightTree) {
    moved.check(lights).unwrap();
    for (node, before) in moved.nodes.iter().zip(&shape.nodes) {
        assert_eq!((node.size, node.kind), (before.size, before.kind));
    }
}

proptest! {
    #[test]
    fn a_tree_that_followed_a_light_holds_all(
        (lights, keys, others, which) in any_lights(40).prop_flat_map(|lights| {
            let n = lights.len();
            (Just(lights), any_keys(n), any_lights(8), any::<prop::sample::Index>())
        })
    ) {
        prop_assume!(!lights.is_empty());
        for build in builds(&keys) {
            for representative in REPRESENTATIVES {
                let mut now = lights.clone();
                let mut tree = LightTree::build(&now, build, representative).unwrap();
                let mut packed = tree.pack();
                let shape = tree.clone();
                for (step, other) in others.iter().enumerate() {
                    let index = (which.index(now.len()) + 7 * step) % now.len();
                    let emission = now[index].emission;
                    now[index] = Light { emission, ..*other };
                    let visits = tree.moved(&now, index as u32, representative).unwrap();
                    packed.moved(&tree, index as u32);
                    prop_assert!(visits > 0);
                    agrees(&tree, &now, &shape);
                }
                prop_assert_eq!(packed.nodes, tree.pack().nodes);
            }
        }
    }
}

#[test]
fn a_moved_light_leaves_what_a_tree_fitted_anew_says() {
    let mut lights = windows(20, 6);
    let keys: Vec<Vec<u32>> = (0..lights.len() as u32).map(|i| vec![i % 2, i / 12]).collect();
    let mut tree = LightTree::by_keys(&lights, &keys).unwrap();
    for (index, shift) in [(0, 5.0), (100, -700.0), (239, 0.1), (0, -5.0)] {
        lights[index].position.x += shift;
        tree.moved(&lights, index as u32, WEIGHTED).unwrap();
    }
    let fitted = LightTree::by_keys(&lights, &keys).unwrap();
    for (moved, fitted) in tree.nodes.iter().zip(&fitted.nodes) {
        assert_eq!((moved.min, moved.max), (fitted.min, fitted.max));
        assert!(moved.position.distance(fitted.position) < 1e-9);
        assert!(moved.intensity.distance(fitted.intensity) < 1e-9);
        // Only positions changed.
        assert_eq!((moved.axis, moved.cone_rad), (fitted.axis, fitted.cone_rad));
    }
    // A brighter light changes all sums above it.
    lights[17].intensity *= 50.0;
    tree.moved(&lights, 17, WEIGHTED).unwrap();
    let fitted = LightTree::by_keys(&lights, &keys).unwrap();
    for (moved, fitted) in tree.nodes.iter().zip(&fitted.nodes) {
        assert!(near(moved.intensity.x, fitted.intensity.x, 300.0));
        assert!(moved.position.distance(fitted.position) < 1e-9);
    }
}

#[test]
fn visits_follow_the_depth_and_not_the_number_of_lights() {
    let mut worst = Vec::new();
    for count in [1 << 8, 1 << 12, 1 << 16] {
        let mut lights = cloud(count, 1);
        let mut tree = LightTree::median(&lights).unwrap();
        let mut most = 0;
        for index in (0..count).step_by(count / 64) {
            lights[index].position += DVec3::ONE;
            most = most.max(tree.moved(&lights, index as u32, WEIGHTED).unwrap());
        }
        // Down, the root and children; up, children again.
        assert!(most <= 1 + 4 * depth(&tree), "{count}: {most}");
        worst.push(most);
    }
    // 256 times the lights are 8 levels more.
    assert!(worst[2] - worst[0] <= 4 * 8, "{worst:?}");
}

#[test]
fn what_cannot_be_followed_leaves_the_tree_as_it_was() {
    let lights = cloud(9, 1);
    let tree = LightTree::median(&lights).unwrap();
    let refuse = |lights: &[Light], index: u32, message: &str| {
        let mut moved = tree.clone();
        let error = moved.moved(lights, index, WEIGHTED).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
        assert_eq!(moved.nodes, tree.nodes);
    };
    refuse(&lights[..8], 0, "has 9 leaves for 8 lights");
    refuse(&lights, 9, "light 9: there are 9");
    let with = |light: Light| [&[light], &lights[1..]].concat();
    refuse(&with(omni(DVec3::ZERO, 1.0)), 0, "light 0: became of another kind");
    refuse(&with(Light { position: DVec3::NAN, ..lights[0] }), 0, "light 0: position");
}

#[test]
fn a_second_tree_lies_beside_the_first() {
    let fixed = windows(30, 5);
    let keys: Vec<Vec<u32>> = (0..fixed.len() as u32).map(|i| vec![i / 10]).collect();
    let mut tree = LightTree::by_keys(&fixed, &keys).unwrap();
    let mut packed = tree.pack();
    let extent = tree.extent();
    for frame in 0..4_u32 {
        // Another number of lights each time, of two kinds, and none in the end.
        let mut moving = cloud(3 * (3 - frame) as usize, u64::from(frame) + 1);
        moving.extend((frame < 3).then(|| omni(DVec3::splat(f64::from(frame)), 1.0)));
        let second = LightTree::build(&moving, Build::Median, Representative::Nearest).unwrap();
        tree.replace_after(extent, &second);
        packed.replace_after(extent, &second.pack());
        let all = [fixed.clone(), moving.clone()].concat();
        tree.check(&all).unwrap();
        assert_eq!(tree.roots.len(), 1 + second.roots.len());
        let total: DVec3 = tree.roots.iter().map(|&r| tree.nodes[r as usize].intensity).sum();
        let sum: DVec3 = all.iter().map(|l| l.intensity).sum();
        assert!(total.distance(sum) < 1e-9);
        assert_eq!(packed.nodes, tree.pack().nodes);
        assert_eq!(packed.roots, tree.roots);
        if let Some(omni) = all.iter().position(|l| l.emission == Emission::Omni) {
            assert_eq!(tree.nodes[tree.leaves[omni] as usize].light as usize, omni);
        }
    }
    assert_eq!(tree.nodes, LightTree::by_keys(&fixed, &keys).unwrap().nodes);
}
