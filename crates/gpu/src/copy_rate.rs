//! The rate of a plain copy: the yardstick for the bandwidth of other kernels.

use crate::{FrameTimes, Gpu, GpuError};

/// Timed runs of each way of copying, after one that is not timed.
const RUNS: usize = 7;

/// A run moves at least this much, so that it is long against the ticks of the clock; a smaller
/// footprint is copied several times over, but not more often than this: below 1 MiB the rate is
/// that of dispatches, not of memory.
const LEAST_BYTES: u64 = 64 << 20;
const MOST_REPEATS: u64 = 64;

/// Bytes an invocation of the copy kernel moves, and invocations in its workgroup.
const ELEMENT: u64 = 16;
const WORKGROUP: u32 = 256;

/// The best rate, in bytes read plus bytes written a second, of a copy that touches `bytes` in
/// all: half read, half written.
///
/// Best of seven runs each by a compute kernel and by `copy_buffer_to_buffer`; device time where
/// timestamps are sound, wall time elsewhere.
///
/// # Errors
/// [`GpuError::TooLarge`] where half of `bytes` passes the device's `max_buffer_size`,
/// [`GpuError::OutOfMemory`], and as [`crate::Frame::finish`].
pub fn copy_rate(gpu: &Gpu, bytes: u64) -> Result<f64, GpuError> {
    let half = (bytes / 2).max(ELEMENT).next_multiple_of(ELEMENT);
    let usage =
        wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
    let from = gpu.create("copy source", half, usage, false)?;
    let to = gpu.create("copy target", half, usage, false)?;
    gpu.poison(&from);
    let repeats = LEAST_BYTES.div_ceil(2 * half).min(MOST_REPEATS);
    let moved = (2 * half * repeats) as f64;

    let pipeline = gpu.compute("gpu/copy.wgsl", "copy", &[])?;
    let groups = bind_pieces(gpu, &pipeline, &from, &to)?;
    let mut best = best_of(|| {
        let mut frame = gpu.frame();
        frame.compute("copy kernel", |pass| {
            pass.set_pipeline(&pipeline);
            for _ in 0..repeats {
                for (group, [x, y, z]) in &groups {
                    pass.set_bind_group(0, group, &[]);
                    pass.dispatch_workgroups(*x, *y, *z);
                }
            }
        });
        frame.finish()
    })?;
    best = best.min(best_of(|| {
        let mut frame = gpu.frame();
        frame.copies("copy buffer", |encoder| {
            for _ in 0..repeats {
                encoder.copy_buffer_to_buffer(&from, 0, &to, 0, half);
            }
        });
        frame.finish()
    })?);
    Ok(moved / best * 1e9)
}

/// Least time in ns of several runs.
fn best_of(mut run: impl FnMut() -> Result<FrameTimes, GpuError>) -> Result<f64, GpuError> {
    run()?;
    let mut best = f64::INFINITY;
    for _ in 0..RUNS {
        let times = run()?;
        best = best.min(times.gpu_ns.unwrap_or(times.wall_ns).max(1) as f64);
    }
    Ok(best)
}

/// A bind group and its dispatch for each piece that one binding can hold.
fn bind_pieces(
    gpu: &Gpu,
    pipeline: &wgpu::ComputePipeline,
    from: &wgpu::Buffer,
    to: &wgpu::Buffer,
) -> Result<Vec<(wgpu::BindGroup, [u32; 3])>, GpuError> {
    // Offsets of bindings are multiples of at most 256.
    let piece = (gpu.limits().max_storage_buffer_binding_size & !255).max(256);
    let layout = pipeline.get_bind_group_layout(0);
    let mut groups = Vec::new();
    let mut offset = 0;
    while offset < from.size() {
        let size = piece.min(from.size() - offset);
        let entry = |binding, buffer| wgpu::BindGroupEntry {
            binding,
            resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer,
                offset,
                size: std::num::NonZeroU64::new(size),
            }),
        };
        let group = gpu.scoped("copy kernel", || {
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: &layout,
                entries: &[entry(0, from), entry(1, to)],
            })
        })?;
        groups.push((group, gpu.workgroups(size / ELEMENT, WORKGROUP)?));
        offset += size;
    }
    Ok(groups)
}
