//! Reservoirs on a device: candidates, the frame before, neighbours, light, each a pass.
//!
//! Based on: B. Bitterli et al., "Spatiotemporal reservoir resampling for real-time ray tracing with
//! dynamic direct lighting", 2020, algorithms 3 - 6.
//! Deviations: as on the processor (`sample/reservoirs`), whose random numbers these are; no shadow
//! rays.

use super::scene::{Output, Scene, storage};
use crate::{
    Lighting, LightsError, Reservoirs, Shaded, Times, Work,
    sample::reservoirs::{PackedEye, Plan, Reservoir, Stream, Table, weights},
};
use bytemuck::{Pod, Zeroable};
use dapple_gpu::wgpu;
use std::sync::Arc;

/// Shader of all passes.
const PATH: &str = "many-lights/reservoirs.wgsl";

/// Mirrors `ReservoirParams` of the shader.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct ReservoirParams {
    plan: Plan,
    slots: u32,
    shift: u32,
    /// Of candidates, the frame before, and neighbours.
    seeds: [u32; 3],
    pad: u32,
    eye: PackedEye,
    eye_before: PackedEye,
}

/// The form for devices.
pub(crate) struct OnDevice<'g> {
    scene: Arc<Scene<'g>>,
    output: Output,
    buffers: Buffers,
    /// Those that are timed, and those that count.
    variants: [Passes; 2],
    shade: Pass,
    shared: ReservoirParams,
    eyes: Vec<PackedEye>,
    seed: u32,
    /// The frame that was lit last, and whether it was counted.
    before: Option<(usize, bool)>,
}

struct Buffers {
    params: wgpu::Buffer,
    slots: wgpu::Buffer,
    now: wgpu::Buffer,
    last: wgpu::Buffer,
}

struct Passes {
    candidates: Pass,
    temporal: Pass,
    spatial: Pass,
}

/// A pipeline with its groups; those of frames are one a frame.
struct Pass {
    name: &'static str,
    pipeline: wgpu::ComputePipeline,
    frames: Vec<wgpu::BindGroup>,
    own: wgpu::BindGroup,
    /// The points of the frame before, where the pass reads them.
    before: Vec<wgpu::BindGroup>,
}

/// What of the bindings a pass uses; an entry point's layout holds no others.
struct Uses {
    name: &'static str,
    /// Of group 0: parameters, points, radiance, counts.
    frame: &'static [u32],
    /// Of group 1: parameters, lights, slots, now, last.
    own: &'static [u32],
    before: bool,
}

const CANDIDATES: Uses =
    Uses { name: "candidates", frame: &[0, 1, 3], own: &[0, 1, 2, 3], before: false };
const TEMPORAL: Uses =
    Uses { name: "temporal", frame: &[0, 1, 3], own: &[0, 1, 3, 4], before: true };
const SPATIAL: Uses =
    Uses { name: "spatial", frame: &[0, 1, 3], own: &[0, 1, 3, 4], before: false };
const SHADE: Uses = Uses { name: "shade", frame: &[0, 1, 2], own: &[1, 4], before: false };

impl Pass {
    fn new(
        scene: &Scene<'_>,
        output: &Output,
        buffers: &Buffers,
        uses: &Uses,
        constants: &[(&str, f64)],
    ) -> Result<Self, LightsError> {
        let gpu = scene.gpu;
        let pipeline = gpu.compute(PATH, uses.name, constants)?;
        let bind = |group: u32, all: &[&wgpu::Buffer], used: &[u32]| {
            let entries: Vec<_> = used
                .iter()
                .map(|binding| wgpu::BindGroupEntry {
                    binding: *binding,
                    resource: dapple_gpu::bindings::whole(all[*binding as usize]),
                })
                .collect();
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(uses.name),
                layout: &pipeline.get_bind_group_layout(group),
                entries: &entries,
            })
        };
        let (mut frames, mut before) = (Vec::new(), Vec::new());
        for index in 0..scene.frames() {
            let (params, points) = (scene.params(index)?, scene.points(index)?);
            frames.push(bind(0, &[params, points, &output.radiance, &output.counts], uses.frame));
            if uses.before {
                before.push(bind(2, &[points], &[0]));
            }
        }
        let Buffers { params, slots, now, last } = buffers;
        let own = bind(1, &[params, scene.lights(), slots, now, last], uses.own);
        Ok(Self { name: uses.name, pipeline, frames, own, before })
    }

    fn record(
        &self,
        frame: &mut dapple_gpu::Frame<'_>,
        index: usize,
        before: Option<usize>,
        [columns, rows]: [u32; 2],
    ) {
        frame.compute(self.name, |pass| {
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &self.frames[index], &[]);
            pass.set_bind_group(1, &self.own, &[]);
            if let Some(group) = before.and_then(|before| self.before.get(before)) {
                pass.set_bind_group(2, group, &[]);
            }
            pass.dispatch_workgroups(columns, rows, 1);
        });
    }
}

