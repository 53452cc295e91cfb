//! Frames lit by drawn lights, on the processor.

use super::{
    Random,
    lane::Lane,
    light_bvh,
    stochastic::{self, Slot},
    walked::Walked,
};
use crate::{
    Frame, LightBvh, Lighting, LightsError, Shaded, StochasticLightcuts, Times, Work, World,
    cut::tile,
};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::sync::Arc;

/// Added to the seed for the pixels at which cuts of tiles are made.
pub(super) const PIVOT_SEED: u32 = 0x9e37_79b9;

/// What is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    LightBvh(LightBvh),
    Stochastic(StochasticLightcuts),
}

/// Draws lights down one tree.
pub(super) struct Sampler<T> {
    pub kind: Kind,
    pub world: Arc<World>,
    pub walked: T,
    parallel: bool,
    seed: u32,
    counted: bool,
    shaded: Shaded,
    rows: Vec<Row>,
}

/// State of a row of tiles.
#[derive(Debug)]
struct Row {
    slots: Vec<Slot>,
    work: Work,
}

/// A row of tiles, to be lit.
struct Strip<'a> {
    radiance: &'a mut [Vec3],
    visits: &'a mut [u32],
    state: &'a mut Row,
}

/// A cut that a tile shares.
#[derive(Default)]
struct Shared {
    /// Where it was made.
    pixel: Option<usize>,
    visits: u32,
    ended: bool,
}

impl<T: Walked> Sampler<T> {
    /// Allocates for the largest frame. `parallel` changes nothing but the time.
    pub fn new(kind: Kind, world: &Arc<World>, walked: T, parallel: bool) -> Self {
        let pixels = world.frames.iter().map(|frame| frame.points.len()).max().unwrap_or(0);
        let rows = world.frames.iter().map(|frame| frame.height.div_ceil(tile::SIDE)).max();
        let most = match kind {
            Kind::LightBvh(_) => 0,
            // A cut never has more nodes than the tree, and its greatest size is checked once a child.
            Kind::Stochastic(s) => {
                let nodes = walked.roots().iter().map(|&root| walked.size(root) as usize).sum();
                (s.cut as usize).min(nodes).max(walked.roots().len()) + 2
            }
        };
        let row = |_| Row { slots: Vec::with_capacity(most), work: Work::default() };
        let shaded = Shaded {
            radiance: Vec::with_capacity(pixels),
            work: Work::default(),
            visits: Vec::with_capacity(pixels),
        };
        let rows = (0..rows.unwrap_or(0)).map(row).collect();
        let world = Arc::clone(world);
        Self { kind, world, walked, parallel, seed: 0, counted: false, shaded, rows }
    }

    /// Lights the tiles of row `row`, counting where `count`.
    fn light(&self, index: usize, count: bool, row: usize, strip: Strip<'_>) {
        let frame = &self.world.frames[index];
        let Strip { radiance, visits, state } = strip;
        let (columns, _) = tile::tiles(frame.width, frame.height);
        let first = row * tile::SIDE as usize * frame.width as usize;
        state.work = Work::default();
        for column in 0..columns {
            let mut shared = Shared::default();
            if let Kind::Stochastic(settings) = self.kind
                && settings.real_time
            {
                let start = pivot_start(self.seed, index, row as u32 * columns + column);
                let Some(pixel) = pivot(frame, column, row as u32, start) else { continue };
                shared.pixel = Some(pixel);
                shared.ended = stochastic::cut(
                    &self.walked,
                    &settings,
                    &frame.points[pixel],
                    &mut state.slots,
                    &mut shared.visits,
                );
            }
            for pixel in tile::pixels(frame.width, frame.height, column, row as u32) {
                let point = &frame.points[pixel];
                if !point.is_there() {
                    continue;
                }
                let mut lane = Lane {
                    world: &self.world,
                    point,
                    random: Random::new(self.seed, index as u32, pixel as u32),
                    // The tile's cut is that pixel's work.
                    visits: if shared.pixel == Some(pixel) { shared.visits } else { 0 },
                    work: Work::default(),
                };
                let sum = self.draw(&mut lane, &mut state.slots, shared.ended);
                radiance[pixel - first] = sum.as_vec3();
                if count {
                    visits[pixel - first] = lane.visits;
                    let visits = u64::from(lane.visits);
                    state.work += Work { pixels: 1, visits, bounds: visits, ..lane.work };
                }
            }
        }
    }

