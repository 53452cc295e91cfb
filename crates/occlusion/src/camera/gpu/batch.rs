//! A batch of queries on the device, from boxes to counts.

use super::pipelines::Pipelines;
use super::settings::Counting;
use super::targets::Targets;
use super::times::Times;
use crate::OcclusionError;
use crate::camera::software::check;
use crate::camera::{Bounds, Query, View};
use bytemuck::{Pod, Zeroable};
use dapple_gpu::bindings::{bind, whole};
use dapple_gpu::{Gpu, GpuError, wgpu};
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::time::{Duration, Instant};
use wgpu::BufferUsages as Usage;

/// Corners of the twelve triangles of a box.
const CORNERS: u32 = 36;
/// Queries of one pass.
const PER_SET: usize = wgpu::QUERY_SET_MAX_QUERIES as usize;
/// Fewest boxes and queries that a slot is made for.
const SMALLEST: usize = 64;
/// How long a result may take after its submission has finished.
const WAIT: Duration = Duration::from_secs(120);

const PENDING: u8 = 0;
const MAPPED: u8 = 1;
const FAILED: u8 = 2;

/// Mirrors `Box` of `occlusion/boxes.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(super) struct QueryBox {
    low: [f32; 3],
    high: [f32; 3],
    query: u32,
}

/// The boxes of a batch in the order of its queries, a range of them each.
#[derive(Debug, Default)]
pub(super) struct Boxes {
    list: Vec<QueryBox>,
    ranges: Vec<Range<u32>>,
}

impl Boxes {
    /// Takes the boxes of `queries`, grown.
    pub fn fill(
        &mut self,
        view: &View,
        boxes: &[Bounds],
        queries: &[Query],
    ) -> Result<(), OcclusionError> {
        check::asked(boxes, queries)?;
        self.list.clear();
        self.ranges.clear();
        for (query, Query { boxes: range }) in (0..).zip(queries) {
            let asked = &boxes[range.start as usize..range.end as usize];
            let first = self.list.len() as u32;
            self.list.extend(asked.iter().map(|bounds| {
                let grown = view.guarded(bounds);
                QueryBox { low: grown.min.into(), high: grown.max.into(), query }
            }));
            self.ranges.push(first..self.list.len() as u32);
        }
        Ok(())
    }
}

/// What one batch needs on the device; reused when it has been collected.
#[derive(Debug)]
pub(super) struct Slot {
    /// Size of the targets that `depth` belongs to.
    generation: u64,
    most_boxes: usize,
    most_queries: usize,
    boxes: wgpu::Buffer,
    /// Group 1: view and boxes.
    list: wgpu::BindGroup,
    /// u64 a query where queries are resolved, u32 where fragments count.
    counts: wgpu::Buffer,
    /// Group 2, where fragments count.
    depth: Option<wgpu::BindGroup>,
    /// As many as the queries need; none where fragments count.
    sets: Vec<wgpu::QuerySet>,
    staging: wgpu::Buffer,
    state: Arc<AtomicU8>,
}

/// What slots are made for.
#[derive(Debug)]
pub(super) struct Pool {
    free: Vec<Slot>,
    most_boxes: usize,
    most_queries: usize,
    /// Counts the targets there have been.
    pub generation: u64,
    pub counting: Counting,
    pub slots_made: u64,
}

/// A batch under way.
#[derive(Debug)]
pub(super) struct Batch {
    slot: Slot,
    queries: usize,
    submission: wgpu::SubmissionIndex,
}

impl Pool {
    pub fn new(counting: Counting) -> Self {
        Self {
            free: Vec::new(),
            most_boxes: SMALLEST,
            most_queries: SMALLEST,
            generation: 0,
            counting,
            slots_made: 0,
        }
    }

