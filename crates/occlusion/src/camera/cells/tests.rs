use super::*;
use crate::camera::{Bounds, Object, Objects};
use glam::{Mat3, Vec3};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;
use std::collections::BTreeSet;

const FREE: u32 = u32::MAX;

fn objects(count: usize, rng: &mut Pcg32) -> Objects {
    let mut one = || {
        let min = Vec3::new(rng.random(), rng.random(), rng.random());
        let bounds = Bounds { min, max: min + 0.1 };
        Object { template: 0, linear: Mat3::IDENTITY, translation: Vec3::ZERO, bounds }
    };
    Objects { objects: (0..count).map(|_| one()).collect(), ..Objects::default() }
}

/// Pixels of every node, the sum of its objects'.
fn summed(tree: &Tree, pixels: &[u32]) -> Vec<u32> {
    let sum = |index: u32| tree.objects_of(index).iter().map(|&o| pixels[o as usize]).sum();
    (0..tree.nodes.len() as u32).map(sum).collect()
}

struct Frame {
    tree: Tree,
    pixels: Vec<u32>,
    coverage: Vec<u32>,
    visible: Vec<u32>,
}

fn frame(count: usize, seed: u64) -> Frame {
    let mut rng = Pcg32::seed_from_u64(seed);
    let tree = Tree::bottom_up(&objects(count, &mut rng)).unwrap();
    let mut pixel = || if rng.random::<bool>() { rng.random_range(1..1000) } else { 0 };
    let pixels: Vec<u32> = (0..count).map(|_| pixel()).collect();
    let coverage = summed(&tree, &pixels);
    let visible = (0..count as u32).filter(|&o| pixels[o as usize] > 0).collect();
    Frame { tree, pixels, coverage, visible }
}

fn cells(f: &Frame, coverage: &[u32], tau_px: u32, most_level: u32) -> Cells {
    let limits = CellLimits { tau_px, most_level };
    view_cells(&f.tree, coverage, &f.tree.levels(), &f.visible, limits).unwrap()
}

proptest! {
    #[test]
    fn every_visible_object_is_in_one_cell_and_cells_fall_as_the_threshold_rises(
        count in 1_usize..120, seed: u64, stale: bool, most_level in 0_u32..12,
    ) {
        let f = frame(count, seed);
        let mut rng = Pcg32::seed_from_u64(seed ^ 1);
        let mut coverage = f.coverage.clone();
        if stale {
            for c in &mut coverage {
                *c = rng.random_range(0..3000);
            }
        }
        let mut before = usize::MAX;
        for tau in [0, 1, 10, 100, 500, 2000, 10_000, u32::MAX] {
            let found = cells(&f, &coverage, tau, most_level);
            prop_assert!(found.cells.len() <= before);
            before = found.cells.len();
            let all: BTreeSet<u32> = found.objects.iter().copied().collect();
            prop_assert_eq!(all.len(), found.objects.len());
            prop_assert!(all.into_iter().eq(f.visible.iter().copied()));
            let mut end = 0;
            for (i, cell) in found.cells.iter().enumerate() {
                prop_assert_eq!(cell.objects.start, end);
                end = cell.objects.end;
                prop_assert!(!cell.objects.is_empty());
                let below = f.tree.objects_of(cell.node);
                prop_assert!(found.objects_of(i).iter().all(|o| below.contains(o)));
                // It stopped for a reason, and its parent had none.
                let level = f.tree.levels();
                let free = |n: u32| {
                    let least = f.tree.objects_of(n).iter().filter(|&&o| f.pixels[o as usize] > 0);
                    let pixels = coverage[n as usize].max(least.count() as u32);
                    pixels > tau && level[n as usize] < most_level && !f.tree.is_leaf(n)
                };
                prop_assert!(!free(cell.node));
                let parent = f.tree.nodes[cell.node as usize].parent;
                prop_assert!(cell.node == 0 || free(parent));
            }
            prop_assert_eq!(end as usize, found.objects.len());
        }
    }
}

#[test]
fn thresholds_of_nothing_and_of_everything() {
    for seed in 0..20 {
        let f = frame(40, seed);
        let found = cells(&f, &f.coverage, 0, FREE);
        assert_eq!(found.cells.len(), f.visible.len());
        assert!(found.cells.iter().all(|c| f.tree.is_leaf(c.node)));
        let found = cells(&f, &f.coverage, u32::MAX, FREE);
        assert_eq!(found.cells.iter().map(|c| c.node).collect::<Vec<_>>(), [0]);
        // Nodes that were never asked do not lose what is visible.
        let unknown = vec![0; f.coverage.len()];
        assert_eq!(cells(&f, &unknown, 0, FREE).cells.len(), f.visible.len());
    }
}

#[test]
fn descent_stops_at_a_kind_of_node() {
    // Two buildings of two facades of three storeys; the second building has but one facade.
    let mut keys = Vec::new();
    for (building, facades) in [(0, 2), (1, 1)] {
        for facade in 0..facades {
            keys.extend((0..3).map(|storey| vec![building, facade, storey]));
        }
    }
    let mut rng = Pcg32::seed_from_u64(1);
    let objects = objects(9, &mut rng);
    let tree = Tree::by_keys(&objects, &keys).unwrap();
    let lengths = tree.path_lengths(&keys).unwrap();
    let coverage = vec![1000; tree.nodes.len()];
    let visible: Vec<u32> = (0..9).collect();
    let count = |most_level: u32| {
        let limits = CellLimits { tau_px: 10, most_level };
        view_cells(&tree, &coverage, &lengths, &visible, limits).unwrap().cells.len()
    };
    assert_eq!([0, 1, 2, 3, FREE].map(count), [1, 2, 3, 9, 9]);
    assert!(tree.path_lengths(&keys[1..]).is_err());
}

#[test]
fn nothing_visible_and_lists_that_do_not_fit() {
    let f = frame(10, 3);
    let limits = CellLimits { tau_px: 0, most_level: FREE };
    let levels = f.tree.levels();
    let none = view_cells(&f.tree, &f.coverage, &levels, &[], limits).unwrap();
    assert_eq!(none, Cells::default());
    let empty = view_cells(&Tree::default(), &[], &[], &[], limits).unwrap();
    assert_eq!(empty, Cells::default());
    let refused = |coverage: &[u32], levels: &[u32], visible: &[u32]| {
        view_cells(&f.tree, coverage, levels, visible, limits).unwrap_err().to_string()
    };
    assert_eq!(refused(&[1], &levels, &[]), "coverage: 1 nodes, where the tree has 19");
    assert!(refused(&f.coverage, &[], &[]).contains("levels: 0 nodes"));
    assert!(refused(&f.coverage, &levels, &[10]).contains("object 10"));
    // Named twice is there once.
    let twice = view_cells(&f.tree, &f.coverage, &levels, &[4, 4], limits).unwrap();
    assert_eq!(twice.objects, [4]);
}
