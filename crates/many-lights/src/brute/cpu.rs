//! The same in f32, all cores: lights are gone through in blocks that stay in the caches while a tile
//! of pixels reads them.

use crate::{
    Frame, Lighting, LightsError, Point, Shaded, Times, Work, World,
    block::{
        BLOCK, Block, DIRECTIONAL, EVERYWHERE, OMNI, ORIENTED, SPOT, blocks, hide, weigh, weighted,
    },
    bound::packed::clamp_squared,
    cut::tile,
};
use glam::{DVec3, Vec3};
use multiversion::multiversion;
use rayon::prelude::*;
use std::sync::Arc;

/// Every light at every pixel, as many at once as the instructions at hand allow.
pub struct Cpu {
    world: Arc<World>,
    kinds: [Vec<Block>; 4],
    tiles: Vec<Tile>,
    /// Columns and rows of the last frame, pixels.
    size: (u32, u32),
    work: Work,
}

/// What the pixels of a tile came out as.
#[derive(Clone)]
struct Tile {
    radiance: [Vec3; tile::LANES],
    rays: u64,
}

impl Cpu {
    /// Ready for the frames of a world.
    pub fn new(world: &Arc<World>) -> Self {
        let tiles = |frame: &Frame| {
            let (columns, rows) = tile::tiles(frame.width, frame.height);
            columns as usize * rows as usize
        };
        let most = world.frames.iter().map(tiles).max().unwrap_or(0);
        Self {
            world: Arc::clone(world),
            kinds: blocks(&world.lights),
            tiles: vec![Tile { radiance: [Vec3::ZERO; tile::LANES], rays: 0 }; most],
            size: (0, 0),
            work: Work::default(),
        }
    }
}

impl Lighting for Cpu {
    fn reset(&mut self, _seed: u32) -> Result<(), LightsError> {
        Ok(())
    }

    fn shade(&mut self, index: usize, count: bool) -> Result<Times, LightsError> {
        let (world, kinds) = (&*self.world, &self.kinds);
        let frame = world.frame(index)?;
        self.size = (frame.width, frame.height);
        let (columns, rows) = tile::tiles(frame.width, frame.height);
        let used = columns as usize * rows as usize;
        self.tiles[..used].par_iter_mut().enumerate().for_each(|(index, out)| {
            let (column, row) = (index as u32 % columns, index as u32 / columns);
            let mut points = [Point::nothing(); tile::LANES];
            let pixels = tile::pixels(frame.width, frame.height, column, row);
            for (point, pixel) in points.iter_mut().zip(pixels) {
                *point = frame.points[pixel];
            }
            light_tile(kinds, &points, world, out);
        });
        self.work = Work::default();
        if count {
            let pixels = frame.points.iter().filter(|p| p.is_there()).count() as u64;
            self.work.pixels = pixels;
            self.work.lights = pixels * world.lights.len() as u64;
            self.work.rays = self.tiles[..used].iter().map(|tile| tile.rays).sum();
        }
        Ok(Times::new())
    }

    fn read(&mut self, shaded: &mut Shaded) -> Result<(), LightsError> {
        let (width, height) = self.size;
        shaded.work = self.work;
        shaded.visits.clear();
        shaded.radiance.clear();
        shaded.radiance.resize(width as usize * height as usize, Vec3::ZERO);
        let columns = tile::tiles(width, height).0.max(1);
        let used = tile::tiles(width, height).1 as usize * columns as usize;
        for (index, tile) in self.tiles.iter().take(used).enumerate() {
            let (column, row) = (index as u32 % columns, index as u32 / columns);
            let pixels = tile::pixels(width, height, column, row);
            for (pixel, radiance) in pixels.zip(tile.radiance) {
                shaded.radiance[pixel] = radiance;
            }
        }
        Ok(())
    }

    fn bytes(&self) -> u64 {
        let blocks: usize = self.kinds.iter().map(|kind| size_of_val(kind.as_slice())).sum();
        (blocks + size_of_val(self.tiles.as_slice())) as u64
    }
}

#[multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512dq+avx512vl+avx2",
    "x86_64+avx2",
    "x86_64+sse4.1",
))]
fn light_tile(
    kinds: &[Vec<Block>; 4],
    points: &[Point; tile::LANES],
    world: &World,
    out: &mut Tile,
) {
    let mut sums = [DVec3::ZERO; tile::LANES];
    out.rays = 0;
    light_kind::<OMNI>(&kinds[OMNI], points, world, &mut sums, &mut out.rays);
    light_kind::<ORIENTED>(&kinds[ORIENTED], points, world, &mut sums, &mut out.rays);
    light_kind::<SPOT>(&kinds[SPOT], points, world, &mut sums, &mut out.rays);
    light_kind::<DIRECTIONAL>(&kinds[DIRECTIONAL], points, world, &mut sums, &mut out.rays);
    for ((out, point), sum) in out.radiance.iter_mut().zip(points).zip(sums) {
        *out = point.albedo * (sum * std::f64::consts::FRAC_1_PI).as_vec3();
    }
}

#[inline(always)]
fn light_kind<const KIND: usize>(
    blocks: &[Block],
    points: &[Point; tile::LANES],
    world: &World,
    sums: &mut [DVec3; tile::LANES],
    rays: &mut u64,
) {
    let clamp_squared = clamp_squared(world.clamp_m);
    let mut weights = [0.0; BLOCK];
    for block in blocks {
        for (point, sum) in points.iter().zip(sums.iter_mut()).filter(|(p, _)| p.is_there()) {
            weigh::<KIND, EVERYWHERE>(block, point, clamp_squared, &mut weights);
            if world.occluders.is_some() {
                *rays += hide(&mut weights, block, point, world);
            }
            for (sum, intensity) in sum.as_mut().iter_mut().zip(&block.intensity) {
                *sum += f64::from(weighted(&weights[..block.used], &intensity[..block.used]));
            }
        }
    }
}
