//! Buffers: limits checked before creation, contents poisoned, read-back.

use bytemuck::Pod;
use wgpu::BufferUsages as Usage;

use crate::{Gpu, GpuError, device::WAIT};

/// Every byte of a new buffer: as f32 -2.9e-16, as u32 2,779,096,485, so that an unwritten word
/// stands out in any result.
pub const POISON: u8 = 0xA5;

/// Size of the buffer that poison is copied from.
const POISON_CHUNK: u64 = 1 << 20;

/// What [`Gpu::buffer`] and [`Gpu::upload`] can be used as.
const GENERAL: Usage = Usage::STORAGE
    .union(Usage::COPY_SRC)
    .union(Usage::COPY_DST)
    .union(Usage::INDIRECT)
    .union(Usage::INDEX)
    .union(Usage::VERTEX);

/// Smallest buffer: a storage binding must hold one element, of at most 16 bytes here.
const SMALLEST: u64 = 16;

impl Gpu {
    /// A buffer of at least `bytes` (rounded up to 4, never under 16), filled with [`POISON`].
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] with the limit's name, [`GpuError::OutOfMemory`].
    pub fn buffer(&self, label: &str, bytes: u64) -> Result<wgpu::Buffer, GpuError> {
        check_size(label, rounded(bytes), GENERAL, &self.limits())?;
        let buffer = self.create(label, bytes, GENERAL, false)?;
        self.poison(&buffer);
        Ok(buffer)
    }

    /// A buffer that holds `data`, padded with poison to 16 bytes and to a multiple of 4.
    ///
    /// # Errors
    /// As [`Gpu::buffer`].
    pub fn upload<T: Pod>(&self, label: &str, data: &[T]) -> Result<wgpu::Buffer, GpuError> {
        self.filled(label, bytemuck::cast_slice(data), GENERAL)
    }

    /// A uniform buffer that holds `value`.
    ///
    /// # Errors
    /// As [`Gpu::buffer`].
    pub fn uniform<T: Pod>(&self, label: &str, value: &T) -> Result<wgpu::Buffer, GpuError> {
        self.filled(label, bytemuck::bytes_of(value), Usage::UNIFORM | Usage::COPY_DST)
    }

    /// Fills a buffer (one that can be copied to) with [`POISON`].
    pub fn poison(&self, buffer: &wgpu::Buffer) {
        let mut encoder = self.device.create_command_encoder(&Default::default());
        self.record_poison(&mut encoder, buffer);
        self.queue.submit([encoder.finish()]);
    }

    fn record_poison(&self, encoder: &mut wgpu::CommandEncoder, buffer: &wgpu::Buffer) {
        let Some(source) = &self.poison_source else { return };
        let mut at = 0;
        while at < buffer.size() {
            let bytes = POISON_CHUNK.min(buffer.size() - at);
            encoder.copy_buffer_to_buffer(source, 0, buffer, at, bytes);
            at += bytes;
        }
    }

    /// Reads `count` values from byte `offset` on; waits for all work submitted before.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] beyond the buffer's end, [`GpuError::Map`],
    /// [`GpuError::DeviceLost`], [`GpuError::Timeout`].
    pub fn read<T: Pod>(
        &self,
        buffer: &wgpu::Buffer,
        offset: u64,
        count: usize,
    ) -> Result<Vec<T>, GpuError> {
        let bytes = (count as u64).saturating_mul(size_of::<T>() as u64);
        let end = offset.saturating_add(bytes);
        if end > buffer.size() {
            return Err(GpuError::TooLarge {
                what: "read-back".into(),
                asked: end,
                limit: "size of the buffer read",
                max: buffer.size(),
            });
        }
        if bytes == 0 {
            return Ok(Vec::new());
        }
        // Copies start and end at multiples of 4.
        let start = offset & !3;
        let size = (end - start).next_multiple_of(4);
        let staging = self.create("read-back", size, Usage::MAP_READ | Usage::COPY_DST, false)?;
        let submission = self.scoped("read-back", || {
            let mut encoder = self.device.create_command_encoder(&Default::default());
            encoder.copy_buffer_to_buffer(buffer, start, &staging, 0, size);
            self.queue.submit([encoder.finish()])
        })?;
        let skip = (offset - start) as usize;
        self.read_mapped(&staging, submission, |mapped| {
            bytemuck::pod_collect_to_vec(&mapped[skip..skip + bytes as usize])
        })
    }

    /// Maps `staging` once `submission` is done and hands its bytes to `take`.
    pub(crate) fn read_mapped<R>(
        &self,
        staging: &wgpu::Buffer,
        submission: wgpu::SubmissionIndex,
        take: impl FnOnce(&[u8]) -> R,
    ) -> Result<R, GpuError> {
        let fail = |message: String| GpuError::Map { what: "a read-back buffer".into(), message };
        let (sender, receiver) = std::sync::mpsc::channel();
        staging.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            // The receiver is gone only if this function has already returned an error.
            let _ = sender.send(result);
        });
        self.wait("read-back", submission)?;
        // Not `try_recv`: where two threads share the device, the other one's poll may still be
        // running our callback when our own wait returns.
        let mapped = receiver.recv_timeout(WAIT).map_err(|e| e.to_string());
        if let Err(message) = mapped.and_then(|result| result.map_err(|e| e.to_string())) {
            return Err(self.check().err().unwrap_or(fail(message)));
        }
        let view = staging.slice(..).get_mapped_range().map_err(|e| fail(e.to_string()))?;
        let result = take(&view);
        drop(view);
        staging.unmap();
        Ok(result)
    }

    /// A buffer of `bytes` at least, held only against the limits of creation: one that is not
    /// bound whole may pass those of bindings.
    pub(crate) fn create(
        &self,
        label: &str,
        bytes: u64,
        usage: Usage,
        mapped: bool,
    ) -> Result<wgpu::Buffer, GpuError> {
        let size = rounded(bytes);
        check_size(label, size, Usage::empty(), &self.limits())?;
        self.scoped(&format!("buffer `{label}` of {size} bytes"), || {
            self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: mapped,
            })
        })
    }

    fn filled(&self, label: &str, data: &[u8], usage: Usage) -> Result<wgpu::Buffer, GpuError> {
        let bytes = data.len() as u64;
        check_size(label, rounded(bytes), usage, &self.limits())?;
        let buffer = self.create(label, bytes, usage, true)?;
        let fail = |message| GpuError::Map { what: format!("buffer `{label}`"), message };
        {
            let mut view =
                buffer.slice(..).get_mapped_range_mut().map_err(|e| fail(e.to_string()))?;
            view.slice(..data.len()).copy_from_slice(data);
            let padding = vec![POISON; view.len() - data.len()];
            view.slice(data.len()..).copy_from_slice(&padding);
        }
        buffer.unmap();
        Ok(buffer)
    }
}

