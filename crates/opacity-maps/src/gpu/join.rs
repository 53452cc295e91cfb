//! The pass that brings what routes to the bounds leave into one form.

use bytemuck::{Pod, Zeroable};
use dapple_gpu::bindings::whole;
use dapple_gpu::{Frame, Gpu, GpuError, wgpu};

/// Mirrors `JoinParams` of `opacity-maps/join_bounds.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct JoinParams {
    width: u32,
    height: u32,
    mirrored: u32,
    pad: u32,
}

/// The pass "bounds-join".
#[derive(Debug)]
pub(super) struct Join {
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    workgroups: [u32; 2],
}

impl Join {
    /// From (1 - first, last) of each texel as bits.
    pub fn of_words(
        gpu: &Gpu,
        [width, height]: [u32; 2],
        view: &wgpu::TextureView,
        words: &wgpu::Buffer,
    ) -> Result<Self, GpuError> {
        let params = JoinParams { width, height, mirrored: 0, pad: 0 };
        let view = wgpu::BindingResource::TextureView(view);
        Self::new(gpu, "join_words", &params, &[(1, view), (4, whole(words))])
    }

    /// From a map of the nearest depths and one of the farthest, which may hold 1 - depth.
    pub fn of_depths(
        gpu: &Gpu,
        [width, height]: [u32; 2],
        view: &wgpu::TextureView,
        [near, far]: &[wgpu::TextureView; 2],
        mirrored: bool,
    ) -> Result<Self, GpuError> {
        let params = JoinParams { width, height, mirrored: u32::from(mirrored), pad: 0 };
        let texture = wgpu::BindingResource::TextureView;
        let resources = [(1, texture(view)), (2, texture(near)), (3, texture(far))];
        Self::new(gpu, "join_depths", &params, &resources)
    }

    fn new(
        gpu: &Gpu,
        entry: &str,
        params: &JoinParams,
        resources: &[(u32, wgpu::BindingResource<'_>)],
    ) -> Result<Self, GpuError> {
        let workgroups = [params.width.div_ceil(64), params.height];
        let max = gpu.limits().max_compute_workgroups_per_dimension;
        if let Some(&asked) = workgroups.iter().find(|&&n| n > max) {
            return Err(GpuError::TooLarge {
                what: "bounds".into(),
                asked: asked.into(),
                limit: "max_compute_workgroups_per_dimension",
                max: max.into(),
            });
        }
        let pipeline = gpu.compute("opacity-maps/join_bounds.wgsl", entry, &[])?;
        let params = gpu.uniform("bounds join", params)?;
        let params = [(0, whole(&params))];
        let entries: Vec<_> = params
            .iter()
            .chain(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry {
                binding: *binding,
                resource: resource.clone(),
            })
            .collect();
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(entry),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        Ok(Self { pipeline, group, workgroups })
    }

    /// Records the pass.
    pub fn record(&self, frame: &mut Frame<'_>) {
        let [x, y] = self.workgroups;
        frame.compute("bounds-join", |pass| {
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &self.group, &[]);
            pass.dispatch_workgroups(x, y, 1);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_has_the_layout_of_the_shader() {
        crate::gpu::mirror::<JoinParams>(
            "opacity-maps/join_bounds.wgsl",
            "JoinParams",
            &[("width", 0), ("height", 4), ("mirrored", 8), ("pad0", 12)],
        );
    }
}
