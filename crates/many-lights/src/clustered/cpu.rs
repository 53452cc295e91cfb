//! Clustered shading in f32, tiles and rows in parallel.

use super::{Cell, Grid, Hierarchy, tile_cells};
use crate::{
    Clustered, Frame, Lighting, LightsError, Point, Shaded, Times, Work, World,
    bound::packed::{clamp_squared, estimate},
};
use glam::Vec3;
use rayon::prelude::*;
use std::sync::Arc;

/// Terms that are summed before they join the sum: a running sum over many lights would lose them.
const PARTIAL: usize = 64;

/// The cells of a tile and their lights, one list after another.
#[derive(Clone, Debug, Default)]
struct Tile {
    cells: Vec<Cell>,
    /// Where each cell's lights begin, and the end.
    first: Vec<usize>,
    list: Vec<u32>,
}

/// Clustered shading as f32 has it.
pub struct Cpu {
    world: Arc<World>,
    hierarchy: Hierarchy,
    grids: Vec<Grid>,
    tiles: Vec<Tile>,
    window: bool,
    shaded: Shaded,
}

impl Cpu {
    /// Ready for all frames of a world. Lists grow as long as they have to, and keep their memory.
    ///
    /// # Errors
    /// Too many cells.
    pub fn new(world: &Arc<World>, settings: &Clustered) -> Result<Self, LightsError> {
        let grids = world.frames.iter().map(|frame| Grid::of(frame, settings));
        Ok(Self {
            world: Arc::clone(world),
            hierarchy: Hierarchy::new(&world.lights, settings.cutoff),
            grids: grids.collect::<Result<_, _>>()?,
            tiles: Vec::new(),
            window: settings.window,
            shaded: Shaded::default(),
        })
    }

    /// Sorts points into cells and lists lights.
    fn assign(&mut self, grid: &Grid, frame: &Frame) {
        self.tiles.resize(grid.tiles(), Tile::default());
        let hierarchy = &self.hierarchy;
        self.tiles.par_iter_mut().enumerate().for_each(|(index, tile)| {
            tile.cells.resize(grid.slices as usize, Cell::EMPTY);
            tile_cells(grid, frame, index, &mut tile.cells);
            tile.list.clear();
            tile.first.clear();
            tile.first.push(0);
            for cell in &tile.cells {
                hierarchy.list(cell, &mut tile.list);
                tile.first.push(tile.list.len());
            }
        });
    }

    /// What the lights of its cell give at a pixel; its work is added.
    fn light(&self, grid: &Grid, frame: &Frame, pixel: usize, work: &mut Work) -> Vec3 {
        let point = &frame.points[pixel];
        if !point.is_there() {
            return Vec3::ZERO;
        }
        let tile = &self.tiles[grid.tile_of(frame, pixel)];
        let slice = grid.slice_of(frame, point);
        let list = &tile.list[tile.first[slice]..tile.first[slice + 1]];
        work.pixels += 1;
        work.lights += list.len() as u64;
        let mut sum = Vec3::ZERO;
        for lights in list.chunks(PARTIAL) {
            let mut partial = Vec3::ZERO;
            for &place in lights {
                partial += self.one(point, place as usize, &mut work.rays);
            }
            sum += partial;
        }
        sum
    }

    fn one(&self, point: &Point, place: usize, rays: &mut u64) -> Vec3 {
        let node = &self.hierarchy.lights[place];
        let squared = (node.position - point.position).length_squared();
        let share = self.hierarchy.reaches[place].share(squared, self.window);
        if share == 0.0 {
            return Vec3::ZERO;
        }
        let given = estimate(node, point, clamp_squared(self.world.clamp_m)) * share;
        if self.world.occluders.is_some() && given != Vec3::ZERO {
            *rays += 1;
            if !self.world.sees(point, &self.world.lights[node.light as usize]) {
                return Vec3::ZERO;
            }
        }
        given
    }
}

impl Lighting for Cpu {
    fn reset(&mut self, _seed: u32) -> Result<(), LightsError> {
        Ok(())
    }

    fn shade(&mut self, index: usize, count: bool) -> Result<Times, LightsError> {
        let world = Arc::clone(&self.world);
        let frame = world.frame(index)?;
        let grid = self.grids[index];
        self.assign(&grid, frame);
        let mut radiance = std::mem::take(&mut self.shaded.radiance);
        radiance.resize(frame.points.len(), Vec3::ZERO);
        let width = frame.width.max(1) as usize;
        let rows = radiance.par_chunks_mut(width).enumerate().map(|(row, out)| {
            let mut work = Work::default();
            for (column, out) in out.iter_mut().enumerate() {
                *out = self.light(&grid, frame, row * width + column, &mut work);
            }
            work
        });
        let mut work = rows.reduce(Work::default, |mut a, b| {
            a += b;
            a
        });
        self.shaded.radiance = radiance;
        work.entries = self.tiles.iter().map(|tile| tile.list.len() as u64).sum();
        self.shaded.work = if count { work } else { Work::default() };
        Ok(Times::new())
    }

    fn read(&mut self, shaded: &mut Shaded) -> Result<(), LightsError> {
        shaded.clone_from(&self.shaded);
        Ok(())
    }

    fn bytes(&self) -> u64 {
        let held =
            |tile: &Tile| size_of::<Cell>() * tile.cells.capacity() + 4 * tile.list.capacity();
        self.hierarchy.bytes() + self.tiles.iter().map(held).sum::<usize>() as u64
    }
}
