//! What the 64 pixels of a tile hold side by side, eight to a row.

use crate::{Frame, Point, cut::tile};
use glam::Vec3;
use std::array::from_fn;

/// Lanes of a row.
pub(super) const WIDTH: usize = tile::SIDE as usize;

/// Rows.
pub(super) const ROWS: usize = WIDTH;

/// A number for every lane of a row.
pub(super) type Row<T = f32> = [T; WIDTH];

/// The points of a row of eight pixels, number by number.
#[derive(Clone, Copy, Default)]
pub(super) struct Points {
    position: [Row; 3],
    normal: [Row; 3],
    albedo: [Row; 3],
}

impl Points {
    /// A lane becomes a point.
    pub(super) fn set(&mut self, lane: usize, point: &Point) {
        for axis in 0..3 {
            self.position[axis][lane] = point.position[axis];
            self.normal[axis][lane] = point.normal[axis];
            self.albedo[axis][lane] = point.albedo[axis];
        }
    }

    /// Position, normal and albedo of a lane.
    #[inline(always)]
    pub(super) fn vectors(&self, lane: usize) -> (Vec3, Vec3, Vec3) {
        let vector = |rows: &[Row; 3]| Vec3::new(rows[0][lane], rows[1][lane], rows[2][lane]);
        (vector(&self.position), vector(&self.normal), vector(&self.albedo))
    }

    /// The point of a lane.
    #[inline(always)]
    pub(super) fn get(&self, lane: usize) -> Point {
        let (position, normal, albedo) = self.vectors(lane);
        Point { position, normal, albedo, ..Point::default() }
    }
}

/// Numbers of a block of a [`Sum`]: with 10^6 lights there are as many blocks as lights in one.
const BLOCK: u32 = 1024;

/// Sums of very many small numbers: blocks, then blocks of blocks, since one running f32 would lose
/// what is added late. As `common/lights_sum.wgsl`.
#[derive(Clone, Copy, Default)]
pub(super) struct Sum {
    total: [Row; 3],
    block: [Row; 3],
    held: Row<u32>,
}

impl Sum {
    /// Adds to the lanes of which `added` is all ones, not to those of which it is 0.
    #[inline(always)]
    pub(super) fn add(&mut self, added: &Row<u32>, values: &[Row; 3]) {
        let mut full = [false; WIDTH];
        for lane in 0..WIDTH {
            self.held[lane] += added[lane] & 1;
            full[lane] = self.held[lane] == BLOCK;
        }
        for channel in 0..3 {
            for lane in 0..WIDTH {
                let value = if added[lane] != 0 { values[channel][lane] } else { 0.0 };
                self.block[channel][lane] += value;
            }
        }
        if full.contains(&true) {
            self.carry(&full);
        }
    }

    #[cold]
    fn carry(&mut self, full: &Row<bool>) {
        for lane in (0..WIDTH).filter(|&lane| full[lane]) {
            self.held[lane] = 0;
            for channel in 0..3 {
                self.total[channel][lane] += std::mem::take(&mut self.block[channel][lane]);
            }
        }
    }

    /// A lane's sum becomes `value`.
    pub(super) fn set(&mut self, lane: usize, value: Vec3) {
        for channel in 0..3 {
            self.total[channel][lane] = value[channel];
            self.block[channel][lane] = 0.0;
        }
    }

    /// What a lane's numbers add up to.
    pub(super) fn of_lane(&self, lane: usize) -> Vec3 {
        Vec3::from_array(from_fn(|channel| self.total[channel][lane] + self.block[channel][lane]))
    }
}

/// The pixels of a tile, as far as they show anything.
#[derive(Clone)]
pub(super) struct Tile {
    pub(super) rows: [Points; ROWS],
    /// The same, pixel by pixel.
    pub(super) points: [Point; tile::LANES],
    /// Their indices in the frame.
    pub(super) pixels: [u32; tile::LANES],
    /// Lanes that show anything.
    pub(super) there: u64,
}

impl Default for Tile {
    fn default() -> Self {
        Self {
            rows: [Points::default(); ROWS],
            points: [Point::default(); tile::LANES],
            pixels: [0; tile::LANES],
            there: 0,
        }
    }
}

impl Tile {
    /// Fills it with a tile of a frame.
    pub(super) fn load(&mut self, frame: &Frame, column: u32, row: u32) {
        self.there = 0;
        let left = column * tile::SIDE;
        for pixel in tile::pixels(frame.width, frame.height, column, row) {
            let point = &frame.points[pixel];
            let (x, y) =
                (pixel as u32 % frame.width - left, pixel as u32 / frame.width % tile::SIDE);
            let lane = (y * tile::SIDE + x) as usize;
            self.points[lane] = *point;
            self.pixels[lane] = pixel as u32;
            if point.is_there() {
                self.there |= 1 << lane;
                self.rows[y as usize].set(x as usize, point);
            }
        }
    }

    /// Lanes that are set in `lanes`.
    pub(super) fn lanes(lanes: u64) -> impl Iterator<Item = usize> + Clone {
        (0..tile::LANES).filter(move |lane| lanes >> lane & 1 == 1)
    }
}
