//! What holds for any lights, however they are clustered.

use crate::support::{REPRESENTATIVES, any_keys, any_lights, builds};
use dapple_many_lights::LightTree;
use proptest::prelude::*;

proptest! {
    #[test]
    fn every_tree_holds_its_lights(
        (lights, keys) in any_lights(60).prop_flat_map(|l| { let n = l.len(); (Just(l), any_keys(n)) })
    ) {
        for build in builds(&keys) {
            for representative in REPRESENTATIVES {
                let tree = LightTree::build(&lights, build, representative).unwrap();
                tree.check(&lights).unwrap();
                let kinds: Vec<u32> = tree.roots.iter().map(|&r| tree.nodes[r as usize].kind).collect();
                prop_assert!(kinds.is_sorted_by(|a, b| a < b));
                prop_assert!(tree.nodes.iter().all(|n| n.size != 2), "a node of one child");
            }
        }
    }
}
