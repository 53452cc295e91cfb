//! The order of children, which changes no sum but by rounding.

use super::{LightTree, fit::children};

impl LightTree {
    /// The same tree with the children of every cluster in the order that `arrange` leaves their node
    /// numbers in.
    pub fn with_children_arranged(&self, mut arrange: impl FnMut(&mut [u32])) -> Self {
        let mut new = Self { leaves: vec![0; self.leaves.len()], ..Self::default() };
        for &root in &self.roots {
            new.roots.push(new.nodes.len() as u32);
            let mut open = vec![root];
            while let Some(index) = open.pop() {
                let node = self.nodes[index as usize];
                if node.is_leaf() {
                    new.leaves[node.light as usize] = new.nodes.len() as u32;
                }
                new.nodes.push(node);
                let below = open.len();
                open.extend(children(&self.nodes, index as usize).map(|child| child as u32));
                arrange(&mut open[below..]);
                // The first is taken first.
                open[below..].reverse();
            }
        }
        new
    }
}
