//! A light tree on a device.

use super::{room::put, scene::storage};
use crate::{
    LightsError, PackedNode, PackedTree,
    cut::{Moving, Starts},
};
use dapple_gpu::{Gpu, wgpu};

/// Nodes of a tree and where walks start, uploaded: bindings 0, 1 and 2 of group 1 of
/// `common/lights_tree.wgsl`.
#[derive(Debug)]
pub struct Tree {
    /// `array<LightNode>`, 80 bytes each, at least one element, and room behind.
    pub nodes: wgpu::Buffer,
    /// `array<u32>`: nodes that walks start from, at least one element, and room behind; where
    /// [`Tree::has_heights`], each is followed by the bits of its height.
    pub starts: wgpu::Buffer,
    /// `array<vec2<u32>>`: first and number in `starts`, of the roots, then of object 0, 1, ...; an
    /// object beyond the end starts from the roots.
    pub ranges: wgpu::Buffer,
    has_heights: bool,
    /// Start nodes, and ranges.
    held: [usize; 2],
    /// Bytes of the last starts that were sent.
    sent: u64,
}

/// What a change sent.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sent {
    pub(super) bytes: u64,
    /// Whether a buffer is another, and bound no more.
    pub(super) is_rebound: bool,
}

impl Tree {
    /// Uploads a tree.
    ///
    /// # Errors
    /// A buffer over a limit of the device, by name: 10^6 lights in pairs are 160 MB, more than
    /// some devices bind.
    pub fn new(gpu: &Gpu, tree: &PackedTree, starts: &Starts) -> Result<Self, LightsError> {
        let has_heights = !starts.hidden_below().is_empty();
        let (ranges, list) = (ranges_of(starts), words(starts, has_heights));
        Ok(Self {
            nodes: storage(gpu, "light tree", &tree.nodes)?,
            starts: storage(gpu, "starts of walks", &list)?,
            ranges: gpu.upload("ranges of starts", &ranges)?,
            has_heights,
            held: held(starts),
            sent: (size_of_val(&*list) + size_of_val(&*ranges)) as u64,
        })
    }

    /// Whether starts have heights: constant `HEIGHTS` of the shader. Once they had, they have.
    pub fn has_heights(&self) -> bool {
        self.has_heights
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        self.nodes.size() + self.starts.size() + self.ranges.size()
    }

    /// Uploads other starts. Another number of objects, or more starts than there is room for, make
    /// other buffers.
    pub(super) fn start(&mut self, gpu: &Gpu, starts: &Starts) -> Result<Sent, LightsError> {
        let has_heights = self.has_heights || !starts.hidden_below().is_empty();
        let (ranges, list) = (ranges_of(starts), words(starts, has_heights));
        let list = bytemuck::cast_slice(&list);
        let mut is_rebound = put(gpu, "starts of walks", &mut self.starts, 0, list)?;
        let bytes = size_of_val(&*ranges) as u64;
        if self.ranges.size() == bytes {
            gpu.queue.write_buffer(&self.ranges, 0, bytemuck::cast_slice(&ranges));
        } else {
            // The shader goes by its size.
            self.ranges = gpu.upload("ranges of starts", &ranges)?;
            is_rebound = true;
        }
        (self.has_heights, self.held) = (has_heights, held(starts));
        self.sent = bytes + list.len() as u64;
        Ok(Sent { bytes: self.sent, is_rebound })
    }

    /// Uploads the nodes of lights that move, behind those of the world's.
    pub(super) fn replace_moving(
        &mut self,
        gpu: &Gpu,
        moving: &Moving,
        tree: &PackedTree,
    ) -> Result<Sent, LightsError> {
        let number = moving.fixed.lights as u32;
        let behind = |node: &PackedNode| PackedNode { light: node.light + number, ..*node };
        let nodes: Vec<PackedNode> = tree.nodes.iter().map(behind).collect();
        let nodes = bytemuck::cast_slice(&nodes);
        let at = (moving.fixed.nodes * size_of::<PackedNode>()) as u64;
        let is_rebound = put(gpu, "light tree", &mut self.nodes, at, nodes)?;
        Ok(Sent { bytes: nodes.len() as u64, is_rebound })
    }

    /// What is on the device.
    pub(super) fn starts(&self, gpu: &Gpu) -> Result<Starts, LightsError> {
        let [nodes, ranges] = self.held;
        let ranges = gpu.read(&self.ranges, 0, ranges)?;
        if !self.has_heights {
            return Ok(Starts::of_lists(ranges, gpu.read(&self.starts, 0, nodes)?, Vec::new()));
        }
        let words: Vec<[u32; 2]> = gpu.read(&self.starts, 0, nodes)?;
        let height = |&[_, bits]: &[u32; 2]| match f32::from_bits(bits) {
            f32::MIN => f32::NEG_INFINITY,
            f32::MAX => f32::INFINITY,
            height => height,
        };
        let nodes = words.iter().map(|&[node, _]| node).collect();
        Ok(Starts::of_lists(ranges, nodes, words.iter().map(height).collect()))
    }
}

fn held(starts: &Starts) -> [usize; 2] {
    let (ranges, nodes) = starts.lists();
    [nodes.len(), ranges.len()]
}

fn ranges_of(starts: &Starts) -> Vec<[u32; 2]> {
    let mut ranges = starts.lists().0.to_vec();
    if let [roots] = *ranges {
        // Buffers have 16 bytes at least, and the shader goes by their size.
        ranges.push(roots);
    }
    ranges
}

/// Starts as they lie on a device.
fn words(starts: &Starts, with_heights: bool) -> Vec<u32> {
    let (_, nodes) = starts.lists();
    if !with_heights {
        return nodes.to_vec();
    }
    // Shaders need not know infinities; points lie within 10^9 m.
    let bits = |height: f32| height.clamp(f32::MIN, f32::MAX).to_bits();
    let all = starts.with_heights([0, nodes.len() as u32]);
    all.flat_map(|(node, height)| [node, bits(height)]).collect()
}
