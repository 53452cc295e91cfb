//! The hierarchy over objects.

mod bottom_up;
mod city;
mod keys;
mod statistics;
#[cfg(test)]
mod tests;

use super::{Bounds, Objects};
use crate::OcclusionError;
use std::ops::Range;

pub use city::city_keys;
pub use statistics::Statistics;

/// A hierarchy of bounding boxes. The root is node 0 (none for no objects).
#[derive(Clone, Debug, Default)]
pub struct Tree {
    /// Children lie behind their parent.
    pub nodes: Vec<Node>,
    /// Objects in the order of the leaves.
    pub objects: Vec<u32>,
}

/// One node.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Holds everything below.
    pub bounds: Bounds,
    /// The root is its own parent.
    pub parent: u32,
    /// Indices of the children, contiguous; empty for a leaf.
    pub children: Range<u32>,
    /// Objects below, a range of [`Tree::objects`].
    pub objects: Range<u32>,
}

impl Tree {
    /// Whether node `index` has no children.
    pub fn is_leaf(&self, index: u32) -> bool {
        self.nodes[index as usize].children.is_empty()
    }

    /// Objects below node `index`.
    pub fn objects_of(&self, index: u32) -> &[u32] {
        let range = &self.nodes[index as usize].objects;
        &self.objects[range.start as usize..range.end as usize]
    }

    /// Sets the bounds of every node from the objects', deepest first: nodes whose bounds were not
    /// known when they were made.
    fn fit(&mut self, objects: &Objects) {
        for index in (0..self.nodes.len()).rev() {
            let node = &self.nodes[index];
            let bounds = if node.children.is_empty() {
                let below = &self.objects[node.objects.start as usize..node.objects.end as usize];
                below
                    .iter()
                    .fold(Bounds::EMPTY, |all, &o| all.union(objects.objects[o as usize].bounds))
            } else {
                let below = &self.nodes[node.children.start as usize..node.children.end as usize];
                below.iter().fold(Bounds::EMPTY, |all, child| all.union(child.bounds))
            };
            self.nodes[index].bounds = bounds;
        }
    }

    fn node(parent: u32, objects: Range<u32>) -> Node {
        Node { bounds: Bounds::EMPTY, parent, children: 0..0, objects }
    }
}

/// Objects whose boxes a tree can be made of.
fn check(objects: &Objects) -> Result<(), OcclusionError> {
    const MOST: usize = 1 << 31;
    let count = objects.objects.len();
    if count > MOST {
        let limit = format!("{count} objects, at most {MOST} are allowed");
        return Err(OcclusionError::value("tree", limit));
    }
    let bad = |b: &Bounds| !(b.min.is_finite() && b.max.is_finite() && b.min.cmple(b.max).all());
    if let Some(index) = objects.objects.iter().position(|o| bad(&o.bounds)) {
        let Bounds { min, max } = objects.objects[index].bounds;
        let limit = format!("bounds {min} to {max} must be finite and in order");
        return Err(OcclusionError::value(format!("object {index}"), limit));
    }
    Ok(())
}
