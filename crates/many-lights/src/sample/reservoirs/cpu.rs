//! Reservoirs in f32, rows of pixels in parallel; the device's kernels are the same, operation for
//! operation.

use super::{
    Neighbours, Plan, Stream, Table,
    packed::{PackedEye, Reservoir, leaf, target_of},
    weights,
};
use crate::{
    Light, Lighting, LightsError, Point, Reservoirs, Shaded, Times, Work, World, bound::packed,
    gpu::PackedLight,
};
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

/// What all pixels share.
struct Scene {
    world: Arc<World>,
    plan: Plan,
    table: Table,
    lights: Vec<PackedLight>,
    /// One a frame.
    eyes: Vec<PackedEye>,
    clamp_squared: f32,
    seed: u32,
}

/// A reservoir that is merged, where it was drawn, and the number that decides for or against it.
#[derive(Clone, Copy)]
struct Other<'a> {
    reservoir: Reservoir,
    point: &'a Point,
    unit: f32,
}

/// The light that a merge keeps so far.
struct Kept {
    light: u32,
    /// At the pixel itself.
    target: f32,
    /// M p summed over all that are merged.
    could: f32,
    /// Which of the others it is from, or [`OWN`].
    from: usize,
}

/// The pixel's own reservoir, among those that are merged.
const OWN: usize = usize::MAX;

impl Scene {
    #[inline]
    fn radiance(&self, point: &Point, light: u32) -> Vec3 {
        let node = leaf(&self.lights[light as usize], light);
        packed::estimate(&node, point, self.clamp_squared)
    }

    #[inline]
    fn target<const COUNT: bool>(&self, point: &Point, light: u32, work: &mut Work) -> f32 {
        if COUNT {
            work.lights += 1;
        }
        target_of(self.radiance(point, light))
    }

    #[inline]
    fn sees<const COUNT: bool>(&self, point: &Point, light: u32, work: &mut Work) -> bool {
        if self.world.occluders.is_none() {
            return true;
        }
        if COUNT {
            work.rays += 1;
        }
        self.world.sees(point, &self.world.lights[light as usize])
    }

    fn candidates<const COUNT: bool>(
        &self,
        point: &Point,
        frame: usize,
        pixel: usize,
        work: &mut Work,
    ) -> Reservoir {
        let count = self.plan.candidates;
        if self.table.slots.is_empty() {
            return Reservoir::empty(count);
        }
        if COUNT {
            work.samples += u64::from(count);
        }
        let mut random = Stream::Candidates.of(self.seed, frame, pixel);
        let (mut sum, mut light, mut target) = (0.0, 0, 0.0);
        for _ in 0..count {
            let (drawn, inverse) = self.table.draw(&mut random);
            let target_of_drawn = self.target::<COUNT>(point, drawn, work);
            let weight = target_of_drawn * inverse;
            sum += weight;
            if random.unit() * sum < weight {
                (light, target) = (drawn, target_of_drawn);
            }
        }
        if target == 0.0 || !self.sees::<COUNT>(point, light, work) {
            return Reservoir::empty(count);
        }
        Reservoir::of(light, count, sum / (target * count as f32))
    }

