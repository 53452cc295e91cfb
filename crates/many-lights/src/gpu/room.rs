//! Buffers whose end changes from frame to frame.

use dapple_gpu::{Gpu, GpuError, wgpu};

/// Writes `data`, of whole words, from byte `at` of a buffer on. Where that has no room for it, it
/// becomes another one with what lay before `at`, and room for twice as much behind; whether it did.
pub(super) fn put(
    gpu: &Gpu,
    label: &str,
    buffer: &mut wgpu::Buffer,
    at: u64,
    data: &[u8],
) -> Result<bool, GpuError> {
    let bytes = data.len() as u64;
    let grows = at + bytes > buffer.size();
    if grows {
        *buffer = with_room(gpu, label, buffer, at, bytes)?;
    }
    if bytes > 0 {
        gpu.queue.write_buffer(buffer, at, data);
    }
    Ok(grows)
}

/// A buffer with the first `at` bytes of another, and room for twice `bytes` behind.
pub(super) fn with_room(
    gpu: &Gpu,
    label: &str,
    buffer: &wgpu::Buffer,
    at: u64,
    bytes: u64,
) -> Result<wgpu::Buffer, GpuError> {
    let limits = gpu.limits();
    let most = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    let larger = gpu.buffer(label, (at + 2 * bytes).min(most).max(at + bytes))?;
    if at > 0 {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &larger, 0, at);
        gpu.queue.submit([encoder.finish()]);
    }
    Ok(larger)
}
