//! The form on a graphics device: nothing comes back to the host within a frame.
//!
//! Objects are kept in the order of their templates. A kernel asks every box and flags those to be
//! drawn, a prefix sum turns the flags into a list in which the objects of a template lie side by
//! side, and one indirect draw a template reads its part. The list of the second pass follows that
//! of the first.
//!
//! Deviations: the course culls clusters of 64 triangles as well; an object here is as small as the
//! scene makes it. A template is drawn though none of its objects is listed: by no instances.

mod kernels;
mod params;
#[cfg(test)]
mod tests;

use super::{Fault, MOST_ACROSS, Settings, pyramid};
use crate::OcclusionError;
use crate::camera::gpu::{Counting, Pipelines, Scene, Targets, ViewParams, upload};
use crate::camera::{Frame, Image, Objects, View};
use bytemuck::{Pod, Zeroable};
use dapple_gpu::bindings::{bind, whole};
use dapple_gpu::{FrameTimes, Gpu, GpuError, wgpu};
use kernels::{Buffers, ITEMS, Kernel, Listing, Question};
use params::{Counts, Params};

/// Bits of an item's state; mirror `common/occlusion_cull.wgsl`.
const VISIBLE: u32 = 1;

/// Bytes of an indirect draw.
const DRAW_BYTES: u64 = 16;

/// Mirrors `Box` of `hierarchical_cull.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct ItemBox {
    low: [f32; 3],
    high: [f32; 3],
}

/// Mirrors `Slot` of `hierarchical_list.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
struct Slot {
    first: u32,
    end: u32,
    vertices: u32,
}

/// Culls and draws, frame after frame.
#[derive(Debug)]
pub struct Culler<'g> {
    gpu: &'g Gpu,
    scene: Scene,
    across: u32,
    fault: Option<Fault>,
    pipelines: Pipelines,
    view_params: wgpu::Buffer,
    buffers: Buffers,
    /// Group 1 of drawing: view and list.
    drawing: wgpu::BindGroup,
    listings: [Listing; 2],
    /// The object of each item.
    order: Vec<u32>,
    counts: Counts,
    /// Templates without a mask, which come first.
    solid: u32,
    sized: Option<Sized>,
}

/// What depends on the image's size.
#[derive(Debug)]
struct Sized {
    targets: Targets,
    levels: Vec<pyramid::Level>,
    texels: wgpu::Buffer,
    questions: [Kernel; 3],
    pyramid: Vec<Kernel>,
}

impl<'g> Culler<'g> {
    /// For `scene`, the upload of `objects`. Objects are asked one by one: there is no tree.
    ///
    /// # Errors
    /// Settings out of range, another scene's objects, a device that cannot begin an indirect draw
    /// within a list, the device's.
    pub fn new(
        gpu: &'g Gpu,
        scene: &Scene,
        objects: &Objects,
        settings: &Settings,
    ) -> Result<Self, OcclusionError> {
        Self::build(gpu, scene, objects, settings, None)
    }

    /// The same with a deliberate fault, for what must find it.
    ///
    /// # Errors
    /// As [`Culler::new`].
    pub fn with_fault(
        gpu: &'g Gpu,
        scene: &Scene,
        objects: &Objects,
        settings: &Settings,
        fault: Fault,
    ) -> Result<Self, OcclusionError> {
        Self::build(gpu, scene, objects, settings, Some(fault))
    }

