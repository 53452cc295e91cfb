//! The buffer computed pixel by pixel: coverage by exact edge functions in integers.

use super::buffer::{Buffer, Occluder, TILE_HEIGHT, TILE_WIDTH, Tile, loss};
use super::project::{Projection, STEPS};
use super::silhouette::each_triangle;
use super::triangle::Triangle;
use crate::OcclusionError;

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
        |triangle| draw(triangle, tiles, tiles_x),
    )
}

fn draw(triangle: &Triangle, tiles: &mut [Tile], tiles_x: usize) {
    let [top, bottom] = triangle.rows;
    let [left, right] = triangle.columns;
    for ty in top / TILE_HEIGHT..=(bottom - 1) / TILE_HEIGHT {
        for tx in left / TILE_WIDTH..=(right - 1) / TILE_WIDTH {
            let tile = &mut tiles[ty as usize * tiles_x + tx as usize];
            let (x, y) = (tx * TILE_WIDTH, ty * TILE_HEIGHT);
            let corner = triangle.plane.at(x, y);
            for i in 0..8 {
                let mask = coverage(triangle, x + 8 * (i as i32 % 4), y + 4 * (i as i32 / 4));
                let depth = (corner + triangle.plane.offsets[i]).max(triangle.plane.farthest);
                update(tile, i, mask, depth);
            }
        }
    }
}

/// The pixels of the subtile at (`left`, `top`) that the triangle covers.
fn coverage(triangle: &Triangle, left: i32, top: i32) -> u32 {
    let mut mask = 0;
    for bit in 0..32 {
        let (x, y) = (left + bit % 8, top + bit / 8);
        let inside = (triangle.rows[0]..triangle.rows[1]).contains(&y)
            && (triangle.columns[0]..triangle.columns[1]).contains(&x);
        if inside && covers(triangle, x, y) {
            mask |= 1 << bit;
        }
    }
    mask
}

/// Whether the centre of a pixel is right of the left edges, or on them, and left of the right
/// edges. The rows of the triangle take care of flat edges.
fn covers(triangle: &Triangle, x: i32, y: i32) -> bool {
    let half = STEPS / 2;
    let (px, py) = (i64::from(x * STEPS + half), i64::from(y * STEPS + half));
    (0..3).all(|i| {
        let (a, b) = (triangle.corners[i], triangle.corners[(i + 1) % 3]);
        let (dx, dy) = (i64::from(b.x) - i64::from(a.x), i64::from(b.y) - i64::from(a.y));
        let inset = if triangle.open[i] { i64::from(triangle.inset) } else { 0 };
        let aside = (px - i64::from(a.x)) * dy - (py - i64::from(a.y)) * dx;
        let moved = inset * (dy.abs() + dx.abs());
        match dy.signum() {
            // Clockwise: edges go down on the right.
            1 => aside < -moved,
            -1 => -aside >= moved,
            _ => true,
        }
    })
}

/// Adds `mask` at `depth` to a subtile. Its pixels then have three depths: that of the nearer layer,
/// of the farther one where that is not covered, and the reference. Where they cover the subtile,
/// two will do. Else the nearer layer is taken back to the farther, or the farther to the
/// reference: whichever loses less.
fn update(tile: &mut Tile, i: usize, mask: u32, depth: f32) {
    let (reference, working, held) = (tile.reference[i], tile.working[i], tile.mask[i]);
    if mask == 0 || depth <= reference {
        return;
    }
    let newer = depth >= working;
    let (near, far) = if newer { (depth, working) } else { (working, depth) };
    let (of_near, of_far) = if newer { (mask, held) } else { (held, mask) };
    let of_far = of_far & !of_near;
    let all = of_near | of_far;
    let layers = if of_near == u32::MAX {
        (near, f32::INFINITY, 0)
    } else if all == u32::MAX {
        (far, near, of_near)
    } else if loss(of_near, near, far) > loss(of_far, far, reference) {
        (reference, near, of_near)
    } else {
        (reference, far, all)
    };
    (tile.reference[i], tile.working[i], tile.mask[i]) = layers;
}