    /// As the reference's.
    fn merge<'a, const COUNT: bool>(
        &self,
        point: &Point,
        own: Reservoir,
        others: impl Iterator<Item = Other<'a>> + Clone,
        work: &mut Work,
    ) -> Reservoir {
        let unbiased = self.plan.unbiased != 0;
        let (mut count, mut sum) = (own.count, 0.0);
        let mut kept = Kept { light: 0, target: 0.0, could: 0.0, from: OWN };
        if own.weight > 0.0 {
            let target = self.target::<COUNT>(point, own.light, work);
            let did = own.count as f32 * target;
            let (part, could) = if unbiased {
                let (_, could) = self.could::<COUNT>(own.light, did, others.clone(), OWN, work);
                (did / could, could)
            } else {
                (own.count as f32, 0.0)
            };
            sum = target * own.weight * part;
            kept = Kept { light: own.light, target, could, from: OWN };
        }
        for (which, Other { reservoir, unit, .. }) in others.clone().enumerate() {
            if COUNT {
                work.reused += 1;
            }
            count += reservoir.count;
            let light = reservoir.light;
            if reservoir.weight == 0.0 {
                continue;
            }
            let target = self.target::<COUNT>(point, light, work);
            if target == 0.0 {
                continue;
            }
            let (part, could) = if unbiased {
                let own = own.count as f32 * target;
                let (did, could) = self.could::<COUNT>(light, own, others.clone(), which, work);
                (did / could, could)
            } else {
                (reservoir.count as f32, 0.0)
            };
            let weight = target * reservoir.weight * part;
            sum += weight;
            if unit * sum < weight {
                kept = Kept { light, target, could, from: which };
            }
        }
        let Kept { light, target, could, from } = kept;
        if target == 0.0 || (from != OWN && !self.sees::<COUNT>(point, light, work)) {
            return Reservoir::empty(count);
        }
        let mut weight = sum / target;
        if !unbiased {
            weight /= count as f32;
        } else if self.world.occluders.is_some() {
            let mut saw = own.count as f32 * target;
            for (which, Other { reservoir, point: there, .. }) in others.enumerate() {
                let target = self.target::<COUNT>(there, light, work);
                if which == from || (target > 0.0 && self.sees::<COUNT>(there, light, work)) {
                    saw += reservoir.count as f32 * target;
                }
            }
            weight *= could / saw;
        }
        Reservoir::of(light, count, weight)
    }

    /// M p of a light at the other of number `which`, or `own`, and their sum, nothing in between.
    #[inline]
    fn could<'a, const COUNT: bool>(
        &self,
        light: u32,
        own: f32,
        others: impl Iterator<Item = Other<'a>>,
        which: usize,
        work: &mut Work,
    ) -> (f32, f32) {
        let (mut did, mut could) = (own, own);
        for (index, Other { reservoir, point, .. }) in others.enumerate() {
            let part = reservoir.count as f32 * self.target::<COUNT>(point, light, work);
            could += part;
            if index == which {
                did = part;
            }
        }
        (did, could)
    }

    /// The reservoir of the frame before where the surface was.
    fn history<'a>(
        &'a self,
        before: Option<usize>,
        last: &[Reservoir],
        point: &Point,
    ) -> Option<(Reservoir, &'a Point)> {
        let before = before.filter(|_| self.plan.history > 0)?;
        let eye = &self.eyes[before];
        let at = eye.pixel_of(point)?;
        let there = &self.world.frames[before].points[at];
        let reservoir = last[at];
        if !eye.is_alike(point, there) || !reservoir.is_sound(self.lights.len()) {
            return None;
        }
        let count = reservoir.count.min(self.plan.history);
        Some((Reservoir { count, ..reservoir }, there))
    }

    /// This frame's candidates merged with the frame before.
    fn over_time<const COUNT: bool>(
        &self,
        before: Option<usize>,
        last: &[Reservoir],
        frame: usize,
        pixel: usize,
        work: &mut Work,
    ) -> Reservoir {
        let point = &self.world.frames[frame].points[pixel];
        if !point.is_there() {
            return Reservoir::empty(0);
        }
        if COUNT {
            work.pixels += 1;
        }
        let own = self.candidates::<COUNT>(point, frame, pixel, work);
        let Some((reservoir, there)) = self.history(before, last, point) else { return own };
        let unit = Stream::Temporal.of(self.seed, frame, pixel).unit();
        let other = Other { reservoir, point: there, unit };
        self.merge::<COUNT>(point, own, std::iter::once(other), work)
    }

    /// A pixel's reservoir merged with those of its neighbours.
    fn over_space<const COUNT: bool>(
        &self,
        now: &[Reservoir],
        frame: usize,
        pixel: usize,
        work: &mut Work,
    ) -> Reservoir {
        let (points, eye) = (&self.world.frames[frame].points, &self.eyes[frame]);
        let point = &points[pixel];
        if !point.is_there() {
            return Reservoir::empty(0);
        }
        let random = Stream::Spatial.of(self.seed, frame, pixel);
        let others = Neighbours::new(&self.plan, random, [eye.width, eye.height], pixel)
            .filter(|(at, _)| eye.is_alike(point, &points[*at]))
            .filter(|(at, _)| now[*at].is_sound(self.lights.len()))
            .map(|(at, unit)| Other { reservoir: now[at], point: &points[at], unit });
        if others.clone().next().is_none() {
            return now[pixel];
        }
        self.merge::<COUNT>(point, now[pixel], others, work)
    }
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
