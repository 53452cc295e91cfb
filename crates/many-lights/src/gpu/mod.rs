//! The same techniques on a device: WGSL kernels, one thread a pixel, one workgroup a tile.

mod scene;
mod tree;

pub use scene::{FrameParams, Output, PackedLight, Scene, TILE};
pub use tree::Tree;
