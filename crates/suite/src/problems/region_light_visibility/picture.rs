//! A plan of the city, for people: which lights a face keeps.

use super::{
    faces::Question,
    truth::{FaceTruth, Sighted},
};
use crate::{night::Night, problem::Picture};
use dapple_many_lights::region::truth::kept;
use glam::DVec2;

/// Pixels of the longer side.
const SIZE: u32 = 256;

/// Buildings; the cell; a light that is hidden or left out, and one that is seen or kept.
const WALL: f32 = 0.15;
const CELL: f32 = 0.5;
const DARK: f32 = 0.35;
const LIT: f32 = 1.0;

/// Seen from above, north up: buildings, the cell, and the lights that were looked at: in the truth,
/// those seen; in the result, those kept.
pub fn plan(night: &Night, question: &Question, face: &FaceTruth, precut: &[u32]) -> Picture {
    let town = &night.town;
    let world = town.world(false);
    let flat = |at: glam::DVec3| DVec2::new(at.x, at.z);
    let mut map = Map::around(
        night
            .city
            .buildings
            .iter()
            .flat_map(|b| [b.outer.min, b.outer.max].map(|corner| flat(corner - world.origin))),
    );
    for building in &night.city.buildings {
        let [low, high] = [building.outer.min, building.outer.max].map(|c| flat(c - world.origin));
        map.fill(low, high, WALL);
    }
    if let Some(face) = question.cell.cell.face(question.direction) {
        map.fill(flat(face.region.min), flat(face.region.max), CELL);
    }
    let mut result = map.clone();
    let kept = kept(&town.lights, precut);
    for (light, sighted) in &face.lights {
        let at = flat(world.lights[*light as usize].position);
        map.mark(at, if *sighted == Sighted::Hidden { DARK } else { LIT });
        result.mark(at, if kept[*light as usize] { LIT } else { DARK });
    }
    let [width, height] = map.size;
    Picture { width, height, truth: map.values, result: result.values }
}

#[derive(Clone)]
struct Map {
    low: DVec2,
    /// Metres a pixel.
    step: f64,
    /// Columns and rows.
    size: [u32; 2],
    values: Vec<f32>,
}

impl Map {
    fn around(corners: impl Iterator<Item = DVec2> + Clone) -> Self {
        let low = corners.clone().fold(DVec2::INFINITY, DVec2::min);
        let high = corners.fold(DVec2::NEG_INFINITY, DVec2::max);
        let sides = high - low;
        let step = sides.max_element().max(1.0) / f64::from(SIZE - 1);
        let size = [sides.x, sides.y].map(|side| (side / step).round() as u32 + 1);
        let values = vec![0.0; size[0] as usize * size[1] as usize];
        Self { low, step, size, values }
    }

    fn pixel(&self, at: DVec2) -> [u32; 2] {
        // What lies outside lands on the rim.
        let place = ((at - self.low) / self.step).round();
        let within = |p: f64, count: u32| p.clamp(0.0, f64::from(count - 1)) as u32;
        [within(place.x, self.size[0]), within(place.y, self.size[1])]
    }

    fn fill(&mut self, low: DVec2, high: DVec2, value: f32) {
        let ([x0, y0], [x1, y1]) = (self.pixel(low), self.pixel(high));
        for y in y0..=y1 {
            self.values[(y * self.size[0] + x0) as usize..=(y * self.size[0] + x1) as usize]
                .fill(value);
        }
    }

    fn mark(&mut self, at: DVec2, value: f32) {
        let [x, y] = self.pixel(at);
        let pixel = &mut self.values[(y * self.size[0] + x) as usize];
        // Where several share a pixel, the brightest shows.
        *pixel = pixel.max(value);
    }
}
