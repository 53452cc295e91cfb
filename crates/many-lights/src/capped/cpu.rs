//! The cap in f32, rows of tiles, then rows of pixels in parallel.

use super::{Lists, check};
use crate::{
    Capped, LightTree, Lighting, LightsError, PackedTree, Point, Shaded, Times, Work, World,
    bound::packed::{clamp_squared, estimate},
    cut::tile::SIDE,
};
use glam::Vec3;
use rayon::prelude::*;
use std::sync::Arc;

/// Terms that are summed before they join the sum: a running sum over many lights would lose them.
const PARTIAL: usize = 64;

/// The cap as f32 has it.
pub struct Cpu {
    world: Arc<World>,
    tree: PackedTree,
    /// Node of each light.
    leaves: Vec<u32>,
    most: usize,
    clamp_squared: f32,
    lists: Lists,
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
        check(world, tree)?;
        Ok(Self {
            world: Arc::clone(world),
            tree: tree.pack(),
            leaves: tree.leaves.clone(),
            most: settings.most as usize,
            clamp_squared: clamp_squared(world.clamp_m),
            lists: Lists::default(),
            shaded: Shaded::default(),
        })
    }

    fn light(&self, point: &Point, lights: &[u32], work: &mut Work) -> Vec3 {
        let mut sum = Vec3::ZERO;
        work.pixels += 1;
        work.lights += lights.len() as u64;
        for lights in lights.chunks(PARTIAL) {
            let mut partial = Vec3::ZERO;
            for &index in lights {
                let node = &self.tree.nodes[self.leaves[index as usize] as usize];
                let given = estimate(node, point, self.clamp_squared);
                if self.world.occluders.is_some() && given != Vec3::ZERO {
                    work.rays += 1;
                    if !self.world.sees(point, &self.world.lights[index as usize]) {
                        continue;
                    }
                }
                partial += given;
            }
            sum += partial;
        }
        sum
    }
}

impl Lighting for Cpu {
    fn reset(&mut self, _seed: u32) -> Result<(), LightsError> {
        Ok(())
    }

    fn shade(&mut self, index: usize, count: bool) -> Result<Times, LightsError> {
        let world = Arc::clone(&self.world);
        let frame = world.frame(index)?;
        self.lists.fill(&self.tree, frame, self.most, self.clamp_squared);
        let mut radiance = std::mem::take(&mut self.shaded.radiance);
        radiance.resize(frame.points.len(), Vec3::ZERO);
        let (width, side) = (frame.width.max(1) as usize, SIDE as usize);
        let rows = radiance.par_chunks_mut(width).zip(frame.points.par_chunks(width));
        let work = rows.enumerate().map(|(row, (out, points))| {
            let mut work = Work::default();
            for (column, (out, point)) in out.iter_mut().zip(points).enumerate() {
                *out = Vec3::ZERO;
                if point.is_there() {
                    let lights = self.lists.of(column / side, row / side);
                    *out = self.light(point, lights, &mut work);
                }
            }
            work
        });
        let mut work = work.reduce(Work::default, |mut a, b| {
            a += b;
            a
        });
        work += self.lists.work();
        self.shaded.radiance = radiance;
        self.shaded.work = if count { work } else { Work::default() };
        Ok(Times::new())
    }

    fn read(&mut self, shaded: &mut Shaded) -> Result<(), LightsError> {
        shaded.clone_from(&self.shaded);
        Ok(())
    }

    fn bytes(&self) -> u64 {
        let tree = size_of_val(&*self.tree.nodes) + size_of_val(&*self.leaves);
        tree as u64 + self.lists.bytes()
    }
}