    /// A slot for `boxes`: one that is free and large enough, or a new one in its place.
    pub fn take(
        &mut self,
        gpu: &Gpu,
        pipelines: &Pipelines,
        view: &wgpu::Buffer,
        targets: &Targets,
        boxes: &Boxes,
    ) -> Result<Slot, OcclusionError> {
        self.most_boxes = self.most_boxes.max(boxes.list.len().next_power_of_two());
        self.most_queries = self.most_queries.max(boxes.ranges.len().next_power_of_two());
        let fits = |slot: &Slot| {
            slot.generation == self.generation
                && slot.most_boxes >= boxes.list.len()
                && slot.most_queries >= boxes.ranges.len()
        };
        if let Some(place) = self.free.iter().position(fits) {
            return Ok(self.free.swap_remove(place));
        }
        self.free.pop();
        self.slots_made += 1;
        let depth = (self.counting == Counting::Atomic).then_some(&targets.depth_view);
        Ok(Slot::new(gpu, pipelines, view, depth, self)?)
    }

    pub fn give_back(&mut self, slot: Slot) {
        if slot.generation == self.generation {
            self.free.push(slot);
        }
    }
}

impl Slot {
    fn new(
        gpu: &Gpu,
        pipelines: &Pipelines,
        view: &wgpu::Buffer,
        depth: Option<&wgpu::TextureView>,
        pool: &Pool,
    ) -> Result<Self, GpuError> {
        let buffer = |label: &str, bytes: usize, usage| {
            let limits = gpu.limits();
            let (limit, max) = match depth {
                Some(_) => {
                    let max = limits.max_storage_buffer_binding_size;
                    ("max_storage_buffer_binding_size", max)
                }
                None => ("max_buffer_size", limits.max_buffer_size),
            };
            if bytes as u64 > max {
                let what = format!("buffer `{label}`");
                return Err(GpuError::TooLarge { what, asked: bytes as u64, limit, max });
            }
            gpu.scoped(label, || {
                gpu.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(label),
                    size: bytes as u64,
                    usage,
                    mapped_at_creation: false,
                })
            })
        };
        let count_bytes = if depth.is_some() { 4 } else { 8 } * pool.most_queries;
        let usage = match depth {
            Some(_) => Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST,
            None => Usage::QUERY_RESOLVE | Usage::COPY_SRC,
        };
        let boxes = gpu.buffer("query boxes", (size_of::<QueryBox>() * pool.most_boxes) as u64)?;
        let counts = buffer("query counts", count_bytes, usage)?;
        let staging =
            buffer("query counts read-back", count_bytes, Usage::MAP_READ | Usage::COPY_DST)?;
        let set = || {
            gpu.scoped("occlusion queries", || {
                gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                    label: Some("occlusion"),
                    ty: wgpu::QueryType::Occlusion,
                    count: pool.most_queries.min(PER_SET) as u32,
                })
            })
        };
        let sets = if depth.is_some() { 0 } else { pool.most_queries.div_ceil(PER_SET) };
        Ok(Self {
            generation: pool.generation,
            most_boxes: pool.most_boxes,
            most_queries: pool.most_queries,
            list: bind(gpu, &pipelines.list, &[whole(view), whole(&boxes)]),
            depth: depth.map(|depth| {
                let depth = wgpu::BindingResource::TextureView(depth);
                bind(gpu, &pipelines.counts, &[whole(&counts), depth])
            }),
            boxes,
            counts,
            sets: (0..sets).map(|_| set()).collect::<Result<_, _>>()?,
            staging,
            state: Arc::default(),
        })
    }

    /// Uploads the boxes and records what counts them; the number of passes.
    pub fn record(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        pipelines: &Pipelines,
        targets: &Targets,
        times: &mut Times,
        boxes: &Boxes,
    ) -> u64 {
        if boxes.ranges.is_empty() {
            return 0;
        }
        gpu.queue.write_buffer(&self.boxes, 0, bytemuck::cast_slice(&boxes.list));
        let mut passes = 0;
        let mut pass = |encoder: &mut wgpu::CommandEncoder, set, draw: &dyn Fn(&mut Pass<'_>)| {
            passes += 1;
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("query"),
                color_attachments: &[],
                depth_stencil_attachment: Some(targets.depth_read_only()),
                timestamp_writes: times.pass("query"),
                occlusion_query_set: set,
                multiview_mask: None,
            });
            pass.set_pipeline(&pipelines.boxes);
            pass.set_bind_group(1, &self.list, &[]);
            draw(&mut pass);
        };
        let per_count = if let Some(depth) = &self.depth {
            encoder.clear_buffer(&self.counts, 0, None);
            pass(encoder, None, &|pass| {
                pass.set_bind_group(2, depth, &[]);
                pass.draw(0..CORNERS, 0..boxes.list.len() as u32);
            });
            4
        } else {
            for (place, (ranges, set)) in (0..).zip(boxes.ranges.chunks(PER_SET).zip(&self.sets)) {
                pass(encoder, Some(set), &|pass| {
                    for (query, range) in (0..).zip(ranges) {
                        pass.begin_occlusion_query(query);
                        if !range.is_empty() {
                            pass.draw(0..CORNERS, range.clone());
                        }
                        pass.end_occlusion_query();
                    }
                });
                let to = place * (PER_SET as u64) * 8;
                encoder.resolve_query_set(set, 0..ranges.len() as u32, &self.counts, to);
            }
            8
        };
        let bytes = per_count * boxes.ranges.len() as u64;
        encoder.copy_buffer_to_buffer(&self.counts, 0, &self.staging, 0, bytes);
        passes
    }

    /// Asks for the counts of a batch that was submitted.
    pub fn submitted(self, boxes: &Boxes, submission: wgpu::SubmissionIndex) -> Batch {
        let state = Arc::clone(&self.state);
        state.store(PENDING, Ordering::Release);
        self.staging.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            let done = if result.is_ok() { MAPPED } else { FAILED };
            state.store(done, Ordering::Release);
        });
        Batch { slot: self, queries: boxes.ranges.len(), submission }
    }
}

