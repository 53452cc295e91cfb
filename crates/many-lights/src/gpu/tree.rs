//! A light tree on a device.

use super::scene::storage;
use crate::{LightsError, PackedTree, cut::Starts};
use dapple_gpu::{Gpu, wgpu};

/// Nodes of a tree and where walks start, uploaded: bindings 0, 1 and 2 of group 1 of
/// `common/lights_tree.wgsl`.
#[derive(Debug)]
pub struct Tree {
    /// `array<LightNode>`, 80 bytes each, at least one element.
    pub nodes: wgpu::Buffer,
    /// `array<u32>`: nodes that walks start from; at least one element.
    pub starts: wgpu::Buffer,
    /// `array<vec2<u32>>`: first and number in `starts`, of the roots, then of object 0, 1, ...; an
    /// object beyond the end starts from the roots.
    pub ranges: wgpu::Buffer,
}

impl Tree {
    /// Uploads a tree.
    ///
    /// # Errors
    /// A buffer over a limit of the device, by name: 10^6 lights in pairs are 160 MB, more than
    /// some devices bind.
    pub fn new(gpu: &Gpu, tree: &PackedTree, starts: &Starts) -> Result<Self, LightsError> {
        let (ranges, list) = starts.lists();
        let mut ranges = ranges.to_vec();
        if let [roots] = *ranges {
            // Buffers have 16 bytes at least, and the shader goes by their size.
            ranges.push(roots);
        }
        Ok(Self {
            nodes: storage(gpu, "light tree", &tree.nodes)?,
            starts: storage(gpu, "starts of walks", list)?,
            ranges: gpu.upload("ranges of starts", &ranges)?,
        })
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        self.nodes.size() + self.starts.size() + self.ranges.size()
    }
}
