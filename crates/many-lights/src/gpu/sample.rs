//! Lights drawn down a tree on a device: a kernel that draws the numbers that the processor draws.

use super::{
    kernel::{Kernel, Parts},
    scene::{LANES, Scene},
    tree::Tree,
};
use crate::{
    LightTree, Lighting, LightsError, Shaded, StochasticLightcuts, Technique, Times, cut::Starts,
};
use bytemuck::{Pod, Zeroable};
use dapple_gpu::wgpu;
use std::sync::Arc;

/// Most bytes of slots of cuts: columns for a million pixels at once with cuts of 30 nodes. A device
/// that binds less gets less.
const STATE_BYTES: u64 = 256 << 20;

/// Bytes of a slot: a node and its error bound.
const SLOT_BYTES: u64 = 8;

/// Slots that a cut takes beyond its greatest number, while a node is split.
const SPARE: u64 = 2;

/// Mirrors `DrawParams` of `common/lights_draw.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct DrawParams {
    seed: u32,
    number: u32,
    stride: u32,
    pad: u32,
}

/// A kernel and its seed.
struct Sampler<'g> {
    scene: Arc<Scene<'g>>,
    kernel: Kernel<'g>,
    params: DrawParams,
    uniform: wgpu::Buffer,
}

/// Makes a sampler.
///
/// # Errors
/// A technique that draws no lights down a tree; a tree of other lights; a tree or cuts over a limit of the device, by name.
pub(crate) fn sampler<'g>(
    scene: &Arc<Scene<'g>>,
    technique: &Technique,
    tree: &LightTree,
) -> Result<Box<dyn Lighting + 'g>, LightsError> {
    let gpu = scene.gpu;
    tree.check_number(&scene.world.lights)?;
    let nodes = Tree::new(gpu, &tree.pack(), &Starts::roots(&tree.roots))?;
    let (pass, path, params, slots, most_groups) = match technique {
        Technique::LightBvh(settings) => {
            let params = DrawParams { number: settings.samples, ..DrawParams::default() };
            ("light-bvh", "many-lights/light_bvh.wgsl", params, None, None)
        }
        Technique::StochasticLightcuts(settings) => {
            let cuts = cuts(scene, settings, tree);
            let slots = gpu.buffer("slots of cuts", cuts.slots * SLOT_BYTES)?;
            let params = DrawParams {
                number: cuts.most as u32,
                stride: cuts.stride as u32,
                ..DrawParams::default()
            };
            let path = if settings.real_time {
                "many-lights/stochastic_tile.wgsl"
            } else {
                "many-lights/stochastic.wgsl"
            };
            ("stochastic lightcuts", path, params, Some(slots), cuts.groups)
        }
        other => {
            return Err(LightsError::value(format!("{other:?}"), "draws no lights down a tree"));
        }
    };
    let uniform = gpu.uniform("draws", &params)?;
    let mut buffers = vec![&nodes.nodes, &nodes.starts, &nodes.ranges, &uniform];
    buffers.extend(&slots);
    let parts =
        Parts { pass, path, constants: &[], buffers: &buffers, evaluates_all: false, most_groups };
    let kernel = Kernel::new(scene, &parts)?;
    Ok(Box::new(Sampler { scene: Arc::clone(scene), kernel, params, uniform }))
}

/// Where cuts lie.
struct Cuts {
    /// Most nodes of a cut.
    most: u64,
    slots: u64,
    stride: u64,
    /// Workgroups that share out the tiles; `None` where each tile has its own.
    groups: Option<u32>,
}

fn cuts(scene: &Scene<'_>, settings: &StochasticLightcuts, tree: &LightTree) -> Cuts {
    let limits = scene.gpu.limits();
    // No cut has more nodes than the tree; roots are members of it even beyond its most.
    let most = u64::from(settings.cut).min(tree.nodes.len().max(1) as u64);
    let column = most.max(tree.roots.len() as u64) + SPARE;
    let tiles = scene.most_tiles().max(1);
    if settings.real_time {
        return Cuts { most, slots: tiles * column, stride: column, groups: None };
    }
    let budget = STATE_BYTES.min(limits.max_storage_buffer_binding_size);
    let greatest = u64::from(limits.max_compute_workgroups_per_dimension).min(tiles);
    let groups = (budget / (LANES * SLOT_BYTES * column)).min(greatest).max(1);
    let stride = groups * LANES;
    Cuts { most, slots: stride * column, stride, groups: Some(groups as u32) }
}

impl Lighting for Sampler<'_> {
    fn reset(&mut self, seed: u32) -> Result<(), LightsError> {
        self.params.seed = seed;
        let bytes = bytemuck::bytes_of(&self.params);
        self.scene.gpu.queue.write_buffer(&self.uniform, 0, bytes);
        self.kernel.reset(seed)
    }

    fn shade(&mut self, index: usize, count: bool) -> Result<Times, LightsError> {
        self.kernel.shade(index, count)
    }

    fn read(&mut self, shaded: &mut Shaded) -> Result<(), LightsError> {
        self.kernel.read(shaded)?;
        // The second number that these kernels count is that of lights drawn by chance, and every
        // node that they look at is bounded.
        let work = &mut shaded.work;
        (work.samples, work.bounds, work.clusters) = (work.bounds, work.visits, 0);
        Ok(())
    }

    fn bytes(&self) -> u64 {
        self.kernel.bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_has_the_layout_of_the_shaders() {
        for file in ["light_bvh", "stochastic", "stochastic_tile"] {
            let fields = [("seed", 0), ("number", 4), ("stride", 8), ("pad", 12)];
            let path = format!("many-lights/{file}.wgsl");
            crate::gpu::mirror::<DrawParams>(&path, "DrawParams", &fields);
        }
    }
}