impl<'g> OnDevice<'g> {
    /// # Errors
    /// Settings that are refused, or the device's.
    pub fn new(settings: &Reservoirs, scene: &Arc<Scene<'g>>) -> Result<Self, LightsError> {
        let (gpu, world) = (scene.gpu, &scene.world);
        let table = Table::new(&weights(&world.lights))?;
        let state = size_of::<Reservoir>() as u64 * scene.greatest_pixels();
        let shared = ReservoirParams {
            plan: Plan::new(settings)?,
            slots: table.slots.len() as u32,
            shift: table.shift,
            ..ReservoirParams::default()
        };
        let buffers = Buffers {
            params: gpu.uniform("reservoirs", &shared)?,
            slots: storage(gpu, "table of lights", &table.slots)?,
            now: gpu.buffer("reservoirs of this frame", state)?,
            last: gpu.buffer("reservoirs of the last frame", state)?,
        };
        let output = scene.output()?;
        let passes = |count: f64| {
            let pass = |uses| Pass::new(scene, &output, &buffers, uses, &[("COUNT", count)]);
            Ok::<_, LightsError>(Passes {
                candidates: pass(&CANDIDATES)?,
                temporal: pass(&TEMPORAL)?,
                spatial: pass(&SPATIAL)?,
            })
        };
        let variants = [passes(0.0)?, passes(1.0)?];
        let shade = Pass::new(scene, &output, &buffers, &SHADE, &[])?;
        gpu.check()?;
        let eye = |frame: &crate::Frame| PackedEye::new(&frame.eye, [frame.width, frame.height]);
        Ok(Self {
            eyes: world.frames.iter().map(eye).collect(),
            scene: Arc::clone(scene),
            output,
            buffers,
            variants,
            shade,
            shared,
            seed: 0,
            before: None,
        })
    }

    fn work(&self, index: usize) -> Result<Work, LightsError> {
        let counts = self.scene.read_counts(&self.output, index)?;
        let points = &self.scene.frame(index)?.points;
        let there = || points.iter().zip(&counts).filter(|(point, _)| point.is_there());
        let pixels = there().count() as u64;
        let drawn = if self.shared.slots == 0 { 0 } else { self.shared.plan.candidates };
        Ok(Work {
            pixels,
            samples: pixels * u64::from(drawn),
            lights: there().map(|(_, count)| u64::from(count[0])).sum(),
            reused: there().map(|(_, count)| u64::from(count[1])).sum(),
            ..Work::default()
        })
    }
}

impl Lighting for OnDevice<'_> {
    fn reset(&mut self, seed: u32) -> Result<(), LightsError> {
        self.seed = seed;
        self.before = None;
        Ok(())
    }

    fn shade(&mut self, index: usize, count: bool) -> Result<Times, LightsError> {
        let tiles = self.scene.tiles(index)?;
        let before = self.before.map(|(before, _)| before);
        let before = before.filter(|_| self.shared.plan.history > 0);
        let seeds = [Stream::Candidates, Stream::Temporal, Stream::Spatial];
        let params = ReservoirParams {
            seeds: seeds.map(|stream| stream.seed(self.seed)),
            eye: self.eyes[index],
            eye_before: self.eyes[before.unwrap_or(index)],
            ..self.shared
        };
        let queue = &self.scene.gpu.queue;
        queue.write_buffer(&self.buffers.params, 0, bytemuck::bytes_of(&params));
        let passes = &self.variants[usize::from(count)];
        let mut frame = self.scene.gpu.frame();
        passes.candidates.record(&mut frame, index, None, tiles);
        if before.is_some() {
            passes.temporal.record(&mut frame, index, before, tiles);
        }
        passes.spatial.record(&mut frame, index, None, tiles);
        self.shade.record(&mut frame, index, None, tiles);
        let times = frame.finish()?.passes;
        self.before = Some((index, count));
        Ok(times)
    }

    fn read(&mut self, shaded: &mut Shaded) -> Result<(), LightsError> {
        let Some((index, counted)) = self.before else {
            return Err(LightsError::value("reading", "no frame has been lit yet"));
        };
        self.scene.read(&self.output, index, &mut shaded.radiance)?;
        shaded.work = if counted { self.work(index)? } else { Work::default() };
        shaded.visits.clear();
        Ok(())
    }

    fn bytes(&self) -> u64 {
        let Buffers { params, slots, now, last } = &self.buffers;
        [params, slots, now, last, self.scene.lights()].iter().map(|buffer| buffer.size()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::reservoirs::Slot;

    #[test]
    fn structs_have_the_layout_of_the_shader() {
        use crate::gpu::mirror;
        mirror::<ReservoirParams>(
            PATH,
            "ReservoirParams",
            &[
                ("candidates", 0),
                ("history", 4),
                ("neighbours", 8),
                ("radius", 12),
                ("radius_squared", 16),
                ("unbiased", 20),
                ("slots", 24),
                ("shift", 28),
                ("seed_candidates", 32),
                ("seed_temporal", 36),
                ("seed_spatial", 40),
                ("pad", 44),
                ("eye", 48),
                ("eye_before", 112),
            ],
        );
        mirror::<PackedEye>(
            PATH,
            "ReservoirEye",
            &[
                ("position", 0),
                ("perspective", 12),
                ("forward", 16),
                ("width", 28),
                ("right", 32),
                ("height", 44),
                ("up", 48),
                ("pad", 60),
            ],
        );
        mirror::<Reservoir>(PATH, "Reservoir", &[("light", 0), ("count", 4), ("weight", 8)]);
        mirror::<Slot>(
            PATH,
            "Slot",
            &[("own", 0), ("other", 4), ("inverse_own", 8), ("inverse_other", 12)],
        );
    }
}
