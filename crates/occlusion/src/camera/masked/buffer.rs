//! The buffer: two depths and a mask for each 8 x 4 pixels.

use super::project::{Projection, Vertex};
use super::silhouette::{Edges, Silhouette};
use super::triangle::Facing;
use super::{fast, reference};
use crate::OcclusionError;
use glam::{Mat4, Vec3};

/// Columns of a tile.
pub(super) const TILE_WIDTH: i32 = 32;
/// Rows of a tile.
pub(super) const TILE_HEIGHT: i32 = 8;
/// Largest side, pixels: coverage is exact up to it.
const MAX_SIDE: u32 = 16_384;

/// Eight subtiles of 8 x 4 pixels, four a row. Bit `8 y + x` of a mask is a pixel of its subtile.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub(super) struct Tile {
    /// No pixel is farther than this.
    pub reference: [f32; 8],
    /// No pixel of the mask is farther than this; infinite where the mask is empty.
    pub working: [f32; 8],
    /// Pixels of the working layer.
    pub mask: [u32; 8],
}

const CLEAR: Tile = Tile { reference: [0.0; 8], working: [f32::INFINITY; 8], mask: [0; 8] };

/// Depths below count as this one when losses are compared: 65,536 times the near plane's distance.
/// Clear is not infinitely far, or any layer would be given up to close any hole.
const FARTHEST: f32 = 1.0 / 65_536.0;

/// What is lost where the pixels of `mask` are taken from `near` back to `far`: octaves of depth,
/// 2^15 each, times pixels. The bits of a float are its logarithm, near enough.
#[inline(always)]
pub(super) fn loss(mask: u32, near: f32, far: f32) -> i32 {
    let bits = |depth: f32| (if depth > FARTHEST { depth } else { FARTHEST }).to_bits() as i32;
    mask.count_ones() as i32 * ((bits(near) - bits(far)) >> 8)
}

/// How it is computed. Both give the same buffer, bit for bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Pixel by pixel with integers: clear to read.
    Reference,
    /// Scanline by scanline, eight lanes at a time, for the instruction set at hand.
    Fast,
}

/// Indexed triangles that hide what is behind them.
#[derive(Clone, Copy, Debug)]
pub struct Occluder<'a> {
    /// Corners, in the space that the clip matrix is for.
    pub positions: &'a [Vec3],
    /// Indices of corners.
    pub triangles: &'a [[u32; 3]],
    /// Which sides are drawn.
    pub facing: Facing,
    /// Which edges are moved inwards.
    pub edges: Edges<'a>,
}

/// Depths of occluders, see the [module](super).
#[derive(Clone, Debug)]
pub struct Buffer {
    form: Form,
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) tiles_x: usize,
    pub(super) tiles: Vec<Tile>,
    /// Used again from one occluder to the next.
    pub(super) vertices: Vec<Vertex>,
    pub(super) silhouette: Silhouette,
}

impl Buffer {
    /// An empty buffer of `width` x `height` pixels; it takes 3 bytes a pixel of whole tiles.
    ///
    /// # Errors
    /// A side of 0 or above 16384.
    pub fn new(form: Form, width: u32, height: u32) -> Result<Self, OcclusionError> {
        let sides = 1..=MAX_SIDE;
        if !sides.contains(&width) || !sides.contains(&height) {
            let limit = format!("{width} x {height} pixels, sides must be 1..={MAX_SIDE}");
            return Err(OcclusionError::value("masked depth buffer", limit));
        }
        let tiles_x = width.div_ceil(TILE_WIDTH as u32) as usize;
        let tiles_y = height.div_ceil(TILE_HEIGHT as u32) as usize;
        Ok(Self {
            form,
            width,
            height,
            tiles_x,
            tiles: vec![CLEAR; tiles_x * tiles_y],
            vertices: Vec::new(),
            silhouette: Silhouette::default(),
        })
    }

    /// Width and height, pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Bytes of the depths and masks.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.tiles[..])
    }

    /// Empties the buffer.
    pub fn clear(&mut self) {
        self.tiles.fill(CLEAR);
    }

    /// Adds an occluder. `clip` has reversed depth: `z <= w` in front of the near plane, and
    /// `z / w` is greater the nearer.
    ///
    /// # Errors
    /// A matrix or a corner that is not finite, an index of no corner. What was drawn before the
    /// error was met stays: the buffer is as conservative as ever.
    pub fn rasterise(&mut self, occluder: &Occluder, clip: &Mat4) -> Result<(), OcclusionError> {
        let projection = Projection::new(clip, self.width, self.height)?;
        match self.form {
            Form::Reference => reference::rasterise(self, occluder, &projection),
            Form::Fast => fast::rasterise(self, occluder, &projection),
        }
    }

    /// Whether something as near as `depth` (greater is nearer) could show at a pixel of the columns
    /// `x` and rows `y`, half-open. What lies beyond the image does not show. A depth that is no
    /// number shows.
    pub fn shows(&self, x: [u32; 2], y: [u32; 2], depth: f32) -> bool {
        let clamp = |range: [u32; 2], size: u32| range.map(|v| v.min(size) as i32);
        let (x, y) = (clamp(x, self.width), clamp(y, self.height));
        if x[0] >= x[1] || y[0] >= y[1] {
            return false;
        }
        (y[0] / TILE_HEIGHT..=(y[1] - 1) / TILE_HEIGHT).any(|ty| {
            let row = ty as usize * self.tiles_x;
            let columns = (x[0] / TILE_WIDTH) as usize..=((x[1] - 1) / TILE_WIDTH) as usize;
            let rows = [y[0] - ty * TILE_HEIGHT, y[1] - ty * TILE_HEIGHT];
            self.tiles[row..][columns.clone()].iter().zip(columns).any(|(tile, tx)| {
                let left = tx as i32 * TILE_WIDTH;
                tile.shows([x[0] - left, x[1] - left], rows, depth)
            })
        })
    }
}

impl Tile {
    /// The same within a tile; the ranges may lie partly beyond it.
    fn shows(&self, x: [i32; 2], y: [i32; 2], depth: f32) -> bool {
        (0..8).any(|i| {
            let (left, top) = (8 * (i as i32 % 4), 4 * (i as i32 / 4));
            if self.reference[i] > depth {
                return false;
            }
            let asked = rectangle(x.map(|v| v - left), y.map(|v| v - top));
            let hidden = self.working[i] > depth;
            asked & !self.mask[i] != 0 || (asked != 0 && !hidden)
        })
    }
}

/// The pixels of a subtile in columns `x` and rows `y`, half-open, which may lie partly beyond it.
fn rectangle(x: [i32; 2], y: [i32; 2]) -> u32 {
    let below = |n: i32| (1u32 << n.clamp(0, 8)) - 1;
    let row = below(x[1]) & !below(x[0]);
    (0..4).filter(|r| (y[0]..y[1]).contains(r)).map(|r| row << (8 * r)).sum()
}
