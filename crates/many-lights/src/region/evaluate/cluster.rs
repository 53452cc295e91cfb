//! Clusters on their way through an evaluation.

use super::super::{Cuboid, Direction, Turn};
use crate::{LightTree, cut::children};

/// What [`Cluster::levels`] holds before a cluster above is divided for being hidden in part.
pub(super) const UNDIVIDED: u32 = u32::MAX;

/// What [`Cluster::supports`] holds before the first projection.
pub(super) const UNPROJECTED: u32 = u32::MAX;

/// A node of the light tree with its box as the cell sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cluster {
    /// Its box in the space of the direction.
    pub cuboid: Cuboid,
    /// The node.
    pub node: u32,
    /// Levels below it that may yet be tested, or [`UNDIVIDED`].
    pub levels: u32,
    /// Which of the start nodes it came from.
    pub start: u32,
    /// Place of what its projections have in common, or [`UNPROJECTED`].
    pub supports: u32,
    /// Whether its upper bound was found not to be too weak.
    pub strong: bool,
}

/// How a cell looks at the tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    /// Local space to turned space.
    pub turn: Turn,
    /// Turned space to the direction's.
    pub direction: Direction,
}

impl Sight {
    /// A node and its box. What lies within a node's box in local space lies within this one, rounded
    /// as it may be: sums and products are rounded the same way up and down.
    fn cluster(&self, tree: &LightTree, node: u32, levels: u32, start: u32) -> Cluster {
        let of = &tree.nodes[node as usize];
        let (min, max) = self.turn.around(of.min, of.max);
        let cuboid = self.direction.cuboid(min, max);
        Cluster { cuboid, node, levels, start, supports: UNPROJECTED, strong: false }
    }

    /// A node that is to be looked at first.
    pub fn start(&self, tree: &LightTree, node: u32, start: u32) -> Cluster {
        self.cluster(tree, node, UNDIVIDED, start)
    }

    /// The children of a cluster follow it in the queue.
    pub fn divide(&self, tree: &LightTree, from: &Cluster, levels: u32, queue: &mut Vec<Cluster>) {
        for node in children(from.node, |node| tree.nodes[node as usize].size) {
            queue.push(self.cluster(tree, node, levels, from.start));
        }
    }
}
