//! The rival without kernels: extract on the CPU, upload every index.
//!
//! Based on: J. Gumbau Portalés, PhD thesis, Universitat Jaume I, 2011, §3.7: the CPU models it
//! compares with send their whole index list across the bus at each change.

use dapple_gpu::{Gpu, wgpu};

use super::super::cpu::{self, Threads};
use super::super::{Cells, Counters, DrawArgs, PartitionError, Ranges};
use super::{Guarded, check_draw};

/// Extracts on the CPU and uploads the result, frame after frame.
pub struct CpuUpload {
    cpu: cpu::Extractor,
    indices: Guarded,
    arguments: Guarded,
}

impl CpuUpload {
    /// Allocates for the worst case, every leaf kept, on host and device.
    ///
    /// # Errors
    /// Cells that do not validate; [`PartitionError::Gpu`] naming the limit for more leaves than
    /// the device binds.
    pub fn new(gpu: &Gpu, cells: &Cells, threads: Threads) -> Result<Self, PartitionError> {
        Ok(Self {
            cpu: cpu::Extractor::new(cells, threads)?,
            indices: Guarded::new(gpu, "uploaded indices", 6 * cells.leaf_ids.len())?,
            arguments: Guarded::new(gpu, "uploaded draw", 5)?,
        })
    }

    /// Extracts, and hands kept indices and draw arguments to the queue: they are on the device
    /// before the next submission runs.
    ///
    /// # Errors
    /// As [`cpu::Extractor::extract`].
    pub fn extract(
        &mut self,
        gpu: &Gpu,
        cells: &Cells,
        factors_q: &[u32],
    ) -> Result<(), PartitionError> {
        let view = self.cpu.extract(cells, factors_q)?;
        let total = view.offsets.last().copied().unwrap_or(0);
        gpu.queue.write_buffer(&self.indices.buffer, 0, bytemuck::cast_slice(view.indices));
        let draw = DrawArgs::of_leaves(0, total);
        gpu.queue.write_buffer(&self.arguments.buffer, 0, bytemuck::bytes_of(&draw));
        Ok(())
    }

    /// Draws the result of the last frame with the pass's pipeline, in one indirect draw.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_index_buffer(self.indices.buffer.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed_indirect(&self.arguments.buffer, 0);
    }

    /// Poisons every output on host and device.
    ///
    /// # Errors
    /// What the device says.
    pub fn reset(&mut self, gpu: &Gpu) -> Result<(), PartitionError> {
        self.cpu.reset();
        gpu.poison(&self.indices.buffer);
        gpu.poison(&self.arguments.buffer);
        gpu.check()?;
        Ok(())
    }

    /// The last frame's offsets from the host and its indices from the device, with all guards.
    ///
    /// # Errors
    /// Draw arguments that do not fit the total, or what the device says.
    pub fn read(&self, gpu: &Gpu) -> Result<Ranges, PartitionError> {
        let view = self.cpu.view();
        let mut guard = view.guards.concat();
        for output in [&self.indices, &self.arguments] {
            output.read_rest(gpu, output.words, &mut guard)?;
        }
        let words = self.arguments.read(gpu, 5)?;
        let total = view.offsets.last().copied().unwrap_or(0);
        check_draw(bytemuck::pod_read_unaligned(bytemuck::cast_slice(&words)), total)?;
        let indices = self.indices.read(gpu, view.indices.len())?;
        Ok(Ranges { offsets: view.offsets.to_vec(), indices, guard })
    }

    /// Work of the last frame on the host, and its upload: 24 bytes a kept leaf and 20 of draw
    /// arguments.
    #[must_use]
    pub fn counters(&self) -> Counters {
        let host = self.cpu.counters();
        let bytes = 24 * host.leaves_kept + size_of::<DrawArgs>() as u64;
        host.plus(Counters::uploaded(bytes))
    }
}
