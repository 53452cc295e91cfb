//! Pipelines and bind groups from the shaders of `dapple-shaders`.

use crate::{Gpu, GpuError, device::lock};

/// What tells one compute pipeline from another: path, entry point, bits of the constants.
pub(crate) type PipelineKey = (String, String, Vec<(String, u64)>);

impl Gpu {
    /// The shader `path` (under `shaders/`) as a module, validated by naga; made once a device.
    ///
    /// # Errors
    /// [`GpuError::Shader`] for an unknown or faulty file, [`GpuError::Validation`] where only
    /// this device refuses it.
    pub fn module(&self, path: &str) -> Result<wgpu::ShaderModule, GpuError> {
        if let Some(module) = lock(&self.modules).get(path) {
            return Ok(module.clone());
        }
        let source = dapple_shaders::source(path)?;
        dapple_shaders::validate(path, &source)?;
        let module = self.module_of(path, &source)?;
        lock(&self.modules).insert(path.into(), module.clone());
        Ok(module)
    }

    /// A module from WGSL text; `path` only names it.
    ///
    /// # Errors
    /// [`GpuError::Validation`].
    pub fn module_of(&self, path: &str, source: &str) -> Result<wgpu::ShaderModule, GpuError> {
        self.scoped(path, || {
            self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(path),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            })
        })
    }

    /// The compute pipeline of `entry` in `path`, with `constants` for its `override`s. Its
    /// layout holds the bindings that the entry point uses, and no others. Made once a device and
    /// set of constants: drivers compile at first use, which costs 0.1 s where it is in software.
    ///
    /// # Errors
    /// As [`Gpu::module`]; [`GpuError::Validation`] for an entry point or constant that is not
    /// there; [`GpuError::DeviceLost`] where the driver fails on it.
    pub fn compute(
        &self,
        path: &str,
        entry: &str,
        constants: &[(&str, f64)],
    ) -> Result<wgpu::ComputePipeline, GpuError> {
        let bits = constants.iter().map(|(name, value)| ((*name).into(), value.to_bits()));
        let key = (path.into(), entry.into(), bits.collect());
        if let Some(pipeline) = lock(&self.pipelines).get(&key) {
            return Ok(pipeline.clone());
        }
        let module = self.module(path)?;
        let pipeline = self.compute_of(&module, path, entry, constants)?;
        lock(&self.pipelines).insert(key, pipeline.clone());
        Ok(pipeline)
    }

    /// The same from a module; `path` only names it.
    ///
    /// # Errors
    /// [`GpuError::Validation`], [`GpuError::DeviceLost`].
    pub fn compute_of(
        &self,
        module: &wgpu::ShaderModule,
        path: &str,
        entry: &str,
        constants: &[(&str, f64)],
    ) -> Result<wgpu::ComputePipeline, GpuError> {
        let what = format!("{path}:{entry}");
        self.scoped(&what, || {
            self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(&what),
                layout: None,
                module,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants,
                    ..Default::default()
                },
                cache: None,
            })
        })
    }

    /// A raster pipeline; `what` names it in errors.
    ///
    /// # Errors
    /// [`GpuError::Validation`], [`GpuError::DeviceLost`].
    pub fn raster(
        &self,
        what: &str,
        descriptor: &wgpu::RenderPipelineDescriptor<'_>,
    ) -> Result<wgpu::RenderPipeline, GpuError> {
        self.scoped(what, || self.device.create_render_pipeline(descriptor))
    }

    /// Group `group` of a compute pipeline, binding i = the i-th buffer, each bound whole. The
    /// entry point must use every one of them. A mismatch is reported by [`Gpu::check`].
    pub fn bind(
        &self,
        pipeline: &wgpu::ComputePipeline,
        group: u32,
        buffers: &[&wgpu::Buffer],
    ) -> wgpu::BindGroup {
        self.bind_to(&pipeline.get_bind_group_layout(group), buffers)
    }

    /// The same for a raster pipeline.
    pub fn bind_raster(
        &self,
        pipeline: &wgpu::RenderPipeline,
        group: u32,
        buffers: &[&wgpu::Buffer],
    ) -> wgpu::BindGroup {
        self.bind_to(&pipeline.get_bind_group_layout(group), buffers)
    }

    fn bind_to(
        &self,
        layout: &wgpu::BindGroupLayout,
        buffers: &[&wgpu::Buffer],
    ) -> wgpu::BindGroup {
        let entries: Vec<_> = (0..)
            .zip(buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                // The size is spelled out: wgpu 30 makes VERTEX buffers a word longer, and an
                // entire binding lets arrayLength() see that word.
                resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                    buffer,
                    offset: 0,
                    size: std::num::NonZeroU64::new(buffer.size()),
                }),
            })
            .collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout,
            entries: &entries,
        })
    }

    /// Workgroups that cover `items` with `size` invocations each, in two dimensions where one
    /// would pass the device's limit. Kernels take their index from `common/index.wgsl` and
    /// return where it is beyond the end.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] where two dimensions do not suffice.
    pub fn workgroups(&self, items: u64, size: u32) -> Result<[u32; 3], GpuError> {
        grid(items, size, self.limits().max_compute_workgroups_per_dimension)
    }
}

fn grid(items: u64, size: u32, per_dimension: u32) -> Result<[u32; 3], GpuError> {
    let groups = items.div_ceil(u64::from(size.max(1)));
    let max = u64::from(per_dimension);
    let rows = groups.div_ceil(max.max(1));
    if rows > max {
        return Err(GpuError::TooLarge {
            what: format!("dispatch over {items} items"),
            asked: groups,
            limit: "max_compute_workgroups_per_dimension squared",
            max: max * max,
        });
    }
    // rows <= max and columns <= max, so both fit u32.
    let columns = if rows <= 1 { groups } else { groups.div_ceil(rows) };
    Ok([columns as u32, rows as u32, 1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_cover_all_items_and_stay_within_the_limit() {
        assert_eq!(grid(0, 64, 65_535), Ok([0, 0, 1]));
        assert_eq!(grid(1, 64, 65_535), Ok([1, 1, 1]));
        assert_eq!(grid(65, 64, 65_535), Ok([2, 1, 1]));
        assert_eq!(grid(65_535 * 64, 64, 65_535), Ok([65_535, 1, 1]));
        // One more group: 65,536 = 2 rows of 32,768.
        assert_eq!(grid(65_535 * 64 + 1, 64, 65_535), Ok([32_768, 2, 1]));
        assert_eq!(grid(9, 1, 3), Ok([3, 3, 1]));
        assert!(matches!(grid(10, 1, 3), Err(GpuError::TooLarge { asked: 10, max: 9, .. })));
    }
}
