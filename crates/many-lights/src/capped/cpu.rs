//! The cap in f32, rows of tiles in parallel: a tile's lights are gathered side by side, and light its
//! pixels one after another.

use super::{Groups, Lists};
use crate::{
    Capped, Frame, LightTree, Lighting, LightsError, Shaded, Times, Work, World,
    block::{Listed, Reached},
    bound::packed::clamp_squared,
    cut::tile::{self, SIDE},
    pool::Pool,
};
use glam::Vec3;
use rayon::prelude::*;
use std::sync::Arc;

/// The cap as f32 has it.
pub struct Cpu {
    world: Arc<World>,
    groups: Groups,
    most: usize,
    clamp_squared: f32,
    lists: Lists,
    pool: Pool<Listed>,
    shaded: Shaded,
}

impl Cpu {
    /// Ready for all frames of a world.
    ///
    /// # Errors
    /// A tree of other lights.
    pub fn new(
        world: &Arc<World>,
        tree: &Arc<LightTree>,
        settings: &Capped,
    ) -> Result<Self, LightsError> {
        tree.check_number(&world.lights)?;
        Ok(Self {
            world: Arc::clone(world),
            groups: Groups::new(&tree.pack()),
            most: (settings.most as usize).min(world.lights.len()),
            clamp_squared: clamp_squared(world.clamp_m),
            lists: Lists::default(),
            pool: Pool::new(|| Listed::new(Reached::Everywhere)),
            shaded: Shaded::default(),
        })
    }

    /// Lights a row of tiles; `radiance` is its pixels.
    fn light(&self, frame: &Frame, row: usize, radiance: &mut [Vec3]) -> Work {
        let mut listed = self.pool.own();
        let mut work = Work::default();
        let above = row * SIDE as usize * frame.width as usize;
        for column in 0..tile::tiles(frame.width, frame.height).0 {
            let lights = self.lists.of(column as usize, row);
            listed.clear();
            for &light in lights {
                let place = self.groups.places[light as usize];
                listed.push(&self.groups.lights[place as usize], 0.0);
            }
            for pixel in tile::pixels(frame.width, frame.height, column, row as u32) {
                let point = &frame.points[pixel];
                if !point.is_there() {
                    continue;
                }
                let (given, rays) = listed.light(point, &self.world, self.clamp_squared);
                radiance[pixel - above] = given;
                work += Work { pixels: 1, lights: lights.len() as u64, rays, ..Work::default() };
            }
        }
        work
    }
}

impl Lighting for Cpu {
    fn reset(&mut self, _seed: u32) -> Result<(), LightsError> {
        Ok(())
    }

    fn shade(&mut self, index: usize, count: bool) -> Result<Times, LightsError> {
        let frame = self.world.frame(index)?;
        self.lists.fill(&self.groups, frame, self.most, self.clamp_squared);
        let mut shaded = std::mem::take(&mut self.shaded);
        shaded.clear(frame.points.len(), false);
        let row_of_tiles = SIDE as usize * frame.width.max(1) as usize;
        let rows = shaded.radiance.par_chunks_mut(row_of_tiles).enumerate();
        let work = rows.map(|(row, radiance)| self.light(frame, row, radiance));
        let mut work = work.reduce(Work::default, |mut a, b| {
            a += b;
            a
        });
        work += self.lists.work();
        shaded.work = if count { work } else { Work::default() };
        self.shaded = shaded;
        Ok(Times::new())
    }

    fn read(&mut self, shaded: &mut Shaded) -> Result<(), LightsError> {
        shaded.copy_from(&self.shaded);
        Ok(())
    }

    fn bytes(&self) -> u64 {
        self.groups.bytes() + self.lists.bytes()
    }
}
