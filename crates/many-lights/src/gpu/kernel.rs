//! Techniques that are one kernel: a pass over the tiles of a frame.

use super::scene::{Output, Scene};
use crate::{Lighting, LightsError, Shaded, Times, Work, cut::tile};
use dapple_gpu::wgpu;
use std::sync::Arc;

/// The bit of the number of a cut's nodes that says that its greatest size ended it.
const ENDED: u32 = 1 << 31;

/// What a kernel is made of.
pub(super) struct Parts<'a> {
    /// Name of the pass.
    pub pass: &'static str,
    /// Its shader; the entry point is `light`.
    pub path: &'a str,
    /// Constants but `COUNT` and `SHADOWS`.
    pub constants: &'a [(&'a str, f64)],
    /// Bindings 0, 1, ... of group 1.
    pub buffers: &'a [&'a wgpu::Buffer],
    /// Whether nodes are evaluated that the cut does not end with: all that are visited.
    pub evaluates_all: bool,
    /// Most workgroups, where they share out the tiles among them; `None` where each has one.
    pub most_groups: Option<u32>,
}

/// A kernel with all it needs for every frame.
pub(super) struct Kernel<'g> {
    scene: Arc<Scene<'g>>,
    pass: &'static str,
    output: Output,
    /// The one that is timed, and the one that counts.
    variants: [Variant; 2],
    evaluates_all: bool,
    most_groups: Option<u32>,
    bytes: u64,
    last: Option<(usize, bool)>,
}

struct Variant {
    pipeline: wgpu::ComputePipeline,
    /// Group 0, one a frame.
    frames: Vec<wgpu::BindGroup>,
    /// Group 1.
    own: wgpu::BindGroup,
    /// Group 2.
    shadows: wgpu::BindGroup,
}

impl<'g> Kernel<'g> {
    /// Makes both variants.
    ///
    /// # Errors
    /// The device's.
    pub fn new(scene: &Arc<Scene<'g>>, parts: &Parts<'_>) -> Result<Self, LightsError> {
        let output = scene.output()?;
        let variant = |count: f64| {
            let both = [("COUNT", count), scene.occluders().constant()];
            let constants: Vec<_> = both.iter().chain(parts.constants).copied().collect();
            let pipeline = scene.gpu.compute(parts.path, "light", &constants)?;
            let frames = scene.bind(&pipeline, &output);
            let own = scene.gpu.bind(&pipeline, 1, parts.buffers);
            let shadows = scene.bind_shadows(&pipeline, scene.lights());
            Ok::<_, LightsError>(Variant { pipeline, frames, own, shadows })
        };
        let variants = [variant(0.0)?, variant(1.0)?];
        scene.gpu.check()?;
        Ok(Self {
            scene: Arc::clone(scene),
            pass: parts.pass,
            variants,
            evaluates_all: parts.evaluates_all,
            most_groups: parts.most_groups,
            bytes: parts.buffers.iter().map(|buffer| buffer.size()).sum(),
            output,
            last: None,
        })
    }

    /// Binds other buffers in place of those that it was made of.
    pub fn bind(&mut self, buffers: &[&wgpu::Buffer]) {
        for variant in &mut self.variants {
            variant.own = self.scene.gpu.bind(&variant.pipeline, 1, buffers);
        }
        self.bytes = buffers.iter().map(|buffer| buffer.size()).sum();
    }

    /// Traces shadow rays to other lights than the scene's, which they begin with.
    pub fn bind_shadow_lights(&mut self, lights: &wgpu::Buffer) {
        for variant in &mut self.variants {
            variant.shadows = self.scene.bind_shadows(&variant.pipeline, lights);
        }
    }

    fn work(&self, frame: usize, visits: &mut Vec<u32>) -> Result<Work, LightsError> {
        let counts = self.scene.read_counts(&self.output, frame)?;
        let mut work = Work { rays: self.scene.read_rays(&self.output, frame)?, ..Work::default() };
        let frame = self.scene.frame(frame)?;
        let lit = frame.points.iter().zip(&counts).filter(|(point, _)| point.is_there());
        for (_, &[visited, bounds, lights, last]) in lit {
            let cut = u64::from(last & !ENDED);
            let evaluated = if self.evaluates_all { visited.into() } else { cut };
            work += Work {
                pixels: 1,
                visits: visited.into(),
                bounds: bounds.into(),
                lights: lights.into(),
                clusters: evaluated.saturating_sub(lights.into()),
                cut,
                most_cut: cut,
                ended: u64::from(last & ENDED != 0),
                ..Work::default()
            };
        }
        visits.extend(counts.iter().map(|count| count[0]));
        work.lane_visits = tile::lane_visits(frame.width, frame.height, visits);
        Ok(work)
    }
}

impl Lighting for Kernel<'_> {
    fn reset(&mut self, _seed: u32) -> Result<(), LightsError> {
        self.last = None;
        Ok(())
    }

    fn shade(&mut self, index: usize, count: bool) -> Result<Times, LightsError> {
        let [columns, rows] = self.scene.tiles(index)?;
        let variant = &self.variants[usize::from(count)];
        let mut frame = self.scene.gpu.frame();
        frame.compute(self.pass, |pass| {
            pass.set_pipeline(&variant.pipeline);
            pass.set_bind_group(0, &variant.frames[index], &[]);
            pass.set_bind_group(1, &variant.own, &[]);
            pass.set_bind_group(2, &variant.shadows, &[]);
            match self.most_groups {
                None => pass.dispatch_workgroups(columns, rows, 1),
                Some(most) => pass.dispatch_workgroups(most.min(columns * rows), 1, 1),
            }
        });
        let times = frame.finish()?.passes;
        self.last = Some((index, count));
        Ok(times)
    }

    fn read(&mut self, shaded: &mut Shaded) -> Result<(), LightsError> {
        let Some((frame, counted)) = self.last else {
            return Err(LightsError::value("reading", "no frame has been lit yet"));
        };
        self.scene.read(&self.output, frame, &mut shaded.radiance)?;
        shaded.visits.clear();
        shaded.work = if counted { self.work(frame, &mut shaded.visits)? } else { Work::default() };
        Ok(())
    }

    fn bytes(&self) -> u64 {
        self.bytes
    }
}
