//! R2 on a device: the worst cluster of a cut is found by looking at all of them.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 3.2 (tried, and
//! found too slow there).
//! Deviations: clusters that may still be split lie in a buffer of bounded size, whose columns are
//! used again tile after tile; single lights are summed at once and not kept.

use super::scene::{LANES, Scene};
use crate::LightsError;
use bytemuck::{Pod, Zeroable};
use dapple_gpu::wgpu;

/// Most bytes of open clusters: columns for 65,536 pixels at once with cuts of 1000 nodes, which
/// fill any device. A device that binds less gets less.
const STATE_BYTES: u64 = 512 << 20;

/// Bytes of an open cluster: its node and its bound.
const CLUSTER_BYTES: u64 = 8;

/// Mirrors `LightcutsParams` of `many-lights/lightcuts.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(super) struct LightcutsParams {
    pub(super) epsilon: f32,
    pub(super) most: u32,
    pub(super) threads: u32,
    pub(super) moving: [u32; 2],
    pub(super) pad: [u32; 3],
}

/// Open clusters of all pixels that are lit at once.
#[derive(Debug)]
pub(super) struct Room {
    /// Columns of `rows`, one an invocation.
    pub(super) open: wgpu::Buffer,
    /// Clusters of a column.
    pub(super) rows: usize,
    /// Workgroups that share out the tiles.
    pub(super) groups: u32,
}

impl Room {
    /// Room for `rows` clusters a cut.
    ///
    /// # Errors
    /// So many that the columns of one workgroup pass a limit of the device.
    pub(super) fn new(scene: &Scene<'_>, rows: usize) -> Result<Self, LightsError> {
        let limits = scene.gpu.limits();
        let group_bytes = LANES * CLUSTER_BYTES * rows.max(1) as u64;
        let budget = STATE_BYTES.min(limits.max_storage_buffer_binding_size);
        let most = u64::from(limits.max_compute_workgroups_per_dimension);
        let groups = (budget / group_bytes).min(scene.most_tiles()).min(most).max(1);
        let open = scene.gpu.buffer("open clusters of cuts", groups * group_bytes)?;
        Ok(Self { open, rows, groups: groups as u32 })
    }

    /// Columns.
    pub(super) fn threads(&self) -> u32 {
        self.groups * LANES as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_has_the_layout_of_the_shader() {
        let fields = [
            ("epsilon", 0),
            ("most", 4),
            ("threads", 8),
            ("moving", 12),
            ("moving_end", 16),
            ("pad0", 20),
            ("pad1", 24),
            ("pad2", 28),
        ];
        let path = "many-lights/lightcuts.wgsl";
        crate::gpu::mirror::<LightcutsParams>(path, "LightcutsParams", &fields);
    }
}
