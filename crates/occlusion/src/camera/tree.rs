//! The hierarchy over objects.

use super::{Bounds, Objects};
use crate::OcclusionError;
use std::ops::Range;

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
    /// Bottom-up: the pair of the smallest common surface area is joined first, within a
    /// neighbourhood (locally ordered) where there are more than a few thousand. Binary; leaves of
    /// one object.
    ///
    /// # Errors
    /// More objects than 2^31.
    pub fn bottom_up(objects: &Objects) -> Result<Self, OcclusionError> {
        let _ = objects;
        Err(OcclusionError::value("tree", "not yet"))
    }

    /// By a given hierarchy: objects with equal leading keys share a node at that level; levels of
    /// a single child are left out. Leaves of one object. `keys` has one path an object, of any
    /// length.
    ///
    /// # Errors
    /// Another number of keys than objects.
    pub fn by_keys(objects: &Objects, keys: &[Vec<u32>]) -> Result<Self, OcclusionError> {
        let _ = (objects, keys);
        Err(OcclusionError::value("tree", "not yet"))
    }

    /// Whether node `index` has no children.
    pub fn is_leaf(&self, index: u32) -> bool {
        self.nodes[index as usize].children.is_empty()
    }

    /// Objects below node `index`.
    pub fn objects_of(&self, index: u32) -> &[u32] {
        let range = &self.nodes[index as usize].objects;
        &self.objects[range.start as usize..range.end as usize]
    }
}
