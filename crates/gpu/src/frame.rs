//! One frame: named passes recorded into one submission, timed pass by pass.

use std::time::Instant;

use serde::Serialize;

use crate::device::lock;
use crate::{Gpu, GpuError};

/// Most passes a frame can time.
pub const MAX_PASSES: u32 = 512;

/// Bytes of one timestamp.
const STAMP: u64 = 8;

/// The query set of a frame with its resolve and read-back buffers; pooled in [`Gpu`].
#[derive(Debug)]
pub(crate) struct TimestampPool {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    staging: wgpu::Buffer,
}

impl TimestampPool {
    fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let bytes = u64::from(2 * MAX_PASSES) * STAMP;
        let usage = wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC;
        let resolved = gpu.create("timestamps", bytes, usage, false)?;
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let staging = gpu.create("timestamps read-back", bytes, usage, false)?;
        let queries = gpu.scoped("timestamp queries", || {
            gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("timestamps"),
                ty: wgpu::QueryType::Timestamp,
                count: 2 * MAX_PASSES,
            })
        })?;
        Ok(TimestampPool { queries, resolved, staging })
    }
}

/// What a raster pass draws to.
#[derive(Debug, Default)]
pub struct Targets<'a> {
    /// Colour attachments, in the order of the fragment shader's locations.
    pub colour: &'a [Option<wgpu::RenderPassColorAttachment<'a>>],
    /// Depth and stencil attachment.
    pub depth: Option<wgpu::RenderPassDepthStencilAttachment<'a>>,
    /// Where occlusion queries of this pass are written.
    pub occlusion: Option<&'a wgpu::QuerySet>,
}

impl<'a> Targets<'a> {
    /// A colour attachment that starts as `clear` and is kept.
    pub fn cleared(
        view: &'a wgpu::TextureView,
        clear: wgpu::Color,
    ) -> Option<wgpu::RenderPassColorAttachment<'a>> {
        Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(clear), store: wgpu::StoreOp::Store },
        })
    }

    /// A depth attachment that starts as `clear` and is kept.
    pub fn cleared_depth(
        view: &'a wgpu::TextureView,
        clear: f32,
    ) -> Option<wgpu::RenderPassDepthStencilAttachment<'a>> {
        Some(wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(clear),
                store: wgpu::StoreOp::Store,
            }),
            stencil_ops: None,
        })
    }
}

/// A pass whose end is not after its beginning, although the adapter's timestamps passed their
/// probe.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, thiserror::Error)]
#[error("pass `{pass}` begins at {begin} ns and ends at {end} ns")]
pub struct TimestampFault {
    /// The pass.
    pub pass: &'static str,
    /// Its first timestamp, ns.
    pub begin: u64,
    /// Its second timestamp, ns.
    pub end: u64,
}

/// How long a frame took.
///
/// A pass of zero or negative duration is no measurement: then `passes` is empty, `gpu_ns` is
/// `None` and `fault` says which pass it was. Where the adapter's timestamps are unsound or
/// absent, `passes` is empty, `gpu_ns` is `None` and there is no fault.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FrameTimes {
    /// Name and duration (ns) of each pass, in order.
    pub passes: Vec<(&'static str, u64)>,
    /// Sum over `passes`, ns.
    pub gpu_ns: Option<u64>,
    /// From [`Gpu::frame`] until the device has finished, ns; reading the timestamps is not in it.
    pub wall_ns: u64,
    /// A duration that cannot be.
    pub fault: Option<TimestampFault>,
}

/// A frame being recorded. Dropping it without [`Frame::finish`] submits nothing.
#[derive(Debug)]
pub struct Frame<'g> {
    gpu: &'g Gpu,
    encoder: wgpu::CommandEncoder,
    names: Vec<&'static str>,
    pool: Option<TimestampPool>,
    failed: Option<GpuError>,
    start: Instant,
}

impl Gpu {
    /// Starts a frame. Its query set and buffers come from a pool and go back to it.
    pub fn frame(&self) -> Frame<'_> {
        let start = Instant::now();
        let mut failed = None;
        let pool = if self.abilities.timestamps {
            let pooled = lock(&self.pools).pop();
            match pooled.map_or_else(|| TimestampPool::new(self), Ok) {
                Ok(pool) => Some(pool),
                Err(error) => {
                    failed = Some(error);
                    None
                }
            }
        } else {
            None
        };
        let encoder = self.device.create_command_encoder(&Default::default());
        Frame { gpu: self, encoder, names: Vec::with_capacity(16), pool, failed, start }
    }
}