    /// Radiance of one pixel; `slots` holds the tile's cut where there is one, `ended` by its size.
    fn draw(&self, lane: &mut Lane<'_>, slots: &mut Vec<Slot>, ended: bool) -> DVec3 {
        match &self.kind {
            Kind::LightBvh(settings) => light_bvh::radiance(&self.walked, settings.samples, lane),
            Kind::Stochastic(settings) => {
                let ended = if settings.real_time {
                    ended
                } else {
                    stochastic::cut(&self.walked, settings, lane.point, slots, &mut lane.visits)
                };
                lane.work.cut = slots.len() as u64;
                lane.work.most_cut = slots.len() as u64;
                lane.work.ended = u64::from(ended);
                stochastic::radiance(&self.walked, slots, lane)
            }
        }
    }
}

/// Where the search for the pixel starts at which a tile's cut is made: a place of 8 x 8 by chance.
pub(super) fn pivot_start(seed: u32, index: usize, tile: u32) -> u32 {
    Random::new(seed.wrapping_add(PIVOT_SEED), index as u32, tile).bits() >> 26
}

/// The first pixel that shows anything, from place `start` of a tile on and round.
pub(super) fn pivot(frame: &Frame, column: u32, row: u32, start: u32) -> Option<usize> {
    (0..tile::LANES as u32).find_map(|step| {
        let lane = (start + step) % tile::LANES as u32;
        let (x, y) =
            (column * tile::SIDE + lane % tile::SIDE, row * tile::SIDE + lane / tile::SIDE);
        let pixel = y as usize * frame.width as usize + x as usize;
        let inside = x < frame.width && y < frame.height;
        (inside && frame.points[pixel].is_there()).then_some(pixel)
    })
}

impl<T: Walked> Lighting for Sampler<T> {
    fn reset(&mut self, seed: u32) -> Result<(), LightsError> {
        self.seed = seed;
        Ok(())
    }

    fn shade(&mut self, index: usize, count: bool) -> Result<Times, LightsError> {
        let world = Arc::clone(&self.world);
        let frame = world.frame(index)?;
        let mut shaded = std::mem::take(&mut self.shaded);
        let mut states = std::mem::take(&mut self.rows);
        shaded.clear(frame.points.len(), true);
        let pixels = (frame.width as usize * tile::SIDE as usize).max(1);
        let strips = shaded.radiance.chunks_mut(pixels).zip(shaded.visits.chunks_mut(pixels));
        if self.parallel {
            let strips = shaded.radiance.par_chunks_mut(pixels);
            let strips = strips.zip(shaded.visits.par_chunks_mut(pixels)).zip(&mut states);
            strips.enumerate().for_each(|(row, ((radiance, visits), state))| {
                self.light(index, count, row, Strip { radiance, visits, state });
            });
        } else {
            for (row, ((radiance, visits), state)) in strips.zip(&mut states).enumerate() {
                self.light(index, count, row, Strip { radiance, visits, state });
            }
        }
        if count {
            for state in &states[..frame.height.div_ceil(tile::SIDE) as usize] {
                shaded.work += state.work;
            }
            shaded.work.lane_visits = tile::lane_visits(frame.width, frame.height, &shaded.visits);
        }
        (self.shaded, self.rows, self.counted) = (shaded, states, count);
        Ok(Times::new())
    }

    fn read(&mut self, shaded: &mut Shaded) -> Result<(), LightsError> {
        shaded.copy_from(&self.shaded);
        if !self.counted {
            shaded.visits.clear();
        }
        Ok(())
    }

    fn bytes(&self) -> u64 {
        let slots: usize = self.rows.iter().map(|row| row.slots.capacity()).sum();
        self.walked.bytes() + (slots * size_of::<Slot>()) as u64
    }
}