/// The buffer that [`Gpu::poison`] copies from.
pub(crate) fn poison_source(gpu: &Gpu) -> Result<wgpu::Buffer, GpuError> {
    gpu.filled("poison", &vec![POISON; POISON_CHUNK as usize], Usage::COPY_SRC)
}

/// The size that `bytes` asked for become.
fn rounded(bytes: u64) -> u64 {
    bytes.max(SMALLEST).checked_next_multiple_of(4).unwrap_or(u64::MAX)
}

/// Refuses a size over the limits that `usage` brings, naming the limit.
fn check_size(label: &str, size: u64, usage: Usage, limits: &wgpu::Limits) -> Result<(), GpuError> {
    let mut bounds = vec![("max_buffer_size", limits.max_buffer_size)];
    if usage.contains(Usage::STORAGE) {
        let max = limits.max_storage_buffer_binding_size;
        bounds.push(("max_storage_buffer_binding_size", max));
    }
    if usage.contains(Usage::UNIFORM) {
        let max = limits.max_uniform_buffer_binding_size;
        bounds.push(("max_uniform_buffer_binding_size", max));
    }
    for (limit, max) in bounds {
        if size > max {
            let what = format!("buffer `{label}`");
            return Err(GpuError::TooLarge { what, asked: size, limit, max });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_held_against_every_limit_of_their_usage() {
        let limits = wgpu::Limits {
            max_buffer_size: 1000,
            max_storage_buffer_binding_size: 500,
            max_uniform_buffer_binding_size: 100,
            ..Default::default()
        };
        let limit = |size, usage| match check_size("map", size, usage, &limits) {
            Err(GpuError::TooLarge { limit, .. }) => limit,
            Err(other) => panic!("{other}"),
            Ok(()) => "fits",
        };
        assert_eq!(limit(500, GENERAL), "fits");
        assert_eq!(limit(501, GENERAL), "max_storage_buffer_binding_size");
        assert_eq!(limit(1001, GENERAL), "max_buffer_size");
        assert_eq!(limit(101, Usage::UNIFORM), "max_uniform_buffer_binding_size");
        assert_eq!(limit(1000, Usage::MAP_READ), "fits");
    }
}
