//! Light trees: lights clustered, in depth-first order with skip counts.

mod node;

pub use node::{LightTree, Node, PackedNode, PackedTree};
