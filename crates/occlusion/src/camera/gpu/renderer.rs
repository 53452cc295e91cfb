//! Draws objects and answers queries on a graphics device.

use super::batch::{Batch, Boxes, Pool};
use super::draws::Plan;
use super::pipelines::{Pipelines, ViewParams};
use super::scene::Scene;
use super::settings::{Fault, Settings};
use super::targets::{Surface, Targets};
use super::times::Times;
use crate::OcclusionError;
use crate::camera::renderer::Renderer as Renders;
use crate::camera::software::check;
use crate::camera::{Bounds, Image, Latency, Query, Readiness, View};
use dapple_gpu::bindings::{bind, whole};
use dapple_gpu::{FrameTimes, Gpu, GpuError, wgpu};
use std::collections::VecDeque;
use std::time::Instant;

/// Most objects that the list holds before it first grows.
const FIRST_LIST: usize = 1024;

/// What a frame asked of the device, since [`Renders::begin`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Draw calls of objects.
    pub draw_calls: u64,
    /// Passes that drew objects.
    pub draw_passes: u64,
    /// Passes that asked queries.
    pub query_passes: u64,
    /// Submissions.
    pub submissions: u64,
    /// Collected batches that had to be waited for.
    pub waits: u64,
    /// Time of those waits, ns.
    pub waited_ns: u64,
}

/// Draws and answers; see [`Renders`].
#[derive(Debug)]
pub struct Renderer<'g> {
    gpu: &'g Gpu,
    scene: Scene,
    settings: Settings,
    pipelines: Pipelines,
    view_params: wgpu::Buffer,
    list: List,
    plan: Plan,
    boxes: Boxes,
    times: Times,
    /// Of the last view's size; none before the first frame.
    targets: Option<Targets>,
    view: Option<View>,
    /// Whether the targets are still to be cleared.
    fresh: bool,
    pool: Pool,
    batches: VecDeque<Batch>,
    latency: Latency,
    counters: Counters,
}

/// The list of objects drawn.
#[derive(Debug)]
struct List {
    buffer: wgpu::Buffer,
    /// Group 1: view and list.
    group: wgpu::BindGroup,
    most: usize,
}

impl List {
    fn new(
        gpu: &Gpu,
        pipelines: &Pipelines,
        view: &wgpu::Buffer,
        most: usize,
    ) -> Result<Self, GpuError> {
        let buffer = gpu.buffer("objects drawn", 4 * most as u64)?;
        let group = bind(gpu, &pipelines.list, &[whole(view), whole(&buffer)]);
        Ok(Self { buffer, group, most })
    }
}

impl<'g> Renderer<'g> {
    /// A renderer of `scene`.
    ///
    /// # Errors
    /// A way of counting that the device has not got; the device's.
    pub fn new(gpu: &'g Gpu, scene: &Scene, settings: Settings) -> Result<Self, OcclusionError> {
        Self::build(gpu, scene, settings, None)
    }

    /// The same with a deliberate fault, for what must find it.
    ///
    /// # Errors
    /// As [`Renderer::new`].
    pub fn with_fault(
        gpu: &'g Gpu,
        scene: &Scene,
        settings: Settings,
        fault: Fault,
    ) -> Result<Self, OcclusionError> {
        Self::build(gpu, scene, settings, Some(fault))
    }

    fn build(
        gpu: &'g Gpu,
        scene: &Scene,
        settings: Settings,
        fault: Option<Fault>,
    ) -> Result<Self, OcclusionError> {
        let counting = settings.counting.on(&gpu.abilities)?;
        let pipelines = Pipelines::new(gpu, &scene.layout, counting, fault)?;
        let view_params = gpu.uniform("view", &ViewParams::default())?;
        Ok(Self {
            list: List::new(gpu, &pipelines, &view_params, FIRST_LIST)?,
            times: Times::new(gpu)?,
            gpu,
            scene: scene.clone(),
            settings: Settings { counting, ..settings },
            pipelines,
            view_params,
            plan: Plan::default(),
            boxes: Boxes::default(),
            targets: None,
            view: None,
            fresh: false,
            pool: Pool::new(counting),
            batches: VecDeque::new(),
            latency: Latency::default(),
            counters: Counters::default(),
        })
    }

    /// How it draws and counts; `Counting::Auto` has become what the device can do.
    #[must_use]
    pub fn settings(&self) -> Settings {
        self.settings
    }

