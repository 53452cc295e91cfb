//! How long a frame's passes take on the device.

use crate::OcclusionError;
use dapple_gpu::{FrameTimes, Gpu, GpuError, TimestampFault, wgpu};
use std::time::Instant;

/// Timed passes of a frame; those beyond leave the frame without device times.
const MOST_PASSES: u32 = wgpu::QUERY_SET_MAX_QUERIES / 2;

/// Stamps of a frame's passes.
#[derive(Debug)]
pub(super) struct Times {
    /// None where the device has no sound timestamps.
    stamps: Option<Stamps>,
    /// Names of the frame's passes.
    names: Vec<&'static str>,
    start: Instant,
}

#[derive(Debug)]
struct Stamps {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
}

impl Times {
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let make = || {
            gpu.scoped("timestamps", || Stamps {
                queries: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                    label: Some("timestamps"),
                    ty: wgpu::QueryType::Timestamp,
                    count: 2 * MOST_PASSES,
                }),
                resolved: gpu.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("timestamps"),
                    size: u64::from(2 * MOST_PASSES) * 8,
                    usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                    mapped_at_creation: false,
                }),
            })
        };
        let stamps = gpu.abilities.timestamps.then(make).transpose()?;
        Ok(Self { stamps, names: Vec::new(), start: Instant::now() })
    }

    /// Starts a frame.
    pub fn begin(&mut self) {
        self.names.clear();
        self.start = Instant::now();
    }

    /// Books a pass.
    pub fn pass(&mut self, name: &'static str) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        let first = 2 * self.names.len() as u32;
        self.names.push(name);
        let stamps = self.stamps.as_ref().filter(|_| first < 2 * MOST_PASSES)?;
        Some(wgpu::RenderPassTimestampWrites {
            query_set: &stamps.queries,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        })
    }

    /// Records the end of the frame.
    pub fn end(&self, encoder: &mut wgpu::CommandEncoder) {
        let count = 2 * (self.names.len() as u32).min(MOST_PASSES);
        if let Some(stamps) = self.stamps.as_ref().filter(|_| count > 0) {
            encoder.resolve_query_set(&stamps.queries, 0..count, &stamps.resolved, 0);
        }
    }

    /// Waits for the frame, then sums the passes of each name.
    pub fn read(&self, gpu: &Gpu) -> Result<FrameTimes, OcclusionError> {
        gpu.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|e| GpuError::DeviceLost(format!("frame: {e}")))?;
        gpu.check()?;
        let wall_ns = self.start.elapsed().as_nanos() as u64;
        let none = FrameTimes { passes: Vec::new(), gpu_ns: None, wall_ns, fault: None };
        let Some(stamps) = &self.stamps else { return Ok(none) };
        if self.names.len() as u32 > MOST_PASSES {
            return Ok(none);
        }
        let ticks = gpu.read::<u64>(&stamps.resolved, 0, 2 * self.names.len())?;
        Ok(summed(&self.names, &ticks, f64::from(gpu.queue.get_timestamp_period()), none))
    }
}

/// The passes of each name as one, in the order in which names first occur.
fn summed(
    names: &[&'static str],
    ticks: &[u64],
    period_ns: f64,
    mut times: FrameTimes,
) -> FrameTimes {
    for (&pass, stamp) in names.iter().zip(ticks.chunks_exact(2)) {
        let (begin, end) = (stamp[0], stamp[1]);
        // A pass may be shorter than a tick; its end is never before its beginning.
        if end < begin {
            times.passes.clear();
            times.fault = Some(TimestampFault { pass, begin, end });
            return times;
        }
        let ns = ((end - begin) as f64 * period_ns).round() as u64;
        match times.passes.iter_mut().find(|(name, _)| *name == pass) {
            Some((_, sum)) => *sum += ns,
            None => times.passes.push((pass, ns)),
        }
    }
    times.gpu_ns = Some(times.passes.iter().map(|(_, ns)| ns).sum()).filter(|ns| *ns > 0);
    times
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_of_a_name_are_summed() {
        let none = FrameTimes { passes: Vec::new(), gpu_ns: None, wall_ns: 9, fault: None };
        let names = ["draw", "query", "draw"];
        let times = summed(&names, &[10, 20, 20, 25, 30, 33], 2.0, none.clone());
        assert_eq!(times.passes, [("draw", 26), ("query", 10)]);
        assert_eq!((times.gpu_ns, times.wall_ns, times.fault), (Some(36), 9, None));
        let times = summed(&names, &[10, 20, 25, 24, 30, 33], 2.0, none.clone());
        assert_eq!((times.passes, times.gpu_ns), (Vec::new(), None));
        let fault = TimestampFault { pass: "query", begin: 25, end: 24 };
        assert_eq!(times.fault, Some(fault));
        // No time at all is no measurement.
        assert_eq!(summed(&names, &[7; 6], 2.0, none).gpu_ns, None);
    }
}
