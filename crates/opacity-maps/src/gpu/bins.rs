//! Layers by integer atomics: a fragment goes into one bin, a second pass sums the bins from the
//! light on. The same bits in any order, and one pass over the geometry for any number of layers.

use super::{
    OpacityGpuError,
    layers::Inputs,
    raster::Raster,
    stage::{Pipelines, Stage},
};
use bytemuck::{Pod, Zeroable};
use dapple_gpu::bindings::{Slot, bind, layout, whole};
use dapple_gpu::{Frame, Gpu, GpuError, wgpu};

/// Mirrors `PrefixParams` of `opacity-maps/prefix.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct PrefixParams {
    texels: u32,
    layers: u32,
    pad: [u32; 2],
}

/// Bins of Q12.20 thickness, one map after the other.
#[derive(Debug)]
pub(super) struct Bins {
    sums: wgpu::Buffer,
    overrun: wgpu::Buffer,
    pipelines: Pipelines,
    group: wgpu::BindGroup,
    prefix: wgpu::ComputePipeline,
    prefix_group: wgpu::BindGroup,
    workgroups: [u32; 3],
    texels: usize,
}

impl Bins {
    /// Allocates the bins of `layers` maps.
    pub fn new(
        gpu: &Gpu,
        raster: &Raster,
        layers: u32,
        inputs: &Inputs<'_>,
    ) -> Result<Self, OpacityGpuError> {
        let texels = u64::from(raster.width) * u64::from(raster.height);
        let sums = gpu.buffer("bins", 4 * texels * u64::from(layers))?;
        let overrun = gpu.buffer("overrun bins", 4 * texels)?;
        let slots = [Slot::Uniform, Slot::Floats, Slot::Read, Slot::Write, Slot::Write];
        let slots = layout(gpu, "bins", &slots);
        let params = gpu.uniform("layers", &inputs.placed.params)?;
        let bounds = wgpu::BindingResource::TextureView(inputs.bounds);
        let resources =
            [whole(&params), bounds, whole(inputs.table), whole(&sums), whole(&overrun)];
        let group = bind(gpu, &slots, &resources);
        let stage = Stage {
            path: super::layers::PATH,
            entry: "add_to_bin",
            constants: &inputs.placed.constants,
            pass: Some(&slots),
            targets: &[],
            depth: None,
            swapped: false,
            opaque_joins: true,
        };
        let pipelines = raster.pipelines(gpu, &stage)?;
        let prefix = gpu.compute("opacity-maps/prefix.wgsl", "prefix", &[])?;
        // The bins hold 4 bytes a texel: fewer than 2^32 of them.
        let sizes = PrefixParams { texels: texels as u32, layers, pad: [0; 2] };
        let sizes = gpu.uniform("prefix", &sizes)?;
        let prefix_group = gpu.bind(&prefix, 0, &[&sizes, &sums, &overrun]);
        let workgroups = gpu.workgroups(texels, 64)?;
        let texels = texels as usize;
        Ok(Self { sums, overrun, pipelines, group, prefix, prefix_group, workgroups, texels })
    }

    /// Records "opacity-clear", `name` and "prefix".
    pub fn record(&self, frame: &mut Frame<'_>, raster: &Raster, name: &'static str) {
        frame.copies("opacity-clear", |encoder| {
            encoder.clear_buffer(&self.sums, 0, None);
            encoder.clear_buffer(&self.overrun, 0, None);
        });
        let targets = raster.no_targets();
        frame.raster(name, targets, |pass| raster.draw(pass, &self.pipelines, &self.group));
        let [x, y, z] = self.workgroups;
        frame.compute("prefix", |pass| {
            pass.set_pipeline(&self.prefix);
            pass.set_bind_group(0, &self.prefix_group, &[]);
            pass.dispatch_workgroups(x, y, z);
        });
    }

    /// The sums, after [`Bins::record`].
    pub fn sums(&self) -> &wgpu::Buffer {
        &self.sums
    }

    /// Bytes of bins and of what notes those that ran over.
    pub fn bytes(&self) -> u64 {
        self.sums.size() + self.overrun.size()
    }

    /// Thickness up to and including each layer, one map after the other.
    pub fn read(&self, gpu: &Gpu, layers: usize) -> Result<Vec<Vec<f32>>, GpuError> {
        let words: Vec<u32> = gpu.read(&self.sums, 0, self.texels * layers)?;
        let map = |map: &[u32]| map.iter().map(|&w| w as f32 / 1_048_576.0).collect();
        Ok(words.chunks_exact(self.texels).map(map).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_has_the_layout_of_the_shader() {
        crate::gpu::mirror::<PrefixParams>(
            "opacity-maps/prefix.wgsl",
            "PrefixParams",
            &[("texels", 0), ("layers", 4), ("pad0", 8), ("pad1", 12)],
        );
    }
}
