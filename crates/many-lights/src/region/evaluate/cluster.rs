//! Clusters on their way through an evaluation.

use super::super::{Cuboid, Direction, Turn};
use crate::{LightTree, cut::children};

/// What [`Cluster::levels`] holds before a cluster above is divided for being hidden in part.
pub(super) const UNDIVIDED: u32 = u32::MAX;

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
    /// The box of a node. What lies within a node's box in local space lies within this one, rounded
    /// as it may be: sums and products are rounded the same way up and down.
    fn cuboid(&self, tree: &LightTree, node: u32) -> Cuboid {
        let node = &tree.nodes[node as usize];
        let (min, max) = self.turn.around(node.min, node.max);
        self.direction.cuboid(min, max)
    }

    /// A node that is to be looked at first.
    pub fn start(&self, tree: &LightTree, node: u32, start: u32) -> Cluster {
        let cuboid = self.cuboid(tree, node);
        Cluster { cuboid, node, levels: UNDIVIDED, start, strong: false }
    }

    /// The children of a cluster follow it in the queue.
    pub fn divide(&self, tree: &LightTree, from: &Cluster, levels: u32, queue: &mut Vec<Cluster>) {
        for node in children(from.node, |node| tree.nodes[node as usize].size) {
            let cuboid = self.cuboid(tree, node);
            queue.push(Cluster { cuboid, node, levels, start: from.start, strong: false });
        }
    }
}
