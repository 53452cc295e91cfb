//! One dispatch with its bindings.

use dapple_gpu::{Gpu, wgpu};

use super::super::PartitionError;

/// How many workgroups run.
enum Grid {
    Direct([u32; 3]),
    /// Read from a buffer at this byte offset.
    Indirect(wgpu::Buffer, u64),
}

/// A pipeline, its bind group and its grid.
pub(super) struct Stage {
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    grid: Grid,
}

impl Stage {
    /// Over `items` with `size` of them a workgroup; at least one workgroup runs, because an
    /// empty pass has no duration to measure.
    pub(super) fn over(
        gpu: &Gpu,
        path: &str,
        entry: &str,
        buffers: &[&wgpu::Buffer],
        items: u64,
        size: u64,
    ) -> Result<Self, PartitionError> {
        let grid = Grid::Direct(gpu.workgroups(items.max(1), size as u32)?);
        Self::new(gpu, path, entry, buffers, grid)
    }

    /// Over the grid that an earlier stage writes to `arguments`.
    pub(super) fn indirect(
        gpu: &Gpu,
        path: &str,
        entry: &str,
        buffers: &[&wgpu::Buffer],
        arguments: (&wgpu::Buffer, u64),
    ) -> Result<Self, PartitionError> {
        let grid = Grid::Indirect(arguments.0.clone(), arguments.1);
        Self::new(gpu, path, entry, buffers, grid)
    }

    fn new(
        gpu: &Gpu,
        path: &str,
        entry: &str,
        buffers: &[&wgpu::Buffer],
        grid: Grid,
    ) -> Result<Self, PartitionError> {
        let pipeline = gpu.compute(path, entry, &[])?;
        let group = gpu.bind(&pipeline, 0, buffers);
        gpu.check()?;
        Ok(Self { pipeline, group, grid })
    }

    pub(super) fn record(&self, pass: &mut wgpu::ComputePass<'_>) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        match &self.grid {
            Grid::Direct([x, y, z]) => pass.dispatch_workgroups(*x, *y, *z),
            Grid::Indirect(buffer, offset) => pass.dispatch_workgroups_indirect(buffer, *offset),
        }
    }
}