    fn build(
        gpu: &'g Gpu,
        scene: &Scene,
        objects: &Objects,
        settings: &Settings,
        fault: Option<Fault>,
    ) -> Result<Self, OcclusionError> {
        settings.check()?;
        if objects.objects.len() != scene.drawn().len() {
            let (given, made) = (objects.objects.len(), scene.drawn().len());
            return Err(OcclusionError::value("objects", format!("{given}, the scene has {made}")));
        }
        if !gpu.device.features().contains(wgpu::Features::INDIRECT_FIRST_INSTANCE) {
            let what = "hierarchical depth on the device".into();
            return Err(GpuError::Missing { what, feature: "INDIRECT_FIRST_INSTANCE" }.into());
        }
        let Items { order, slots, solid } = items(objects);
        let boxes: Vec<_> = order
            .iter()
            .map(|&object| {
                let bounds = objects.objects[object as usize].bounds;
                ItemBox { low: bounds.min.into(), high: bounds.max.into() }
            })
            .collect();
        let counts = Counts {
            items: order.len() as u32,
            groups: (order.len() as u32).div_ceil(ITEMS),
            slots: slots.len() as u32,
        };
        let words = |count: u32| 4 * u64::from(count);
        let buffers = Buffers {
            params: gpu.uniform("culling", &Params::default())?,
            boxes: upload(gpu, "boxes", &boxes)?,
            state: gpu.upload("states", &vec![0_u32; order.len()])?,
            sums: gpu.buffer("sums", words(counts.groups))?,
            totals: gpu.upload("totals", &[0_u32; 2])?,
            order: gpu.upload("order", &order)?,
            list: gpu.buffer("objects drawn", words(counts.items))?,
            offsets: gpu.buffer("offsets", words(counts.items) + 4)?,
            slots: upload(gpu, "slots", &slots)?,
            draws: gpu.buffer("draws", DRAW_BYTES * u64::from(counts.slots))?,
        };
        // Boxes are never drawn here.
        let pipelines = Pipelines::new(gpu, &scene.layout, Counting::Boolean, None)?;
        let view_params = gpu.uniform("view", &ViewParams::default())?;
        let listing = |second| Listing::new(gpu, &buffers, second, counts.items, counts.slots);
        let culler = Self {
            drawing: bind(gpu, &pipelines.list, &[whole(&view_params), whole(&buffers.list)]),
            listings: [listing(false)?, listing(true)?],
            gpu,
            scene: scene.clone(),
            across: settings.across.min(MOST_ACROSS),
            fault,
            pipelines,
            view_params,
            buffers,
            order,
            counts,
            solid,
            sized: None,
        };
        gpu.check()?;
        Ok(culler)
    }

    /// Forgets what was visible.
    pub fn reset(&mut self) {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(&self.buffers.state, 0, None);
        self.gpu.queue.submit([encoder.finish()]);
    }

    /// Draws what `view` sees, and waits for the device. Passes: `cull`, `draw`, `pyramid`, again
    /// the same, and `cull`.
    ///
    /// # Errors
    /// The device's.
    pub fn frame(&mut self, view: &View) -> Result<FrameTimes, OcclusionError> {
        let size = (view.width, view.height);
        if self.sized.as_ref().is_none_or(|s| (s.targets.width, s.targets.height) != size) {
            self.sized = None;
            self.sized = Some(self.make_sized(view.width, view.height)?);
        }
        let Some(sized) = &self.sized else {
            return Err(OcclusionError::value("image", "no targets"));
        };
        let params = Params::of(view, &sized.levels, self.across, self.counts);
        let queue = &self.gpu.queue;
        queue.write_buffer(&self.buffers.params, 0, bytemuck::bytes_of(&params));
        let drawing = ViewParams::of(view);
        queue.write_buffer(&self.view_params, 0, bytemuck::bytes_of(&drawing));

        let mut frame = self.gpu.frame();
        if self.counts.items == 0 {
            self.draw(&mut frame, sized, true);
            return Ok(frame.finish()?);
        }
        for (second, listing) in [false, true].into_iter().zip(&self.listings) {
            frame.compute("cull", |pass| {
                sized.questions[usize::from(second)].record(pass);
                listing.0.iter().for_each(|kernel| kernel.record(pass));
            });
            self.draw(&mut frame, sized, !second);
            frame.compute("pyramid", |pass| {
                sized.pyramid.iter().for_each(|kernel| kernel.record(pass));
            });
        }
        frame.compute("cull", |pass| sized.questions[2].record(pass));
        Ok(frame.finish()?)
    }

    /// What the last frame drew, in the order of its passes and templates, and its counters. A draw
    /// is one that the device reads, two a template.
    ///
    /// # Errors
    /// The device's.
    pub fn collect(&self, frame: &mut Frame) -> Result<(), OcclusionError> {
        frame.clear();
        let Some(sized) = self.sized.as_ref().filter(|_| self.counts.items > 0) else {
            return Ok(());
        };
        let totals = self.gpu.read::<u32>(&self.buffers.totals, 0, 2)?;
        let count = totals[1].min(self.counts.items) as usize;
        frame.drawn = self.gpu.read(&self.buffers.list, 0, count)?;
        let texels = sized.texel_count();
        let work = &mut frame.work;
        work.nodes = 3 * u64::from(self.counts.items);
        work.draws = 2 * u64::from(self.counts.slots);
        work.pyramid_texels = 2 * texels;
        work.dispatches = 3 + 2 * (3 + sized.pyramid.len() as u64);
        let drawn = self.scene.drawn();
        let triangles = |o: &u32| drawn.get(*o as usize).map_or(0, |d| u64::from(d.triangles));
        work.triangles = frame.drawn.iter().map(triangles).sum();
        Ok(())
    }

