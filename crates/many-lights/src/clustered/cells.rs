//! What each cell holds.

use super::Grid;
use crate::{Frame, Point};
use glam::Vec3;

/// A box around the points of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Lower corner, metres.
    pub min: Vec3,
    /// Upper corner.
    pub max: Vec3,
}

impl Cell {
    /// No point.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// Whether it holds no point.
    pub fn is_empty(&self) -> bool {
        self.min.x > self.max.x
    }

    /// With one more point.
    fn grow(&mut self, point: &Point) {
        self.min = self.min.min(point.position);
        self.max = self.max.max(point.position);
    }
}

/// The cells of one tile, one a slice; `each` is told every pixel that shows anything, and its slice.
pub(super) fn tile_cells(
    grid: &Grid,
    frame: &Frame,
    tile: usize,
    cells: &mut [Cell],
    mut each: impl FnMut(usize, usize),
) {
    cells.fill(Cell::EMPTY);
    for pixel in grid.pixels(frame, tile) {
        let point = &frame.points[pixel];
        if point.is_there() {
            let slice = grid.slice_of(frame, point);
            cells[slice].grow(point);
            each(pixel, slice);
        }
    }
}

/// The cells of a frame.
pub fn cells(grid: &Grid, frame: &Frame) -> Vec<Cell> {
    let slices = grid.slices as usize;
    let mut cells = vec![Cell::EMPTY; grid.tiles() * slices];
    for (tile, cells) in cells.chunks_mut(slices).enumerate() {
        tile_cells(grid, frame, tile, cells, |_, _| ());
    }
    cells
}
