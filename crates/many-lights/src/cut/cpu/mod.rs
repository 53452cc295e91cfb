//! Cuts in f32, in parallel over rows of tiles. Nothing is allocated while a frame is lit.
#![allow(clippy::needless_range_loop, reason = "lanes side by side become vectors")]

mod lanes;
mod packet;
mod vector;

use super::{
    Starting, Starts,
    given::{Given, Method},
    lightcuts::{self, Member, Open},
    rule::Rule,
    tile,
};
use crate::{
    Frame, Light, LightTree, Lightcuts, Lighting, LightsError, PackedTree, Point, Shaded, Times,
    Work,
    bound::packed::{self, PackedRegion},
    pool::Pool,
};
use glam::Vec3;
use lanes::{Tile, WIDTH};
use packet::{Lit, Walk};
use rayon::prelude::*;

/// The processor's form of all techniques that make cuts.
pub struct Cpu {
    given: Given,
    tree: PackedTree,
    shaded: Shaded,
    /// One a thread.
    pool: Pool<Scratch>,
}

/// What a thread works in.
struct Scratch {
    tile: Tile,
    lit: Lit,
    open: Open,
}

impl Cpu {
    /// Made ready: the tree packed, memory for every thread of the current pool.
    pub fn new(given: Given) -> Self {
        let scratch = || Scratch { tile: Tile::default(), lit: Lit::default(), open: given.open() };
        let pool = Pool::new(scratch);
        let mut shaded = Shaded::default();
        shaded.clear(given.pixels(), true);
        Self { tree: given.tree.pack(), shaded, pool, given }
    }

    /// For cuts of more starts than before: frames take no memory.
    fn make_room(&self) {
        if let Method::Worst(settings) = self.given.method {
            let most = self.given.most_open(&settings);
            self.pool.all().for_each(|mut scratch| scratch.open.reserve(most));
        }
    }

    /// Lights the pixels of a tile.
    fn light<const COUNT: bool>(&self, scratch: &mut Scratch) {
        let Scratch { tile, lit, open } = scratch;
        *lit = Lit::default();
        let clamp_squared = packed::clamp_squared(self.given.world.clamp_m);
        let shadows = self.given.world.occluders.is_some().then_some(&self.given);
        let nodes = &self.tree.nodes[..];
        // Lanes that start alike walk together.
        let mut left = tile.there;
        while left != 0 {
            let range = |lane: usize| self.given.starts.range(tile.points[lane].object);
            let first = range(left.trailing_zeros() as usize);
            let alike = Tile::lanes(left).filter(|&lane| range(lane) == first);
            let group = alike.fold(0, |group, lane| group | 1 << lane);
            left &= !group;
            let starts = self.given.entries(first);
            match self.given.method {
                Method::Rule(rule, form) => {
                    let walk = Walk { nodes, rule, form, clamp_squared, shadows };
                    packet::by_pixel::<COUNT>(&walk, starts, tile, group, lit);
                }
                Method::Tile { threshold, form } => {
                    let rule = Rule::Absolute(threshold);
                    let walk = Walk { nodes, rule, form, clamp_squared, shadows };
                    let points = Tile::lanes(group).map(|lane| &tile.points[lane]);
                    if let Some(region) = PackedRegion::of(points) {
                        packet::by_tile::<COUNT>(&walk, starts, tile, group, &region, lit);
                    }
                }
                Method::Worst(settings) => {
                    for lane in Tile::lanes(group) {
                        self.by_worst(&settings, &tile.points[lane], lane, open, lit);
                    }
                }
            }
        }
    }

    /// R1, R2 at one pixel.
    fn by_worst(
        &self,
        settings: &Lightcuts,
        point: &Point,
        lane: usize,
        open: &mut Open,
        lit: &mut Lit,
    ) {
        let world = &*self.given.world;
        let clamp_squared = packed::clamp_squared(world.clamp_m);
        let mut work = Work::default();
        let evaluate = |index: u32| {
            let node = &self.tree.nodes[index as usize];
            let leaf = node.size == 1;
            work.look(leaf, true);
            let mut estimate = packed::estimate(node, point, clamp_squared);
            if world.occluders.is_some() && estimate != Vec3::ZERO {
                work.rays += 1;
                if !self.given.sees(point, node.light) {
                    estimate = Vec3::ZERO;
                }
            }
            let bound = match leaf {
                true => 0.0,
                false => packed::point(settings.bound, node, point, clamp_squared),
            };
            Member { node: index, estimate: estimate.as_dvec3(), bound: f64::from(bound) }
        };
        let size = |node: u32| self.tree.nodes[node as usize].size;
        let starts = self.given.entries_of(point);
        let found = lightcuts::cut(settings, starts, size, evaluate, |_| (), open);
        lit.set(lane, found.radiance.as_vec3(), work.visits as u32, found.nodes as u32);
        work.visits = 0;
        work.ended = u64::from(found.ended);
        lit.work += work;
    }