type Pass<'a> = wgpu::RenderPass<'a>;

impl Batch {
    /// Whether the counts can be read without waiting.
    pub fn is_done(&self) -> bool {
        self.slot.state.load(Ordering::Acquire) != PENDING
    }

    /// Waits until they can.
    pub fn wait(&self, gpu: &Gpu) -> Result<(), GpuError> {
        const WHAT: &str = "occlusion queries";
        if !self.is_done() {
            gpu.wait(WHAT, self.submission.clone())?;
        }
        // Where two threads share the device, the other one's poll may still be running our
        // callback when our own wait returns.
        let start = Instant::now();
        while !self.is_done() {
            gpu.check()?;
            if start.elapsed() > WAIT {
                return Err(GpuError::Timeout { what: WHAT.into(), seconds: WAIT.as_secs() });
            }
            std::thread::yield_now();
        }
        if self.slot.state.load(Ordering::Acquire) == FAILED {
            gpu.check()?;
            let message = "could not be mapped".into();
            return Err(GpuError::Map { what: WHAT.into(), message });
        }
        Ok(())
    }

    /// Appends the counts of a batch that is done, and gives its slot back.
    pub fn read(self, counting: Counting, counts: &mut Vec<u32>) -> Result<Slot, GpuError> {
        let slot = self.slot;
        let fail = |message| GpuError::Map { what: "occlusion queries".into(), message };
        let mapped = slot.staging.slice(..).get_mapped_range().map_err(|e| fail(e.to_string()))?;
        if counting == Counting::Atomic {
            let found = mapped.chunks_exact(4).take(self.queries);
            counts.extend(found.map(bytemuck::pod_read_unaligned::<u32>));
        } else {
            let most = if counting == Counting::Boolean { 1 } else { u64::from(u32::MAX) };
            let found = mapped.chunks_exact(8).take(self.queries);
            counts.extend(found.map(|b| bytemuck::pod_read_unaligned::<u64>(b).min(most) as u32));
        }
        drop(mapped);
        slot.staging.unmap();
        Ok(slot)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_has_the_layout_of_the_shader() {
        let fields = [("low", 0), ("high", 12), ("query", 24)];
        crate::camera::gpu::mirror::<QueryBox>("occlusion/boxes.wgsl", "Box", &fields);
    }
}