    /// What the frame asked of the device so far.
    #[must_use]
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// Bytes of the targets and of the scene on the device.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.targets.as_ref().map_or(0, Targets::bytes) + self.scene.bytes()
    }

    /// Ids and depths of the last frame. Waits for it.
    ///
    /// # Errors
    /// No frame was begun; the device's.
    pub fn image(&self) -> Result<Image, OcclusionError> {
        Ok(self.targets()?.image(self.gpu)?)
    }

    /// Normals and albedo of the last frame. Waits for it.
    ///
    /// # Errors
    /// As [`Renderer::image`].
    pub fn surface(&self) -> Result<Surface, OcclusionError> {
        Ok(self.targets()?.surface(self.gpu)?)
    }

    /// Times of the last frame, all its passes "draw" and "query" as one each. Waits for it: the
    /// wall time runs from the frame's beginning until then.
    ///
    /// # Errors
    /// The device's.
    pub fn times(&self) -> Result<FrameTimes, OcclusionError> {
        self.times.read(self.gpu)
    }

    /// What queries test against and passes draw to.
    fn targets(&self) -> Result<&Targets, OcclusionError> {
        self.targets.as_ref().ok_or_else(|| OcclusionError::value("image", "no frame was begun"))
    }

    /// Records what is to be drawn, if anything is.
    fn record_draws(&mut self, encoder: &mut wgpu::CommandEncoder) -> Result<(), OcclusionError> {
        if self.plan.list.is_empty() && !self.fresh {
            return Ok(());
        }
        self.plan.make(self.scene.drawn(), self.settings.drawing);
        let length = self.plan.list.len();
        if length > self.list.most {
            let most = length.next_power_of_two();
            self.list = List::new(self.gpu, &self.pipelines, &self.view_params, most)?;
        }
        if length > 0 {
            let list = bytemuck::cast_slice(&self.plan.list);
            self.gpu.queue.write_buffer(&self.list.buffer, 0, list);
        }
        let Some(targets) = &self.targets else { return Err(not_begun()) };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("draw"),
            color_attachments: &targets.colour(self.fresh),
            depth_stencil_attachment: Some(targets.depth(self.fresh)),
            timestamp_writes: self.times.pass("draw"),
            occlusion_query_set: None,
            multiview_mask: None,
        });
        let mut masked = None;
        for call in &self.plan.calls {
            if masked != Some(call.masked) {
                let Pipelines { solid, masked: cut_out, .. } = &self.pipelines;
                pass.set_pipeline(if call.masked { cut_out } else { solid });
                pass.set_bind_group(0, &self.scene.group, &[]);
                pass.set_bind_group(1, &self.list.group, &[]);
                masked = Some(call.masked);
            }
            pass.draw(call.vertices.clone(), call.instances.clone());
        }
        drop(pass);
        self.counters.draw_calls += self.plan.calls.len() as u64;
        self.counters.draw_passes += 1;
        self.plan.clear();
        self.fresh = false;
        Ok(())
    }

    fn submit(
        &mut self,
        encoder: wgpu::CommandEncoder,
    ) -> Result<wgpu::SubmissionIndex, OcclusionError> {
        self.counters.submissions += 1;
        let gpu = self.gpu;
        Ok(gpu.scoped("frame", || gpu.queue.submit([encoder.finish()]))?)
    }

    fn encoder(&self) -> wgpu::CommandEncoder {
        self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }
}

impl Renders for Renderer<'_> {
    fn begin(&mut self, view: &View) -> Result<(), OcclusionError> {
        let size = (view.width, view.height);
        if self.targets.as_ref().is_none_or(|t| (t.width, t.height) != size) {
            self.targets = Some(Targets::new(self.gpu, view.width, view.height)?);
            self.pool.generation += 1;
        }
        let params = ViewParams::of(view);
        self.gpu.queue.write_buffer(&self.view_params, 0, bytemuck::bytes_of(&params));
        self.view = Some(view.clone());
        self.fresh = true;
        self.plan.clear();
        self.times.begin();
        self.counters = Counters::default();
        Ok(())
    }

    fn draw(&mut self, objects: &[u32]) -> Result<(), OcclusionError> {
        check::drawn(objects, self.scene.objects() as usize)?;
        self.plan.list.extend_from_slice(objects);
        self.latency.drew(objects.len());
        Ok(())
    }

    fn ask(&mut self, boxes: &[Bounds], queries: &[Query]) -> Result<(), OcclusionError> {
        let view = self.view.as_ref().ok_or_else(not_begun)?;
        self.boxes.fill(view, boxes, queries)?;
        let mut encoder = self.encoder();
        self.record_draws(&mut encoder)?;
        let Some(targets) = &self.targets else { return Err(not_begun()) };
        let Self { gpu, pipelines, view_params, pool, times, .. } = self;
        let slot = pool.take(gpu, pipelines, view_params, targets, &self.boxes)?;
        self.counters.query_passes +=
            slot.record(gpu, &mut encoder, pipelines, targets, times, &self.boxes);
        let submission = self.submit(encoder)?;
        self.batches.push_back(slot.submitted(&self.boxes, submission));
        self.latency.asked(boxes.len());
        Ok(())
    }

    fn ready(&mut self) -> Result<bool, OcclusionError> {
        match (self.settings.readiness, self.batches.front()) {
            (Readiness::Modelled(latency), _) => Ok(self.latency.ready(latency)),
            (Readiness::Polled, None) => Ok(true),
            (Readiness::Polled, Some(batch)) if batch.is_done() => Ok(true),
            (Readiness::Polled, Some(batch)) => {
                // Callbacks run inside.
                self.gpu.check()?;
                Ok(batch.is_done())
            }
        }
    }

    fn collect(&mut self, counts: &mut Vec<u32>) -> Result<(), OcclusionError> {
        let Some(batch) = self.batches.pop_front() else {
            return Err(OcclusionError::value("queries", "no batch is left to collect"));
        };
        self.latency.collected(match self.settings.readiness {
            Readiness::Modelled(latency) => latency,
            Readiness::Polled => 0,
        });
        if !batch.is_done() {
            let start = Instant::now();
            batch.wait(self.gpu)?;
            self.counters.waits += 1;
            self.counters.waited_ns += start.elapsed().as_nanos() as u64;
        }
        let slot = batch.read(self.settings.counting, counts)?;
        self.pool.give_back(slot);
        Ok(())
    }

    fn end(&mut self) -> Result<(), OcclusionError> {
        if self.view.is_none() {
            return Err(not_begun());
        }
        let mut encoder = self.encoder();
        self.record_draws(&mut encoder)?;
        self.times.end(&mut encoder);
        self.submit(encoder)?;
        Ok(self.gpu.check()?)
    }
}

fn not_begun() -> OcclusionError {
    OcclusionError::value("frame", "not begun")
}
