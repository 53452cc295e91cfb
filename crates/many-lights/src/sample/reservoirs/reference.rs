//! Reservoirs in f64, clear and alone.

use super::{DEPTH_SHARE, LEAST_COSINE, NONE, Neighbours, Plan, Stream, Table, weights};
use crate::{
    Eye, Frame, Lighting, LightsError, Point, Reservoirs, Shaded, Times, Work, World,
    light::luminance, radiance,
};
use glam::DVec3;
use std::sync::Arc;

/// A light that stands for all that were looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Reservoir {
    /// [`NONE`] where none gives anything.
    light: u32,
    /// Candidates it stands for: M.
    count: u32,
    /// W: what one over the probability of the light is estimated as.
    weight: f64,
}

/// A reservoir that is merged, where it was drawn, and the number that decides for or against it.
#[derive(Clone, Copy)]
struct Other<'a> {
    reservoir: Reservoir,
    point: &'a Point,
    unit: f64,
}

/// How readily each of those that are merged draws a light: M p, nothing in between.
struct Could {
    own: f64,
    others: Vec<f64>,
}

impl Could {
    /// `target` is that at the pixel itself.
    fn of(
        scene: &Reference,
        light: u32,
        count: u32,
        target: f64,
        others: &[Other],
        work: &mut Work,
    ) -> Self {
        if scene.plan.unbiased == 0 {
            return Self { own: 0.0, others: Vec::new() };
        }
        let part = |other: &Other| {
            f64::from(other.reservoir.count) * scene.target(other.point, light, work)
        };
        Self { own: f64::from(count) * target, others: others.iter().map(part).collect() }
    }

    fn sum(&self) -> f64 {
        self.own + self.others.iter().sum::<f64>()
    }
}

/// The reference form.
pub(crate) struct Reference {
    world: Arc<World>,
    plan: Plan,
    table: Table,
    seed: u32,
    /// The frame that was lit last, and its reservoirs.
    before: Option<(usize, Vec<Reservoir>)>,
    radiance: Vec<DVec3>,
    work: Work,
}

impl Reservoir {
    fn empty(count: u32) -> Self {
        Self { light: NONE, count, weight: 0.0 }
    }

    /// Emptied where the weight overflowed.
    fn of(light: u32, count: u32, weight: f64) -> Self {
        if weight.is_finite() { Self { light, count, weight } } else { Self::empty(count) }
    }

    /// Whether it can be merged: one that went wrong, however it did, ends here.
    fn is_sound(&self, lights: usize) -> bool {
        self.weight.is_finite()
            && self.weight >= 0.0
            && (self.weight == 0.0 || (self.light as usize) < lights)
    }
}

impl Reference {
    pub fn new(settings: &Reservoirs, world: &Arc<World>) -> Result<Self, LightsError> {
        Ok(Self {
            world: Arc::clone(world),
            plan: Plan::new(settings)?,
            table: Table::new(&weights(&world.lights))?,
            seed: 0,
            before: None,
            radiance: Vec::new(),
            work: Work::default(),
        })
    }

    /// Unshadowed luminance at a point: what candidates are kept by.
    fn target(&self, point: &Point, light: u32, work: &mut Work) -> f64 {
        work.lights += 1;
        let value =
            luminance(radiance(point, &self.world.lights[light as usize], self.world.clamp_m));
        if value.is_finite() { value } else { 0.0 }
    }

    fn sees(&self, point: &Point, light: u32, work: &mut Work) -> bool {
        if self.world.occluders.is_some() {
            work.rays += 1;
        }
        self.world.sees(point, &self.world.lights[light as usize])
    }

