//! Where f32 may cut otherwise than f64.
//!
//! Bounds are the same sums in both, but rounded: a node whose bound all but reaches its limit may be
//! taken by one and split by the other. That is no fault of a port as long as every node in which two
//! cuts part lies within a stated band around its limit.

use super::{
    rule::{Receiver, Rule},
    walk::walk,
};
use crate::{LightTree, Node, PackedNode, PackedTree, bound::packed};

/// Half the band's width, as a share of the limit. Rounding alone moves a bound by some 1e-6 of what it
/// would be without its cosine and its falloff; where these are small, that is a larger share of the
/// bound itself.
pub const BAND: f64 = 1e-3;

/// A node that both cuts look at, and only one takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// The node.
    pub node: u32,
    /// Its bound in f64.
    pub bound: f64,
    /// The largest bound with which it would be taken, in f64.
    pub limit: f64,
}

impl Difference {
    /// Whether rounding explains it.
    pub fn is_explained(&self) -> bool {
        (self.bound - self.limit).abs() <= BAND * self.limit
    }
}

impl Rule {
    /// Whether a node stands for its lights in f32.
    pub fn takes(self, node: &PackedNode, receiver: &Receiver<'_>) -> bool {
        let Receiver { point, form, clamp_m } = *receiver;
        let clamp_squared = packed::clamp_squared(clamp_m);
        let limit = match self {
            Self::Absolute(threshold) => threshold as f32,
            Self::Relative(epsilon) => {
                let estimate = packed::estimate(node, point, clamp_squared).max_element();
                estimate + epsilon as f32 * estimate
            }
        };
        let is_split = node.size > 1 && packed::point(form, node, point, clamp_squared) > limit;
        !is_split
    }
}

/// Where the cut of `tree` in f64 and the cut that `takes` makes part. Below such a node the two have
/// nothing to compare.
pub fn differences(
    tree: &LightTree,
    starts: &[u32],
    rule: Rule,
    receiver: &Receiver<'_>,
    takes: impl Fn(u32) -> bool,
) -> Vec<Difference> {
    let mut differences = Vec::new();
    walk(tree, starts, |index, node| {
        let look = rule.look(node, receiver);
        let other = takes(index);
        if look.taken != other {
            differences.push(difference(rule, index, node, receiver));
        }
        look.taken || other
    });
    differences
}

/// Nodes that the cut in f64 looks at and that lie within the band: where there are none, every port
/// cuts alike.
pub fn undecided(tree: &LightTree, starts: &[u32], rule: Rule, receiver: &Receiver<'_>) -> usize {
    let mut undecided = 0;
    walk(tree, starts, |index, node| {
        let inner = !node.is_leaf();
        undecided += usize::from(inner && difference(rule, index, node, receiver).is_explained());
        rule.look(node, receiver).taken
    });
    undecided
}

fn difference(rule: Rule, index: u32, node: &Node, receiver: &Receiver<'_>) -> Difference {
    let estimate = crate::bound::estimate(node, receiver.point, receiver.clamp_m).max_element();
    let bound = crate::bound::point(receiver.form, node, receiver.point, receiver.clamp_m);
    Difference { node: index, bound, limit: rule.limit(estimate) }
}

/// The tree whose numbers are those of the packed one: what f32 walks is held against it, since
/// packing has moved boxes and cones outwards already.
pub fn unpacked(tree: &PackedTree) -> LightTree {
    let nodes: Vec<Node> = tree.nodes.iter().map(PackedNode::unpack).collect();
    let lights = nodes.iter().filter(|node| node.is_leaf()).count();
    let mut leaves = vec![0; lights];
    for (index, node) in nodes.iter().enumerate().filter(|(_, node)| node.is_leaf()) {
        if let Some(leaf) = leaves.get_mut(node.light as usize) {
            *leaf = index as u32;
        }
    }
    LightTree { nodes, roots: tree.roots.clone(), leaves }
}