    /// Whether each object was visible in the last frame.
    ///
    /// # Errors
    /// The device's.
    pub fn visible(&self) -> Result<Vec<bool>, OcclusionError> {
        let states = self.gpu.read::<u32>(&self.buffers.state, 0, self.order.len())?;
        let mut visible = vec![false; self.order.len()];
        for (&object, state) in self.order.iter().zip(states) {
            visible[object as usize] = state & VISIBLE != 0;
        }
        Ok(visible)
    }

    /// Ids and depths of the last frame.
    ///
    /// # Errors
    /// No frame was drawn; the device's.
    pub fn image(&self) -> Result<Image, OcclusionError> {
        match &self.sized {
            Some(sized) => Ok(sized.targets.image(self.gpu)?),
            None => Err(OcclusionError::value("image", "no frame was drawn")),
        }
    }

    /// Bytes on the device beside the scene's.
    pub fn bytes(&self) -> u64 {
        let sized = self.sized.as_ref().map_or(0, |s| s.texels.size() + s.targets.bytes());
        self.buffers.bytes() + self.view_params.size() + sized
    }

    fn make_sized(&self, width: u32, height: u32) -> Result<Sized, OcclusionError> {
        let gpu = self.gpu;
        let targets = Targets::new(gpu, width, height)?;
        let levels = pyramid::levels(width, height);
        let image = u64::from(width) * u64::from(height);
        let last = levels.last().map_or(0, |l| u64::from(l.start) + 1);
        let texels = gpu.buffer("pyramid", 4 * last.saturating_sub(image))?;
        let depth = &targets.depth_view;
        let question = |question| {
            kernels::cull(gpu, &self.buffers, question, &texels, depth, self.counts.items)
        };
        let questions =
            [question(Question::First)?, question(Question::Second)?, question(Question::Last)?];
        let nearest = self.fault == Some(Fault::Nearest);
        let params = &self.buffers.params;
        let pyramid = kernels::pyramid(gpu, params, &texels, depth, [width, height], nearest)?;
        gpu.check()?;
        Ok(Sized { questions, pyramid, targets, levels, texels })
    }

    fn draw(&self, frame: &mut dapple_gpu::Frame<'_>, sized: &Sized, clear: bool) {
        let targets = dapple_gpu::Targets {
            colour: &sized.targets.colour(clear),
            depth: Some(sized.targets.depth(clear)),
            occlusion: None,
        };
        let masked = self.counts.slots - self.solid;
        frame.raster("draw", targets, |pass| {
            let Pipelines { solid, masked: cut_out, .. } = &self.pipelines;
            for (pipeline, first, count) in [(solid, 0, self.solid), (cut_out, self.solid, masked)]
            {
                if count > 0 && self.counts.items > 0 {
                    pass.set_pipeline(pipeline);
                    pass.set_bind_group(0, &self.scene.group, &[]);
                    pass.set_bind_group(1, &self.drawing, &[]);
                    let offset = DRAW_BYTES * u64::from(first);
                    pass.multi_draw_indirect(&self.buffers.draws, offset, count);
                }
            }
        });
    }
}

impl Sized {
    /// Texels of the pyramid that are written: all but the image.
    fn texel_count(&self) -> u64 {
        self.levels[1..].iter().map(|l| u64::from(l.width) * u64::from(l.height)).sum()
    }
}

/// Objects in the order of their templates.
struct Items {
    /// The object of each item.
    order: Vec<u32>,
    /// Templates that have objects.
    slots: Vec<Slot>,
    /// Those without a mask, which come first.
    solid: u32,
}

fn items(objects: &Objects) -> Items {
    let key = |&object: &u32| {
        let template = objects.objects[object as usize].template;
        (objects.templates[template as usize].mask.is_some(), template)
    };
    let mut order: Vec<u32> = (0..objects.objects.len() as u32).collect();
    order.sort_by_key(key);
    let (mut slots, mut solid) = (Vec::<Slot>::new(), 0);
    let mut last = None;
    for (item, object) in (0..).zip(&order) {
        let (masked, template) = key(object);
        if last != Some(template) {
            let triangles = objects.templates[template as usize].triangles.len() as u32;
            slots.push(Slot { first: item, end: item, vertices: 3 * triangles });
            solid += u32::from(!masked);
            last = Some(template);
        }
        if let Some(slot) = slots.last_mut() {
            slot.end = item + 1;
        }
    }
    Items { order, slots, solid }
}