    /// One of the candidates (algorithm 3), emptied where its light is not seen.
    fn candidates(&self, point: &Point, index: usize, pixel: usize, work: &mut Work) -> Reservoir {
        let count = self.plan.candidates;
        let mut kept = Reservoir::empty(count);
        if self.table.slots.is_empty() {
            return kept;
        }
        let mut random = Stream::Candidates.of(self.seed, index, pixel);
        let (mut sum, mut target_of_kept) = (0.0, 0.0);
        for _ in 0..count {
            work.samples += 1;
            let (light, _) = self.table.draw(&mut random);
            let target = self.target(point, light, work);
            let weight = target / self.table.probability[light as usize];
            sum += weight;
            if f64::from(random.unit()) * sum < weight {
                (kept.light, target_of_kept) = (light, target);
            }
        }
        if kept.light == NONE || !self.sees(point, kept.light, work) {
            return Reservoir::empty(count);
        }
        Reservoir::of(kept.light, count, sum / (target_of_kept * f64::from(count)))
    }

    /// One of several reservoirs (algorithm 4, with MIS weights where unbiased), emptied where its
    /// light is not seen.
    fn merge(&self, point: &Point, own: Reservoir, others: &[Other], work: &mut Work) -> Reservoir {
        let count = own.count + others.iter().map(|other| other.reservoir.count).sum::<u32>();
        let mut sum = 0.0;
        let mut kept = None;
        let own_first = std::iter::once((None, own, 0.0));
        let then =
            others.iter().enumerate().map(|(i, other)| (Some(i), other.reservoir, other.unit));
        for (from, reservoir, unit) in own_first.chain(then) {
            if reservoir.weight == 0.0 {
                continue;
            }
            let target = self.target(point, reservoir.light, work);
            if target == 0.0 {
                continue;
            }
            let could = Could::of(self, reservoir.light, own.count, target, others, work);
            let part = if self.plan.unbiased == 0 {
                f64::from(reservoir.count) / f64::from(count)
            } else {
                from.map_or(could.own, |i| could.others[i]) / could.sum()
            };
            let weight = target * reservoir.weight * part;
            sum += weight;
            // The first is kept whatever its unit: 0 is less than its weight.
            if unit * sum < weight {
                kept = Some((reservoir.light, target, from, could));
            }
        }
        let Some((light, target, from, could)) = kept else { return Reservoir::empty(count) };
        if from.is_some() && !self.sees(point, light, work) {
            return Reservoir::empty(count);
        }
        let mut weight = sum / target;
        if self.plan.unbiased != 0 && self.world.occluders.is_some() {
            // Those that do not see the light could not have drawn it.
            let mut seen = could.own;
            for (i, Other { reservoir, point: there, .. }) in others.iter().enumerate() {
                let target = self.target(there, light, work);
                if Some(i) == from || (target > 0.0 && self.sees(there, light, work)) {
                    seen += f64::from(reservoir.count) * target;
                }
            }
            weight *= could.sum() / seen;
        }
        Reservoir::of(light, count, weight)
    }

    /// This frame's reservoir merged with the one before's where the surface was.
    fn over_time(
        &self,
        point: &Point,
        own: Reservoir,
        index: usize,
        pixel: usize,
        work: &mut Work,
    ) -> Reservoir {
        let Some((before, reservoirs)) = self.before.as_ref().filter(|_| self.plan.history > 0)
        else {
            return own;
        };
        let frame = &self.world.frames[*before];
        let Some(at) = pixel_before(frame, point) else { return own };
        if !is_alike(&frame.eye, point, &frame.points[at]) {
            return own;
        }
        let mut reservoir = reservoirs[at];
        if !reservoir.is_sound(self.world.lights.len()) {
            return own;
        }
        reservoir.count = reservoir.count.min(self.plan.history);
        work.reused += 1;
        let unit = Stream::Temporal.of(self.seed, index, pixel).unit().into();
        self.merge(point, own, &[Other { reservoir, point: &frame.points[at], unit }], work)
    }

