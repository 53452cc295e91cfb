//! Tiles of the image times slices of depth.

use crate::{Clustered, Frame, LightsError, Point};

/// Most cells of a frame: each is 32 bytes, or as many on a device.
pub const MAX_CELLS: u64 = 1 << 24;

/// Where a frame's points are sorted into cells: cell `(row · columns + column) · slices + slice`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Pixels a side of a tile.
    pub tile: u32,
    /// Slices of depth.
    pub slices: u32,
    /// Tiles a row.
    pub columns: u32,
    /// Tiles a column.
    pub rows: u32,
    /// Depth of the nearest point; the slices of a perspective eye start there.
    pub near_m: f64,
    /// Of the logarithm of depth over `near_m`, or of depth less `near_m`, to slices.
    pub scale: f64,
    /// Whether slices grow by a constant factor.
    pub growing: bool,
}

impl Grid {
    /// The grid of a frame, between its nearest and its farthest point.
    ///
    /// # Errors
    /// More than [`MAX_CELLS`] cells.
    pub fn of(frame: &Frame, settings: &Clustered) -> Result<Self, LightsError> {
        let (tile, slices) = (settings.tile, settings.slices);
        let (columns, rows) = (frame.width.div_ceil(tile), frame.height.div_ceil(tile));
        let cells = u128::from(columns) * u128::from(rows) * u128::from(slices);
        if cells > u128::from(MAX_CELLS) {
            let limit = format!("{cells} cells of {tile} pixels a side; at most {MAX_CELLS}");
            return Err(LightsError::value("slices", limit));
        }
        let growing = frame.eye.perspective;
        let depths = frame.points.iter().filter(|p| p.is_there()).map(|p| depth(frame, p));
        // What lies behind a perspective eye has no place among factors: it goes to the first slice.
        let usable = depths.filter(|&d| d > 0.0 || !growing);
        let (near, far) =
            usable.fold((f64::INFINITY, f64::NEG_INFINITY), |(n, f), d| (n.min(d), f.max(d)));
        let extent = if growing { (far / near).ln() } else { far - near };
        // No point, or all at one depth: one slice is enough.
        let usable = extent > 0.0 && extent.is_finite();
        let scale = if usable { f64::from(slices) / extent } else { 0.0 };
        let near_m = if near.is_finite() { near } else { 1.0 };
        Ok(Self { tile, slices, columns, rows, near_m, scale, growing })
    }

    /// Number of tiles.
    pub fn tiles(&self) -> usize {
        self.columns as usize * self.rows as usize
    }

    /// Tile that a pixel lies in.
    pub fn tile_of(&self, frame: &Frame, pixel: usize) -> usize {
        let (x, y) = (pixel % frame.width as usize, pixel / frame.width as usize);
        let side = self.tile as usize;
        y / side * self.columns as usize + x / side
    }

    /// Slice that a point lies in.
    pub fn slice_of(&self, frame: &Frame, point: &Point) -> usize {
        let depth = depth(frame, point);
        let along = if self.growing { (depth / self.near_m).ln() } else { depth - self.near_m };
        // The conversion takes what is below 0, or no number, to 0.
        ((along * self.scale) as usize).min(self.slices as usize - 1)
    }

    /// Cell that a pixel with its point lies in.
    pub fn cell_of(&self, frame: &Frame, pixel: usize) -> usize {
        let slice = self.slice_of(frame, &frame.points[pixel]);
        self.tile_of(frame, pixel) * self.slices as usize + slice
    }

    /// Pixels of a tile, row by row, those outside of the frame left out.
    pub fn pixels(&self, frame: &Frame, tile: usize) -> impl Iterator<Item = usize> + use<> {
        let (column, row) = (tile as u32 % self.columns, tile as u32 / self.columns);
        // Sides are below 2^32: sums of products in 64 bits.
        let end = |first: u32, limit: u32| {
            (u64::from(first) + 1).saturating_mul(self.tile.into()).min(limit.into()) as usize
        };
        let (left, top) = (column as usize * self.tile as usize, row as usize * self.tile as usize);
        let (right, bottom, width) =
            (end(column, frame.width), end(row, frame.height), frame.width as usize);
        (top..bottom).flat_map(move |y| (left..right).map(move |x| y * width + x))
    }
}

/// Distance along the view axis, metres.
fn depth(frame: &Frame, point: &Point) -> f64 {
    (point.position.as_dvec3() - frame.eye.position).dot(frame.eye.forward)
}
