//! One pixel's reservoir in f32: its candidates, and what is merged with it.

use super::{
    Neighbours, Plan, Stream, Table,
    packed::{PackedEye, Reservoir, target_of},
};
use crate::{Point, Work, World, bound::packed, light::PackedLight};
use glam::Vec3;
use std::sync::Arc;

/// What all pixels share.
pub(super) struct Scene {
    pub world: Arc<World>,
    pub plan: Plan,
    pub table: Table,
    pub lights: Vec<PackedLight>,
    /// One a frame.
    pub eyes: Vec<PackedEye>,
    pub clamp_squared: f32,
    pub seed: u32,
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
    pub fn radiance(&self, point: &Point, light: u32) -> Vec3 {
        let node = self.lights[light as usize].leaf(light);
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
    pub fn over_time<const COUNT: bool>(
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
    pub fn over_space<const COUNT: bool>(
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
