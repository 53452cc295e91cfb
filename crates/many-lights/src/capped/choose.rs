//! The strongest lights by a walk of the light tree, the largest bound first.
//!
//! What a cluster is bounded by here is at least the bound of each of its lights, so a light that
//! comes up before all clusters and lights that are left is the strongest of them. That is why cones
//! of clusters are not looked at: a bound by a cluster's axis and cone holds for what its lights give,
//! but may lie below the bound of one of them by its own axis, and then which lights are chosen
//! would depend on the tree.

use crate::{
    BoundForm, Emission, PackedNode, PackedTree,
    bound::packed::{PackedRegion, region},
};
use std::collections::BinaryHeap;

/// By how much bounds of clusters are raised: rounding could take that much from them and not from
/// their lights'.
const RAISE: f32 = 1.0001;

/// Clusters come before lights of the same bound, so that equally strong lights are compared.
const CLUSTER: u64 = 1 << 31;

/// Lights chosen, and what a choice needs while it is made; it keeps its memory.
#[derive(Clone, Debug, Default)]
pub struct Choice {
    /// Indices of lights, in increasing order.
    pub lights: Vec<u32>,
    /// Bounds that were evaluated.
    pub bounds: u64,
    /// Whether the cap left out a light or cluster that may give something.
    pub ended: bool,
    /// Largest first: the bound's bits, [`CLUSTER`] or not, lowest index first.
    heap: BinaryHeap<u64>,
}

impl Choice {
    fn push(&mut self, tree: &PackedTree, over: &PackedRegion, index: usize, clamp_squared: f32) {
        let node = &tree.nodes[index];
        let leaf = node.size == 1;
        let bound = if leaf || node.kind == Emission::Directional.code() {
            region(BoundForm::Walter, node, over, clamp_squared)
        } else {
            let to_all_sides = PackedNode { kind: Emission::Omni.code(), ..*node };
            region(BoundForm::Walter, &to_all_sides, over, clamp_squared)
        };
        self.bounds += 1;
        if bound > 0.0 {
            // Bounds are not negative: their bits are in their order. Indices are below 2^31.
            let bits = if leaf { bound } else { bound * RAISE }.to_bits();
            let (low, kind) = if leaf { (node.light, 0) } else { (index as u32, CLUSTER) };
            self.heap.push(u64::from(bits) << 32 | kind | (CLUSTER - 1 - u64::from(low)));
        }
    }
}

/// Chooses the `most` lights with the largest bounds over a region.
pub fn strongest(
    tree: &PackedTree,
    over: &PackedRegion,
    most: usize,
    clamp_squared: f32,
    choice: &mut Choice,
) {
    choice.lights.clear();
    choice.heap.clear();
    choice.bounds = 0;
    for &root in &tree.roots {
        choice.push(tree, over, root as usize, clamp_squared);
    }
    while choice.lights.len() < most {
        let Some(key) = choice.heap.pop() else { break };
        let index = (CLUSTER - 1 - (key & (CLUSTER - 1))) as usize;
        if key & CLUSTER == 0 {
            choice.lights.push(index as u32);
            continue;
        }
        let end = index + tree.nodes[index].size as usize;
        let mut child = index + 1;
        while child < end {
            choice.push(tree, over, child, clamp_squared);
            child += tree.nodes[child].size as usize;
        }
    }
    choice.ended = !choice.heap.is_empty();
    choice.lights.sort_unstable();
}
