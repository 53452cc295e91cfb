//! R2 on a device: the worst cluster of a cut is found by looking at all of them.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 3.2 (tried, and
//! found too slow there).
//! Deviations: clusters that may still be split lie in a buffer of bounded size, whose columns are
//! used again tile after tile; single lights are summed at once and not kept.

use super::{
    cut::{finite, form_constant},
    kernel::{Kernel, Parts},
    scene::{LANES, Scene},
    tree::Tree,
};
use crate::{Lightcuts, Lighting, LightsError, cut::Given};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

/// Most bytes of open clusters: columns for 65,536 pixels at once with cuts of 1000 nodes, which
/// fill any device. A device that binds less gets less.
const STATE_BYTES: u64 = 512 << 20;

/// Bytes of an open cluster: its node and its bound.
const CLUSTER_BYTES: u64 = 8;

/// Mirrors `LightcutsParams` of `many-lights/lightcuts.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct LightcutsParams {
    epsilon: f32,
    most: u32,
    threads: u32,
    pad: u32,
}

/// Makes lightcuts.
///
/// # Errors
/// A cut that may hold so many nodes that the columns of one workgroup pass a limit of the device.
pub(super) fn lightcuts<'g>(
    scene: &Arc<Scene<'g>>,
    given: &Given,
    tree: &Tree,
    settings: &Lightcuts,
) -> Result<Box<dyn Lighting + 'g>, LightsError> {
    let gpu = scene.gpu;
    // Starts are members of a cut even beyond its most; and no cut has more nodes than the tree.
    let rows = (settings.most as usize).max(given.starts.most()).min(given.tree.nodes.len());
    let group_bytes = LANES * CLUSTER_BYTES * rows.max(1) as u64;
    let budget = STATE_BYTES.min(gpu.limits().max_storage_buffer_binding_size);
    let most = u64::from(gpu.limits().max_compute_workgroups_per_dimension);
    let groups = (budget / group_bytes).min(scene.most_tiles()).min(most).max(1);
    let open = gpu.buffer("open clusters of cuts", groups * group_bytes)?;
    let params = LightcutsParams {
        epsilon: finite(settings.epsilon),
        most: settings.most,
        threads: (groups * LANES) as u32,
        pad: 0,
    };
    let params = gpu.uniform("lightcuts", &params)?;
    let parts = Parts {
        pass: "lightcuts",
        path: "many-lights/lightcuts.wgsl",
        constants: &[form_constant(settings.bound)],
        buffers: &[&tree.nodes, &tree.starts, &tree.ranges, &params, &open],
        evaluates_all: true,
        most_groups: Some(groups as u32),
    };
    Ok(Box::new(Kernel::new(scene, &parts)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_has_the_layout_of_the_shader() {
        let fields = [("epsilon", 0), ("most", 4), ("threads", 8), ("pad", 12)];
        let path = "many-lights/lightcuts.wgsl";
        crate::gpu::mirror::<LightcutsParams>(path, "LightcutsParams", &fields);
    }
}