    /// A pixel's reservoir merged with those of its neighbours.
    fn over_space(
        &self,
        reservoirs: &[Reservoir],
        index: usize,
        pixel: usize,
        work: &mut Work,
    ) -> Reservoir {
        let frame = &self.world.frames[index];
        let point = &frame.points[pixel];
        let random = Stream::Spatial.of(self.seed, index, pixel);
        let size = [frame.width, frame.height];
        let others: Vec<_> = Neighbours::new(&self.plan, random, size, pixel)
            .filter(|(at, _)| is_alike(&frame.eye, point, &frame.points[*at]))
            .filter(|(at, _)| reservoirs[*at].is_sound(self.world.lights.len()))
            .map(|(at, unit)| Other {
                reservoir: reservoirs[at],
                point: &frame.points[at],
                unit: unit.into(),
            })
            .collect();
        work.reused += others.len() as u64;
        if others.is_empty() {
            return reservoirs[pixel];
        }
        self.merge(point, reservoirs[pixel], &others, work)
    }
}

/// Where a point was in an image, as the number of the pixel.
fn pixel_before(frame: &Frame, point: &Point) -> Option<usize> {
    let (at, _) = frame.eye.project(point.position.as_dvec3())?;
    if !(at.min_element() >= 0.0 && at.max_element() < 1.0) {
        return None;
    }
    let column = ((at.x * f64::from(frame.width)) as u32).min(frame.width - 1);
    let row = ((at.y * f64::from(frame.height)) as u32).min(frame.height - 1);
    Some((row * frame.width + column) as usize)
}

/// Whether two points may be of one surface, as an eye sees them.
fn is_alike(eye: &Eye, point: &Point, other: &Point) -> bool {
    if !other.is_there() {
        return false;
    }
    let depth = |p: &Point| (p.position.as_dvec3() - eye.position).dot(eye.forward);
    let (here, there) = (depth(point), depth(other));
    let cosine = point.normal.as_dvec3().dot(other.normal.as_dvec3());
    cosine >= LEAST_COSINE && (there - here).abs() <= DEPTH_SHARE * here.abs()
}

impl Lighting for Reference {
    fn reset(&mut self, seed: u32) -> Result<(), LightsError> {
        self.seed = seed;
        self.before = None;
        Ok(())
    }

    fn shade(&mut self, index: usize, count: bool) -> Result<Times, LightsError> {
        let world = Arc::clone(&self.world);
        let frame = world.frame(index)?;
        let mut work = Work::default();
        let each = || frame.points.iter().enumerate();
        let mut reservoirs = Vec::with_capacity(frame.points.len());
        for (pixel, point) in each() {
            if !point.is_there() {
                reservoirs.push(Reservoir::empty(0));
                continue;
            }
            work.pixels += 1;
            let own = self.candidates(point, index, pixel, &mut work);
            reservoirs.push(self.over_time(point, own, index, pixel, &mut work));
        }
        let merged = each().map(|(pixel, point)| {
            if !point.is_there() {
                return Reservoir::empty(0);
            }
            self.over_space(&reservoirs, index, pixel, &mut work)
        });
        let merged: Vec<_> = merged.collect();
        let shown = each().zip(&merged).map(|((_, point), reservoir)| {
            let Some(light) = world.lights.get(reservoir.light as usize) else {
                return DVec3::ZERO;
            };
            radiance(point, light, world.clamp_m) * reservoir.weight
        });
        self.radiance = shown.collect();
        self.before = Some((index, merged));
        self.work = if count { work } else { Work::default() };
        Ok(Times::new())
    }

    fn read(&mut self, shaded: &mut Shaded) -> Result<(), LightsError> {
        shaded.radiance.clear();
        shaded.radiance.extend(self.radiance.iter().map(|rgb| rgb.as_vec3()));
        shaded.work = self.work;
        shaded.visits.clear();
        Ok(())
    }

    fn bytes(&self) -> u64 {
        let reservoirs = self.before.as_ref().map_or(0, |(_, reservoirs)| reservoirs.len());
        (reservoirs * size_of::<Reservoir>()) as u64 + self.table.bytes()
    }
}
