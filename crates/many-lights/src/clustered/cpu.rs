//! Clustered shading in f32, tiles in parallel: a cell's lights are gathered side by side, and light
//! its points one after another.

use super::{Cell, Grid, Hierarchy, cells::tile_cells};
use crate::{
    Clustered, Frame, Lighting, LightsError, Shaded, Times, Work, World,
    block::{Listed, Reached},
    bound::packed::clamp_squared,
    pool::Pool,
};
use glam::Vec3;
use rayon::prelude::*;
use std::sync::Arc;

/// The cells of a tile and their lights, one list after another, and what its pixels came out as.
#[derive(Clone, Debug, Default)]
struct Tile {
    cells: Vec<Cell>,
    list: Vec<u32>,
    /// Of pixels that show anything, in order of cells: the slice above, the pixel's number below.
    pixels: Vec<u64>,
    /// What they came out as.
    radiance: Vec<Vec3>,
    work: Work,
}

/// Clustered shading as f32 has it.
pub struct Cpu {
    world: Arc<World>,
    hierarchy: Hierarchy,
    grids: Vec<Grid>,
    tiles: Vec<Tile>,
    pool: Pool<Listed>,
    /// The frame that was lit last.
    last: usize,
    counted: bool,
}

impl Cpu {
    /// Ready for all frames of a world. Lists grow as long as they have to, and keep their memory.
    ///
    /// # Errors
    /// Too many cells.
    pub fn new(world: &Arc<World>, settings: &Clustered) -> Result<Self, LightsError> {
        let grids = world.frames.iter().map(|frame| Grid::of(frame, settings));
        let grids = grids.collect::<Result<Vec<_>, _>>()?;
        let tiles = grids.iter().map(Grid::tiles).max().unwrap_or(0);
        let reached = if settings.window { Reached::Faded } else { Reached::Cut };
        Ok(Self {
            world: Arc::clone(world),
            hierarchy: Hierarchy::new(&world.lights, settings.cutoff),
            grids,
            tiles: vec![Tile::default(); tiles],
            pool: Pool::new(|| Listed::new(reached)),
            last: 0,
            counted: false,
        })
    }
}

impl Tile {
    /// Sorts points into cells, lists their lights, and lights them.
    fn light(&mut self, index: usize, grid: &Grid, frame: &Frame, cpu: &Cpu) {
        let Cpu { world, hierarchy, .. } = cpu;
        let clamp_squared = clamp_squared(world.clamp_m);
        self.clear();
        self.cells.resize(grid.slices as usize, Cell::EMPTY);
        tile_cells(grid, frame, index, &mut self.cells, |pixel, slice| {
            self.pixels.push((slice as u64) << 32 | pixel as u64);
        });
        self.pixels.sort_unstable();
        let mut listed = cpu.pool.own();
        for of_cell in self.pixels.chunk_by(|a, b| a >> 32 == b >> 32) {
            let before = self.list.len();
            hierarchy.list(&self.cells[(of_cell[0] >> 32) as usize], &mut self.list);
            listed.clear();
            for &place in &self.list[before..] {
                let place = place as usize;
                listed.push(&hierarchy.lights[place], hierarchy.reaches[place].squared);
            }
            let lights = (self.list.len() - before) as u64;
            for &pixel in of_cell {
                let point = &frame.points[pixel as u32 as usize];
                let (radiance, rays) = listed.light(point, world, clamp_squared);
                self.radiance.push(radiance);
                self.work += Work { pixels: 1, lights, rays, ..Work::default() };
            }
        }
        self.work.entries = self.list.len() as u64;
    }

    fn clear(&mut self) {
        self.pixels.clear();
        self.radiance.clear();
        self.list.clear();
        self.work = Work::default();
    }
}

impl Lighting for Cpu {
    fn reset(&mut self, _seed: u32) -> Result<(), LightsError> {
        Ok(())
    }

    fn shade(&mut self, index: usize, count: bool) -> Result<Times, LightsError> {
        let frame = self.world.frame(index)?;
        let grid = &self.grids[index];
        let mut tiles = std::mem::take(&mut self.tiles);
        let (used, unused) = tiles.split_at_mut(grid.tiles());
        used.par_iter_mut().enumerate().for_each(|(index, tile)| {
            tile.light(index, grid, frame, self);
        });
        unused.iter_mut().for_each(Tile::clear);
        self.tiles = tiles;
        self.last = index;
        self.counted = count;
        Ok(Times::new())
    }

    fn read(&mut self, shaded: &mut Shaded) -> Result<(), LightsError> {
        shaded.clear(self.world.frame(self.last)?.points.len(), false);
        for tile in &self.tiles {
            for (&pixel, &radiance) in tile.pixels.iter().zip(&tile.radiance) {
                shaded.radiance[pixel as u32 as usize] = radiance;
            }
            if self.counted {
                shaded.work += tile.work;
            }
        }
        Ok(())
    }

    fn bytes(&self) -> u64 {
        let held = |tile: &Tile| {
            size_of::<Cell>() * tile.cells.capacity()
                + 4 * tile.list.capacity()
                + 8 * tile.pixels.capacity()
                + size_of::<Vec3>() * tile.radiance.capacity()
        };
        self.hierarchy.bytes() + self.tiles.iter().map(held).sum::<usize>() as u64
    }
}
