//! The buffer computed for the instruction set at hand: loops over eight lanes that compilers turn
//! into vectors, compiled once for each level of x86-64 and chosen when first called.
//!
//! A lane is a scanline of a tile while coverage is found, 32 pixels of one word; the words' bytes
//! are then dealt out to the subtiles, and a lane is a subtile.

use super::buffer::{Buffer, Occluder, TILE_HEIGHT, TILE_WIDTH, Tile, loss};
use super::project::Projection;
use super::silhouette::each_triangle;
use super::triangle::Triangle;
use crate::OcclusionError;
use multiversion::multiversion;

#[multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512dq+avx512vl+avx2+bmi1+bmi2+lzcnt+popcnt",
    "x86_64+avx2+bmi1+bmi2+lzcnt+popcnt",
    "x86_64+sse4.1+ssse3+popcnt",
))]
pub(super) fn rasterise(
    buffer: &mut Buffer,
    occluder: &Occluder,
    projection: &Projection,
) -> Result<(), OcclusionError> {
    let tiles_x = buffer.tiles_x;
    let tiles = &mut buffer.tiles;
    each_triangle(
        occluder,
        projection,
        [buffer.width as i32, buffer.height as i32],
        &mut buffer.vertices,
        &mut buffer.silhouette,
        #[inline(always)]
        |triangle| draw(triangle, tiles, tiles_x),
    )
}

/// Added to a small number, it leaves the nearest integer in the low bits.
const ROUND: f64 = 1.5 * (1u64 << 52) as f64;

#[inline(always)]
fn draw(triangle: &Triangle, tiles: &mut [Tile], tiles_x: usize) {
    let [top, bottom] = triangle.rows;
    for ty in top / TILE_HEIGHT..=(bottom - 1) / TILE_HEIGHT {
        let y = ty * TILE_HEIGHT;
        let (begin, end) = spans(triangle, y);
        let left = begin.iter().fold(i32::MAX, |a, &b| a.min(b));
        let right = end.iter().fold(0, |a, &b| a.max(b));
        if left >= right {
            continue;
        }
        let row = &mut tiles[ty as usize * tiles_x..][..tiles_x];
        for tx in left / TILE_WIDTH..=(right - 1) / TILE_WIDTH {
            let x = tx * TILE_WIDTH;
            let corner = triangle.plane.at(x, y);
            let mask = deal(scanlines(&begin, &end, x));
            update(&mut row[tx as usize], &mask, corner, triangle);
        }
    }
}

/// The pixels that each scanline from `y` on covers, half-open, within the image; empty ones begin
/// at the right end and end at 0.
#[inline(always)]
fn spans(triangle: &Triangle, y: i32) -> ([i32; 8], [i32; 8]) {
    // One step at a time over all lanes: each loop becomes a few vector operations.
    let (mut left, mut right) = ([0.0; 8], [0.0; 8]);
    for lane in 0..8 {
        let [l, r] = triangle.span(f64::from(y) + lane as f64);
        left[lane] = l + ROUND;
        right[lane] = r + ROUND;
    }
    let (mut begin, mut end) = ([0; 8], [0; 8]);
    for lane in 0..8 {
        begin[lane] = (left[lane].to_bits() as i32).max(triangle.columns[0]);
        end[lane] = (right[lane].to_bits() as i32).min(triangle.columns[1]);
    }
    let [top, bottom] = triangle.rows.map(|row| row - y);
    for lane in 0..8 {
        let row = lane as i32;
        let covered = (row >= top) & (row < bottom) & (begin[lane] < end[lane]);
        begin[lane] = if covered { begin[lane] } else { triangle.columns[1] };
        end[lane] = if covered { end[lane] } else { 0 };
    }
    (begin, end)
}

/// Bits of the tile at `x`, a word a scanline.
#[inline(always)]
fn scanlines(begin: &[i32; 8], end: &[i32; 8], x: i32) -> [u32; 8] {
    let from = |pixel: i32| {
        let n = (pixel - x).clamp(0, TILE_WIDTH) as u32;
        u32::MAX.checked_shl(n).unwrap_or(0)
    };
    std::array::from_fn(
        #[inline(always)]
        |lane| from(begin[lane]) & !from(end[lane]),
    )
}

/// From scanlines of 32 pixels to subtiles of 8 x 4.
#[inline(always)]
fn deal(scanlines: [u32; 8]) -> [u32; 8] {
    let byte = |line: usize, i: usize| scanlines[line] >> (8 * i) & 0xff;
    std::array::from_fn(
        #[inline(always)]
        |i| {
            let line = 4 * (i / 4);
            let i = i % 4;
            byte(line, i)
                | byte(line + 1, i) << 8
                | byte(line + 2, i) << 16
                | byte(line + 3, i) << 24
        },
    )
}

/// [`super::reference`]'s update, all subtiles at once.
#[inline(always)]
fn update(tile: &mut Tile, mask: &[u32; 8], corner: f32, triangle: &Triangle) {
    let Tile { reference, working, mask: held } = *tile;
    let mut depth = [0.0; 8];
    for (depth, offset) in depth.iter_mut().zip(&triangle.plane.offsets) {
        let plane = corner + offset;
        let farthest = triangle.plane.farthest;
        *depth = if plane > farthest { plane } else { farthest };
    }
    let mut next = *tile;
    for i in 0..8 {
        let passes = (mask[i] != 0) & (depth[i] > reference[i]);
        let newer = depth[i] >= working[i];
        let near = if newer { depth[i] } else { working[i] };
        let far = if newer { working[i] } else { depth[i] };
        let of_near = if newer { mask[i] } else { held[i] };
        let of_far = if newer { held[i] } else { mask[i] } & !of_near;
        let all = of_near | of_far;
        let (covered, full) = (of_near == u32::MAX, all == u32::MAX);
        let keeps = full | (loss(of_near, near, far) > loss(of_far, far, reference[i]));

        let below = if covered { near } else { far };
        let layer = if keeps { near } else { far };
        let layer = if covered { f32::INFINITY } else { layer };
        let bits = if keeps { of_near } else { all };
        let bits = if covered { 0 } else { bits };
        next.reference[i] = if passes & full { below } else { reference[i] };
        next.working[i] = if passes { layer } else { working[i] };
        next.mask[i] = if passes { bits } else { held[i] };
    }
    *tile = next;
}
