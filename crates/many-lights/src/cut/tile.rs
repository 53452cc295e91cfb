//! Squares of 8 x 8 pixels, whose lanes a device runs in step.

use crate::{Frame, Work};

/// Pixels a side.
pub const SIDE: u32 = 8;

/// Pixels of a whole tile.
pub const LANES: usize = (SIDE * SIDE) as usize;

/// Tiles a row and a column of a frame, partial ones at the right and lower borders included.
pub fn tiles(width: u32, height: u32) -> (u32, u32) {
    (width.div_ceil(SIDE), height.div_ceil(SIDE))
}

/// Column and row of every tile of a frame, row by row.
pub fn all(width: u32, height: u32) -> impl Iterator<Item = (u32, u32)> {
    let (columns, rows) = tiles(width, height);
    (0..rows).flat_map(move |row| (0..columns).map(move |column| (column, row)))
}

/// Indices of the pixels of tile (`column`, `row`), row by row, those outside of the frame left out.
pub fn pixels(
    width: u32,
    height: u32,
    column: u32,
    row: u32,
) -> impl Iterator<Item = usize> + Clone {
    let (left, top) = (column * SIDE, row * SIDE);
    let (right, bottom) = ((left + SIDE).min(width), (top + SIDE).min(height));
    (top..bottom)
        .flat_map(move |y| (left..right).map(move |x| y as usize * width as usize + x as usize))
}

/// Spread of visits over the pixels of a frame that show anything.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// Visits that lanes of a tile wait through, over visits: D, at least 1.
    pub divergence: f64,
    /// Mean of visits by pixel.
    pub mean: f64,
    /// Their variance.
    pub variance: f64,
}

/// 64 times the most visits of any pixel of a tile, summed over tiles: [`Work::lane_visits`].
pub fn lane_visits(width: u32, height: u32, visits: &[u32]) -> u64 {
    let most = |column, row| pixels(width, height, column, row).map(|pixel| visits[pixel]).max();
    let waited = |(column, row)| LANES as u64 * u64::from(most(column, row).unwrap_or(0));
    all(width, height).map(waited).sum()
}

/// The spread of `visits`, one a pixel of `frame`.
pub fn spread(frame: &Frame, visits: &[u32]) -> Spread {
    let there = || {
        let lit = frame.points.iter().zip(visits).filter(|(point, _)| point.is_there());
        lit.map(|(_, &visits)| f64::from(visits))
    };
    let count = there().count().max(1) as f64;
    let mean = there().sum::<f64>() / count;
    let variance = there().map(|visits| (visits - mean).powi(2)).sum::<f64>() / count;
    let work = Work {
        visits: visits.iter().map(|&visits| u64::from(visits)).sum(),
        lane_visits: lane_visits(frame.width, frame.height, visits),
        ..Work::default()
    };
    Spread { divergence: work.divergence(), mean, variance }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Eye, Point};
    use glam::{DVec3, Vec3};

    #[test]
    fn tiles_hold_every_pixel_once() {
        for (width, height) in [(0, 0), (1, 1), (8, 8), (9, 7), (17, 24)] {
            let mut seen = vec![0; (width * height) as usize];
            for (column, row) in all(width, height) {
                pixels(width, height, column, row).for_each(|pixel| seen[pixel] += 1);
            }
            assert!(seen.iter().all(|&times| times == 1), "{width} x {height}");
        }
    }

    #[test]
    fn lanes_wait_for_the_slowest_of_their_own_tile() {
        // 9 x 1: eight pixels in one tile, one in the next.
        let mut points = vec![Point { normal: Vec3::Y, ..Point::default() }; 9];
        points[7] = Point::nothing();
        let eye = Eye {
            position: DVec3::ZERO,
            forward: DVec3::X,
            right: DVec3::Z,
            up: DVec3::Y,
            perspective: true,
        };
        let frame = Frame { width: 9, height: 1, eye, points };
        let visits = [4, 4, 4, 4, 4, 4, 4, 0, 2];
        assert_eq!(lane_visits(9, 1, &visits), 64 * 4 + 64 * 2);
        let spread = spread(&frame, &visits);
        assert_eq!(spread.divergence, 384.0 / 30.0);
        assert_eq!(spread.mean, 3.75);
        assert_eq!(spread.variance, (7.0 * 0.0625 + 1.75 * 1.75) / 8.0);
    }
}