impl Drop for Frame<'_> {
    fn drop(&mut self) {
        lock(&self.gpu.pools).extend(self.pool.take());
    }
}

impl Frame<'_> {
    /// Records a timed compute pass.
    pub fn compute(&mut self, name: &'static str, record: impl FnOnce(&mut wgpu::ComputePass<'_>)) {
        let queries = self.begin(name);
        let mut pass = self.encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(name),
            timestamp_writes: queries.and_then(|first| {
                let query_set = &self.pool.as_ref()?.queries;
                Some(wgpu::ComputePassTimestampWrites {
                    query_set,
                    beginning_of_pass_write_index: Some(first),
                    end_of_pass_write_index: Some(first + 1),
                })
            }),
        });
        record(&mut pass);
    }

    /// Records a timed raster pass.
    pub fn raster(
        &mut self,
        name: &'static str,
        targets: Targets<'_>,
        record: impl FnOnce(&mut wgpu::RenderPass<'_>),
    ) {
        let queries = self.begin(name);
        let mut pass = self.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(name),
            color_attachments: targets.colour,
            depth_stencil_attachment: targets.depth,
            timestamp_writes: queries.and_then(|first| {
                let query_set = &self.pool.as_ref()?.queries;
                Some(wgpu::RenderPassTimestampWrites {
                    query_set,
                    beginning_of_pass_write_index: Some(first),
                    end_of_pass_write_index: Some(first + 1),
                })
            }),
            occlusion_query_set: targets.occlusion,
            multiview_mask: None,
        });
        record(&mut pass);
    }

    /// The encoder between passes, for copies and clears: untimed on the device's clock.
    pub fn encoder(&mut self) -> &mut wgpu::CommandEncoder {
        &mut self.encoder
    }

    /// Records copies, clears and other encoder commands as a timed section.
    pub fn copies(&mut self, name: &'static str, record: impl FnOnce(&mut wgpu::CommandEncoder)) {
        let queries = self.begin(name);
        self.stamp(queries);
        record(&mut self.encoder);
        self.stamp(queries.map(|first| first + 1));
    }

    /// Submits, waits, and reads the timestamps.
    ///
    /// # Errors
    /// Whatever was wrong with a recorded command, [`GpuError::DeviceLost`],
    /// [`GpuError::Timeout`], or [`GpuError::TooLarge`] for more than [`MAX_PASSES`]; an earlier
    /// error that no call reported, as [`Gpu::check`].
    pub fn finish(mut self) -> Result<FrameTimes, GpuError> {
        let (stamps, wall_ns) = self.submit()?;
        if self.pool.is_none() {
            return Ok(FrameTimes { passes: Vec::new(), gpu_ns: None, wall_ns, fault: None });
        }
        Ok(durations(&self.names, &stamps, wall_ns))
    }

    /// [`Frame::finish`] with the stamps as they come: begin and end of each pass, ns, and the
    /// wall time.
    pub(crate) fn finish_stamps(mut self) -> Result<(Vec<u64>, u64), GpuError> {
        self.submit()
    }

    fn submit(&mut self) -> Result<(Vec<u64>, u64), GpuError> {
        if let Some(error) = self.failed.take() {
            return Err(error);
        }
        let gpu = self.gpu;
        let count = 2 * self.names.len() as u32;
        let bytes = u64::from(count) * STAMP;
        if let Some(pool) = self.pool.as_ref().filter(|_| count > 0) {
            self.encoder.resolve_query_set(&pool.queries, 0..count, &pool.resolved, 0);
            self.encoder.copy_buffer_to_buffer(&pool.resolved, 0, &pool.staging, 0, bytes);
        }
        let submission = gpu.scoped("frame", || {
            // `finish` takes the encoder by value; an empty one stays behind.
            let empty = gpu.device.create_command_encoder(&Default::default());
            let encoder = std::mem::replace(&mut self.encoder, empty);
            gpu.queue.submit([encoder.finish()])
        })?;
        gpu.wait("frame", submission.clone())?;
        let wall_ns = self.start.elapsed().as_nanos() as u64;
        gpu.check()?;
        let Some(pool) = self.pool.as_ref().filter(|_| count > 0) else {
            return Ok((Vec::new(), wall_ns));
        };
        let period = f64::from(gpu.queue.get_timestamp_period());
        let stamps = gpu.read_mapped(&pool.staging, submission, |mapped| {
            let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&mapped[..bytes as usize]);
            ticks.into_iter().map(|ticks| to_ns(ticks, period)).collect()
        })?;
        Ok((stamps, wall_ns))
    }

    /// Writes query `query` here, between passes.
    fn stamp(&mut self, query: Option<u32>) {
        let (Some(query), Some(pool)) = (query, self.pool.as_ref()) else { return };
        let features = self.gpu.device.features();
        if features.contains(wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS) {
            self.encoder.write_timestamp(&pool.queries, query);
        } else {
            // An empty pass carries the stamp where the encoder itself cannot.
            self.encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some("timestamp"),
                timestamp_writes: Some(wgpu::ComputePassTimestampWrites {
                    query_set: &pool.queries,
                    beginning_of_pass_write_index: Some(query),
                    end_of_pass_write_index: None,
                }),
            });
        }
    }

    /// Books a pass; the first of its two queries where passes are timed.
    fn begin(&mut self, name: &'static str) -> Option<u32> {
        let index = self.names.len() as u32;
        if index >= MAX_PASSES {
            self.failed.get_or_insert(GpuError::TooLarge {
                what: format!("frame, at pass `{name}`"),
                asked: u64::from(index) + 1,
                limit: "MAX_PASSES",
                max: u64::from(MAX_PASSES),
            });
            return None;
        }
        self.names.push(name);
        self.pool.as_ref().map(|_| 2 * index)
    }
}

