//! Trees before their nodes are known: only what lies below what.

/// A node of a tree of one kind, in depth-first order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    /// Nodes of the subtree.
    pub size: u32,
    /// The light of a leaf.
    pub light: u32,
}

impl Place {
    pub fn leaf(light: u32) -> Self {
        Self { size: 1, light }
    }

    pub fn cluster(size: u32) -> Self {
        Self { size, light: u32::MAX }
    }

    pub fn is_leaf(&self) -> bool {
        self.size == 1
    }
}
