//! Shapes of trees over few lights, by hand.

use crate::support::{WEIGHTED, cloud, omni, windows};
use dapple_many_lights::LightTree;
use glam::DVec3;

/// Edges from a root to its deepest leaf.
pub fn depth(tree: &LightTree) -> usize {
    let mut ends: Vec<usize> = Vec::new();
    let mut deepest = 0;
    for (index, node) in tree.nodes.iter().enumerate() {
        ends.retain(|&end| end > index);
        deepest = deepest.max(ends.len());
        ends.push(index + node.size as usize);
    }
    deepest
}

#[test]
fn no_light_is_no_tree_and_one_is_a_leaf() {
    let keys = vec![vec![1, 2, 3]];
    let none = LightTree::median(&[]).unwrap();
    assert!(none.nodes.is_empty() && none.roots.is_empty() && none.leaves.is_empty());
    none.check(&[]).unwrap();
    let lights = [omni(DVec3::X, 2.0)];
    for build in crate::support::builds(&keys) {
        let one = LightTree::build(&lights, build, WEIGHTED).unwrap();
        one.check(&lights).unwrap();
        assert_eq!((one.nodes.len(), &one.roots[..], &one.leaves[..]), (1, &[0][..], &[0][..]));
    }
}

#[test]
fn a_median_tree_is_as_shallow_as_a_binary_one_can_be() {
    let expected = |count: usize| count.next_power_of_two().trailing_zeros() as usize;
    for count in [1, 2, 3, 4, 5, 7, 8, 9, 100, 1023, 1024, 1025, 10_000] {
        let tree = LightTree::median(&cloud(count, 3)).unwrap();
        assert_eq!(depth(&tree), expected(count), "{count} lights");
        assert_eq!(tree.nodes.len(), 2 * count - 1);
    }
    // Coincident lights are halved too.
    let same = vec![omni(DVec3::ONE, 1.0); 1000];
    assert_eq!(depth(&LightTree::median(&same).unwrap()), 10);
    // Rows of windows are full of ties.
    let windows = windows(50, 7);
    assert_eq!(depth(&LightTree::median(&windows).unwrap()), expected(windows.len()));
}

#[test]
fn keys_are_the_levels_of_the_tree() {
    let lights: Vec<_> = (0..6).map(|i| omni(DVec3::X * f64::from(i), 1.0)).collect();
    let keys = [vec![0, 0], vec![1], vec![0, 1], vec![0, 0], vec![1], vec![7, 7, 7]];
    let tree = LightTree::by_keys(&lights, &keys).unwrap();
    tree.check(&lights).unwrap();
    let sizes: Vec<u32> = tree.nodes.iter().map(|n| n.size).collect();
    // The root, key 0 with its own (0, 0) of two and (0, 1) of one, key 1 of two, key 7 of one.
    assert_eq!(sizes, [10, 5, 3, 1, 1, 1, 3, 1, 1, 1]);
    let order: Vec<u32> = tree.nodes.iter().filter(|n| n.is_leaf()).map(|n| n.light).collect();
    assert_eq!(order, [0, 3, 2, 1, 4, 5]);
}

#[test]
fn a_level_of_one_child_is_left_out() {
    let lights: Vec<_> = (0..3).map(|i| omni(DVec3::X * f64::from(i), 1.0)).collect();
    let keys = vec![vec![4, 4, 4, 1], vec![4, 4, 4, 2], vec![4, 4, 4, 2]];
    let tree = LightTree::by_keys(&lights, &keys).unwrap();
    assert_eq!(tree.nodes.iter().map(|n| n.size).collect::<Vec<_>>(), [5, 1, 3, 1, 1]);
}

#[test]
fn what_cannot_be_clustered_is_refused_by_name() {
    let lights = [omni(DVec3::ZERO, 1.0), omni(DVec3::NAN, 1.0)];
    let error = LightTree::median(&lights).unwrap_err().to_string();
    assert!(error.contains("light 1"), "{error}");
    let lights = [omni(DVec3::ZERO, 1.0)];
    let error = LightTree::by_keys(&lights, &[]).unwrap_err().to_string();
    assert!(error.contains("0 for 1 lights"), "{error}");
    let error = LightTree::by_keys(&lights, &[vec![0; 300]]).unwrap_err().to_string();
    assert!(error.contains("key of light 0: 300 levels of at most 256"), "{error}");
}
