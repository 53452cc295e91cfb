//! Where streets, blocks and lots lie.
//!
//! All lengths are multiples of 1/64 m and a city is centred on the origin, so that coordinates are
//! exact in `f32` and corners that objects share are the same numbers in every form.

use super::{BlockShape, Knobs};
use glam::DVec2;

/// Side of a lot, metres.
pub const LOT_M: f64 = 10.0;
/// Height of a storey, metres.
pub const STOREY_M: f64 = 3.0;
/// Width of a sidewalk, metres.
pub const SIDEWALK_M: f64 = 2.0;
/// Between the rows of a double row, metres.
pub const ALLEY_M: f64 = 5.0;

/// A place for a building, relative to its block.
#[derive(Clone, Copy, Debug)]
pub struct Lot {
    /// Lower corner, metres.
    pub min: DVec2,
    /// The lots that it touches towards +z, +x, -z, -x: the order of facades.
    pub neighbours: [Option<usize>; 4],
}

/// The grid of blocks, (x, z).
#[derive(Clone, Debug)]
pub struct Layout {
    /// Blocks of a row.
    pub columns: u32,
    /// Rows of blocks.
    pub rows: u32,
    /// Width of a carriageway, metres.
    pub street_m: f64,
    /// How far odd rows are moved along x, metres.
    pub shift_m: f64,
    /// A block with its sidewalks, metres.
    pub slab: DVec2,
    /// Lower corner of the city.
    pub min: DVec2,
    /// Upper corner.
    pub max: DVec2,
    /// The lots of every block.
    pub lots: Vec<Lot>,
}

impl Layout {
    /// The layout that `knobs` ask for.
    pub fn new(knobs: &Knobs) -> Self {
        let (lots, block) = lots(knobs.shape);
        let street_m = rounded(knobs.street_m);
        let slab = block + 2.0 * SIDEWALK_M;
        let pitch = slab + street_m;
        let shifted = knobs.brick_offset && knobs.blocks_z > 1;
        let shift_m = if shifted { 0.5 * pitch.x } else { 0.0 };
        let count = DVec2::new(f64::from(knobs.blocks_x), f64::from(knobs.blocks_z));
        let half = 0.5 * (count * pitch + street_m + DVec2::new(shift_m, 0.0));
        let (columns, rows) = (knobs.blocks_x, knobs.blocks_z);
        Self { columns, rows, street_m, shift_m, slab, min: -half, max: half, lots }
    }

    /// Lower and upper corner of a block with its sidewalks.
    pub fn slab(&self, row: u32, column: u32) -> [DVec2; 2] {
        let shift = if row % 2 == 1 { self.shift_m } else { 0.0 };
        let at = DVec2::new(f64::from(column), f64::from(row)) * (self.slab + self.street_m);
        let min = self.min + self.street_m + at + DVec2::new(shift, 0.0);
        [min, min + self.slab]
    }

    /// Where the lots of a block are counted from.
    pub fn block(&self, row: u32, column: u32) -> DVec2 {
        self.slab(row, column)[0] + SIDEWALK_M
    }
}

/// The lots of a block, and its size without sidewalks.
fn lots(shape: BlockShape) -> (Vec<Lot>, DVec2) {
    // Cells (column, row) in order; a cell may touch the four beside it.
    let (cells, touches_rows, row_m): (Vec<[u32; 2]>, bool, f64) = match shape {
        BlockShape::DoubleRow(n) => {
            ((0..2 * n).map(|i| [i % n, i / n]).collect(), false, LOT_M + ALLEY_M)
        }
        BlockShape::Ring(n) => {
            let border = |k: u32| k == 0 || k + 1 == n;
            let cells = (0..n * n).map(|i| [i % n, i / n]).filter(|c| border(c[0]) || border(c[1]));
            (cells.collect(), true, LOT_M)
        }
    };
    let find = |column: Option<u32>, row: Option<u32>| {
        let wanted = [column?, row?];
        cells.iter().position(|c| *c == wanted)
    };
    let lot = |&[column, row]: &[u32; 2]| Lot {
        min: DVec2::new(f64::from(column) * LOT_M, f64::from(row) * row_m),
        neighbours: [
            find(Some(column), row.checked_add(1)).filter(|_| touches_rows),
            find(column.checked_add(1), Some(row)),
            find(Some(column), row.checked_sub(1)).filter(|_| touches_rows),
            find(column.checked_sub(1), Some(row)),
        ],
    };
    let lots: Vec<Lot> = cells.iter().map(lot).collect();
    let size = lots.iter().fold(DVec2::ZERO, |size, lot| size.max(lot.min + LOT_M));
    (lots, size)
}

/// A length rounded to 1/64 m.
pub fn rounded(length_m: f64) -> f64 {
    (length_m * 64.0).round() / 64.0
}
