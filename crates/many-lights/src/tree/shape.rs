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

/// Two clusters that become one. Lights come first, then clusters in the order of their making.
pub(super) type Merge = [u32; 2];

/// The binary tree that joins make, the last being its root. `ids` are the lights by number.
pub(super) fn from_merges(ids: &[u32], merges: &[Merge]) -> Vec<Place> {
    let mut sizes = vec![1_u32; ids.len() + merges.len()];
    for (i, &[a, b]) in merges.iter().enumerate() {
        sizes[ids.len() + i] = sizes[a as usize] + sizes[b as usize] + 1;
    }
    let mut places = Vec::with_capacity(sizes.len());
    let mut open = vec![sizes.len() - 1];
    while let Some(cluster) = open.pop() {
        if let Some(&id) = ids.get(cluster) {
            places.push(Place::leaf(id));
        } else {
            places.push(Place::cluster(sizes[cluster]));
            let [a, b] = merges[cluster - ids.len()];
            open.extend([b as usize, a as usize]);
        }
    }
    places
}
