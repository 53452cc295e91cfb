//! Clustered shading in f64: every light is held against every cell.

use super::{Cell, Grid, cells, reach_m, window};
use crate::{Clustered, Lighting, LightsError, Shaded, Times, Work, World, radiance};
use crate::{Point, light::Emission};
use glam::DVec3;
use std::sync::Arc;

/// Lights of cells: those of cell `i` are `lights[first[i]..first[i + 1]]`, in increasing order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Lists {
    /// One a cell, and the end.
    pub first: Vec<usize>,
    /// Indices of lights.
    pub lights: Vec<u32>,
}

impl Lists {
    /// Lights of a cell.
    pub fn of(&self, cell: usize) -> &[u32] {
        &self.lights[self.first[cell]..self.first[cell + 1]]
    }
}

/// Lists each light in every cell whose box lies within its reach and its cone.
pub fn lists(world: &World, cells: &[Cell], cutoff: f64) -> Lists {
    let reaches: Vec<_> = world.lights.iter().map(|light| reach_m(light, cutoff)).collect();
    let mut lists = Lists { first: vec![0], ..Lists::default() };
    for cell in cells {
        let (min, max) = (cell.min.as_dvec3(), cell.max.as_dvec3());
        for (index, (light, reach)) in world.lights.iter().zip(&reaches).enumerate() {
            let outside = (min - light.position).max(light.position - max).max(DVec3::ZERO);
            let near = light.emission == Emission::Directional
                || outside.length_squared() <= reach * reach;
            if *reach > 0.0 && near && !cell.is_empty() && light.shines_into(min, max) {
                lists.lights.push(index as u32);
            }
        }
        lists.first.push(lists.lights.len());
    }
    lists
}

/// Clustered shading as f64 has it.
pub struct Reference {
    world: Arc<World>,
    settings: Clustered,
    grids: Vec<Grid>,
    shaded: Shaded,
    bytes: u64,
}

impl Reference {
    /// Ready for all frames of a world.
    ///
    /// # Errors
    /// Too many cells.
    pub fn new(world: &Arc<World>, settings: &Clustered) -> Result<Self, LightsError> {
        let grids = world.frames.iter().map(|frame| Grid::of(frame, settings));
        Ok(Self {
            world: Arc::clone(world),
            settings: *settings,
            grids: grids.collect::<Result<_, _>>()?,
            shaded: Shaded::default(),
            bytes: 0,
        })
    }

    /// What lights of a list give at a point; rays are added to `rays`.
    fn light(&self, point: &Point, list: &[u32], rays: &mut u64) -> DVec3 {
        let world = &*self.world;
        let mut sum = DVec3::ZERO;
        for &index in list {
            let light = &world.lights[index as usize];
            let mut given = radiance(point, light, world.clamp_m);
            if light.emission != Emission::Directional {
                let squared = (light.position - point.position.as_dvec3()).length_squared();
                let reach_squared = reach_m(light, self.settings.cutoff).powi(2);
                if squared > reach_squared {
                    continue;
                }
                given *= if self.settings.window { window(squared, reach_squared) } else { 1.0 };
            }
            if given == DVec3::ZERO {
                continue;
            }
            *rays += u64::from(world.occluders.is_some());
            if world.sees(point, light) {
                sum += given;
            }
        }
        sum
    }
}

impl Lighting for Reference {
    fn reset(&mut self, _seed: u32) -> Result<(), LightsError> {
        Ok(())
    }

    fn shade(&mut self, index: usize, count: bool) -> Result<Times, LightsError> {
        let world = Arc::clone(&self.world);
        let frame = world.frame(index)?;
        let grid = self.grids[index];
        let cells = cells(&grid, frame);
        let lists = lists(&world, &cells, self.settings.cutoff);
        let mut work = Work { entries: lists.lights.len() as u64, ..Work::default() };
        self.shaded.radiance.clear();
        for (pixel, point) in frame.points.iter().enumerate() {
            let mut sum = DVec3::ZERO;
            if point.is_there() {
                let list = lists.of(grid.cell_of(frame, pixel));
                work.pixels += 1;
                work.lights += list.len() as u64;
                sum = self.light(point, list, &mut work.rays);
            }
            self.shaded.radiance.push(sum.as_vec3());
        }
        self.shaded.work = if count { work } else { Work::default() };
        self.bytes = (size_of_val(&*cells) + 4 * lists.lights.len()) as u64;
        Ok(Times::new())
    }

    fn read(&mut self, shaded: &mut Shaded) -> Result<(), LightsError> {
        shaded.clone_from(&self.shaded);
        Ok(())
    }

    fn bytes(&self) -> u64 {
        self.bytes + size_of_val(&*self.world.lights) as u64
    }
}