    /// Lights a row of tiles; the slices are its rows of pixels.
    fn row<const COUNT: bool>(
        &self,
        frame: &Frame,
        row: u32,
        radiance: &mut [Vec3],
        visits: &mut [u32],
    ) -> Work {
        let mut scratch = self.pool.own();
        let mut work = Work::default();
        let first = (row * tile::SIDE * frame.width) as usize;
        for column in 0..tile::tiles(frame.width, frame.height).0 {
            scratch.tile.load(frame, column, row);
            self.light::<COUNT>(&mut scratch);
            let Scratch { tile, lit, .. } = &*scratch;
            let mut longest = 0;
            for lane in Tile::lanes(tile.there) {
                let pixel = tile.pixels[lane] as usize - first;
                let (y, x) = (lane / WIDTH, lane % WIDTH);
                radiance[pixel] = lit.sums[y].of_lane(x);
                if COUNT {
                    let (looked, cut) = (lit.visits[y][x], u64::from(lit.cut[y][x]));
                    visits[pixel] = looked;
                    longest = longest.max(looked);
                    let visits = u64::from(looked);
                    work += Work { pixels: 1, visits, cut, most_cut: cut, ..Work::default() };
                }
            }
            if COUNT {
                let lane_visits = tile::LANES as u64 * u64::from(longest);
                work += Work { lane_visits, ..lit.work };
            }
        }
        work
    }

    fn frame<const COUNT: bool>(&self, frame: &Frame, shaded: &mut Shaded) -> Work {
        let pixels = (tile::SIDE * frame.width).max(1) as usize;
        let rows = shaded.radiance.par_chunks_mut(pixels).zip(shaded.visits.par_chunks_mut(pixels));
        let one = |(row, (radiance, visits)): (usize, (&mut [Vec3], &mut [u32]))| {
            self.row::<COUNT>(frame, row as u32, radiance, visits)
        };
        rows.enumerate().map(one).reduce(Work::default, |mut sum, work| {
            sum += work;
            sum
        })
    }
}

impl Lighting for Cpu {
    fn reset(&mut self, _seed: u32) -> Result<(), LightsError> {
        Ok(())
    }

    fn shade(&mut self, index: usize, count: bool) -> Result<Times, LightsError> {
        let frame = self.given.world.frame(index)?;
        let mut shaded = std::mem::take(&mut self.shaded);
        shaded.clear(frame.points.len(), true);
        if count {
            shaded.work = self.frame::<true>(frame, &mut shaded);
        } else {
            self.frame::<false>(frame, &mut shaded);
            shaded.visits.clear();
        }
        self.shaded = shaded;
        Ok(Times::new())
    }

    fn read(&mut self, shaded: &mut Shaded) -> Result<(), LightsError> {
        shaded.copy_from(&self.shaded);
        Ok(())
    }

    fn bytes(&self) -> u64 {
        let open = self.given.open().bytes();
        let nodes = size_of_val(&*self.tree.nodes) as u64;
        nodes + self.given.starts.bytes() + self.pool.len() as u64 * open
    }
}

impl Starting for Cpu {
    fn start(&mut self, starts: &Starts) -> Result<u64, LightsError> {
        self.given.set_starts(starts)?;
        self.make_room();
        Ok(0)
    }

    fn replace_moving(&mut self, lights: &[Light], tree: &LightTree) -> Result<u64, LightsError> {
        self.given.set_moving(lights, tree)?;
        self.tree.replace_after(self.given.moving.fixed, &tree.pack());
        self.make_room();
        Ok(0)
    }

    fn starts(&self) -> Result<Starts, LightsError> {
        Ok(self.given.starts.clone())
    }
}
