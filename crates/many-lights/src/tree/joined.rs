//! A small tree beside a large one: lights that move, clustered anew every frame.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 6.1 (future work:
//! dynamic lights in a second tree). Walks sum over all roots, so that a second tree is more roots.

use super::{LightTree, PackedTree};

/// How much of a tree comes before what is made anew.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Extent {
    /// Nodes.
    pub nodes: usize,
    /// Roots.
    pub roots: usize,
    /// Lights.
    pub lights: usize,
}

impl LightTree {
    /// All of it.
    pub fn extent(&self) -> Extent {
        Extent { nodes: self.nodes.len(), roots: self.roots.len(), lights: self.leaves.len() }
    }

    /// Replaces what comes after `fixed`, an extent that the tree once had, by the trees of other
    /// lights, whose numbers follow those before. A kind may then have a root twice.
    pub fn replace_after(&mut self, fixed: Extent, other: &Self) {
        self.nodes.truncate(fixed.nodes);
        self.roots.truncate(fixed.roots);
        self.leaves.truncate(fixed.lights);
        let (nodes, lights) = (self.nodes.len() as u32, self.leaves.len() as u32);
        self.nodes.extend(other.nodes.iter().map(|&node| {
            let mut node = node;
            node.light += lights;
            node
        }));
        self.roots.extend(other.roots.iter().map(|root| root + nodes));
        self.leaves.extend(other.leaves.iter().map(|leaf| leaf + nodes));
    }
}

impl PackedTree {
    /// As [`LightTree::replace_after`], of trees packed.
    pub fn replace_after(&mut self, fixed: Extent, other: &Self) {
        self.nodes.truncate(fixed.nodes);
        self.roots.truncate(fixed.roots);
        let nodes = self.nodes.len() as u32;
        self.nodes.extend(other.nodes.iter().map(|&node| {
            let mut node = node;
            node.light += fixed.lights as u32;
            node
        }));
        self.roots.extend(other.roots.iter().map(|root| root + nodes));
    }
}
