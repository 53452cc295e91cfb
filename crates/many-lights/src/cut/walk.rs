//! Ways through a tree in depth-first order.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 3.1 (skip counts in
//! place of a stack).
//! Deviations: none.

use crate::{LightTree, Node};
use std::borrow::Borrow;

/// The children of a node of a tree whose nodes have `size`, in order.
pub fn children(node: u32, size: impl Fn(u32) -> u32 + Clone) -> impl Iterator<Item = u32> + Clone {
    let end = node + size(node);
    let first = (node + 1 < end).then_some(node + 1);
    std::iter::successors(first, move |&child| {
        let next = child + size(child);
        (next < end).then_some(next)
    })
}

/// Goes through a tree from `starts` in its own order, without a stack: `look` says whether a node
/// stands for its lights, and so is skipped with all below, or is gone into.
pub fn walk(
    tree: &LightTree,
    starts: impl IntoIterator<Item: Borrow<u32>>,
    mut look: impl FnMut(u32, &Node) -> bool,
) {
    for start in starts {
        let start = *start.borrow();
        let mut index = start;
        let end = start + tree.nodes[start as usize].size;
        while index < end {
            let node = &tree.nodes[index as usize];
            index += if look(index, node) { node.size } else { 1 };
        }
    }
}

/// The same by recursion over children: what [`walk`] is held against.
pub fn recursion(tree: &LightTree, start: u32, look: &mut impl FnMut(u32, &Node) -> bool) {
    if !look(start, &tree.nodes[start as usize]) {
        for child in children(start, |node| tree.nodes[node as usize].size) {
            recursion(tree, child, look);
        }
    }
}
