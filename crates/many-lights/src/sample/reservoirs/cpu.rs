//! Reservoirs in f32, rows of pixels in parallel; the device's kernels are the same, operation for
//! operation.

use super::{
    Plan, Table,
    packed::{PackedEye, Reservoir},
    pixel::Scene,
    weights,
};
use crate::{Light, Lighting, LightsError, Reservoirs, Shaded, Times, Work, World, bound::packed};
use glam::Vec3;
use rayon::prelude::*;
use std::sync::Arc;

/// The form for processors.
pub(crate) struct Cpu {
    scene: Scene,
    /// The frame that was lit last.
    before: Option<usize>,
    /// Its reservoirs; as many as the largest frame has pixels.
    last: Vec<Reservoir>,
    /// This frame's, before neighbours are merged.
    now: Vec<Reservoir>,
    radiance: Vec<Vec3>,
    shown: usize,
    work: Work,
}

impl Cpu {
    pub fn new(settings: &Reservoirs, world: &Arc<World>) -> Result<Self, LightsError> {
        let pixels = world.frames.iter().map(|frame| frame.points.len()).max().unwrap_or(0);
        let eye = |frame: &crate::Frame| PackedEye::new(&frame.eye, [frame.width, frame.height]);
        let scene = Scene {
            world: Arc::clone(world),
            plan: Plan::new(settings)?,
            table: Table::new(&weights(&world.lights))?,
            lights: world.lights.iter().map(Light::pack).collect(),
            eyes: world.frames.iter().map(eye).collect(),
            clamp_squared: packed::clamp_squared(world.clamp_m),
            seed: 0,
        };
        Ok(Self {
            scene,
            before: None,
            last: vec![Reservoir::empty(0); pixels],
            now: vec![Reservoir::empty(0); pixels],
            radiance: vec![Vec3::ZERO; pixels],
            shown: 0,
            work: Work::default(),
        })
    }

    fn light<const COUNT: bool>(&mut self, index: usize) -> Work {
        let (scene, before, last) = (&self.scene, self.before, &self.last);
        let frame = &scene.world.frames[index];
        let (width, pixels) = (frame.width.max(1) as usize, frame.points.len());
        let rows = self.now[..pixels].par_chunks_mut(width).enumerate();
        let mut work = rows
            .map(|(row, now)| {
                let mut work = Work::default();
                for (pixel, now) in (row * width..).zip(now) {
                    *now = scene.over_time::<COUNT>(before, last, index, pixel, &mut work);
                }
                work
            })
            .reduce(Work::default, joined);
        let now = &self.now;
        let rows = self.last[..pixels].par_chunks_mut(width);
        let rows = rows.zip(self.radiance[..pixels].par_chunks_mut(width)).enumerate();
        work += rows
            .map(|(row, (last, radiance))| {
                let mut work = Work::default();
                for ((pixel, last), rgb) in (row * width..).zip(last).zip(radiance) {
                    *last = scene.over_space::<COUNT>(now, index, pixel, &mut work);
                    *rgb = if last.weight > 0.0 {
                        scene.radiance(&frame.points[pixel], last.light) * last.weight
                    } else {
                        Vec3::ZERO
                    };
                }
                work
            })
            .reduce(Work::default, joined);
        work
    }
}

fn joined(mut one: Work, other: Work) -> Work {
    one += other;
    one
}

impl Lighting for Cpu {
    fn reset(&mut self, seed: u32) -> Result<(), LightsError> {
        self.scene.seed = seed;
        self.before = None;
        Ok(())
    }

    fn shade(&mut self, index: usize, count: bool) -> Result<Times, LightsError> {
        let pixels = self.scene.world.frame(index)?.points.len();
        self.work = if count { self.light::<true>(index) } else { self.light::<false>(index) };
        self.before = Some(index);
        self.shown = pixels;
        Ok(Times::new())
    }

    fn read(&mut self, shaded: &mut Shaded) -> Result<(), LightsError> {
        shaded.radiance.clear();
        shaded.radiance.extend_from_slice(&self.radiance[..self.shown]);
        shaded.work = self.work;
        shaded.visits.clear();
        Ok(())
    }

    fn bytes(&self) -> u64 {
        let state = size_of_val(&self.last[..]) + size_of_val(&self.now[..]);
        let lights = size_of_val(&self.scene.lights[..]) + size_of_val(&self.scene.eyes[..]);
        (state + lights) as u64 + self.scene.table.bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::worlds::{Cloud, cloud};

    /// Every third reservoir of the frame before is spoilt.
    #[test]
    fn what_went_wrong_in_one_frame_does_not_reach_the_next() {
        let cloud = cloud(&Cloud { lights: 50, size: [24, 18], frames: 1, ..Cloud::default() });
        let world = Arc::new(cloud.world);
        let settings = Reservoirs {
            candidates: 8,
            temporal: true,
            history: 20,
            neighbours: 3,
            radius_px: 5.0,
            unbiased: true,
        };
        for (light, weight) in
            [(1, f32::NAN), (1, f32::INFINITY), (1, -1.0), (50, 1.0), (u32::MAX, 1.0)]
        {
            let mut cpu = Cpu::new(&settings, &world).unwrap();
            cpu.shade(0, true).unwrap();
            for reservoir in cpu.last.iter_mut().step_by(3) {
                (reservoir.light, reservoir.weight) = (light, weight);
            }
            let reused = cpu.work.reused;
            cpu.shade(0, true).unwrap();
            // Two thirds of the pixels still have a history.
            assert!(cpu.work.reused > reused && cpu.work.reused < reused + cpu.work.pixels);
            assert!(cpu.radiance.iter().all(|rgb| rgb.is_finite() && rgb.min_element() >= 0.0));
            assert!(cpu.last.iter().all(|reservoir| reservoir.is_sound(50)));
        }
    }
}