/// Ticks of `period` ns each as ns, to the nearest. A 64-bit float would lose nanoseconds of a
/// clock that has run for more than 104 days.
fn to_ns(ticks: u64, period: f64) -> u64 {
    const FRACTION: u32 = 32;
    let fixed = (period * (1u64 << FRACTION) as f64).round() as u128;
    ((u128::from(ticks) * fixed) >> FRACTION) as u64
}

/// Durations from begin and end stamps in ns, two a pass.
fn durations(names: &[&'static str], stamps: &[u64], wall_ns: u64) -> FrameTimes {
    let mut passes = Vec::with_capacity(names.len());
    for (&pass, stamp) in names.iter().zip(stamps.chunks_exact(2)) {
        let (begin, end) = (stamp[0], stamp[1]);
        if end <= begin {
            let fault = Some(TimestampFault { pass, begin, end });
            return FrameTimes { passes: Vec::new(), gpu_ns: None, wall_ns, fault };
        }
        passes.push((pass, end - begin));
    }
    let gpu_ns = Some(passes.iter().map(|(_, ns)| ns).sum());
    FrameTimes { passes, gpu_ns, wall_ns, fault: None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_differences_of_stamps() {
        let times = durations(&["a", "b"], &[200, 300, 320, 330], 1000);
        assert_eq!(times.passes, [("a", 100), ("b", 10)]);
        assert_eq!(times.gpu_ns, Some(110));
        assert_eq!((times.wall_ns, times.fault), (1000, None));
        assert_eq!(durations(&[], &[], 5).gpu_ns, Some(0));
    }

    #[test]
    fn a_zero_or_negative_duration_is_a_fault_and_no_time() {
        for (begin, end) in [(150, 150), (160, 150)] {
            let times = durations(&["a", "b"], &[100, 150, begin, end], 1000);
            assert_eq!(times.gpu_ns, None);
            assert_eq!(times.passes, []);
            assert_eq!(times.fault, Some(TimestampFault { pass: "b", begin, end }));
        }
    }

    #[test]
    fn ticks_become_nanoseconds_without_loss_at_large_counts() {
        assert_eq!(to_ns(7, 1.0), 7);
        assert_eq!(to_ns(10, 0.5), 5);
        assert_eq!(to_ns(3, 83.333_333_333), 249);
        // 2^60 ns are 36 years: neighbours stay apart.
        assert_eq!(to_ns((1 << 60) + 1, 1.0) - to_ns(1 << 60, 1.0), 1);
    }
}
