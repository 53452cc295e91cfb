//! One triangle made ready: which pixels it covers, and how far away it is at most.
//!
//! Coverage is that of a device with 8 bits below the pixel: a pixel belongs to a triangle that
//! holds its centre; a centre on an edge belongs to the triangle on its right, or below a flat one.
//! Crossings of edges with a row of centres are computed in `f64` such that they decide as exact
//! arithmetic does. A crossing is a multiple of 1 / (256 dy) pixels, dy < 2^24 the edge's height in
//! steps, so it is on a centre or 2^-32 pixels away. Rounding errs by less than 2^-34, and so much
//! is subtracted.

use super::project::{STEPS, Vertex};

/// Which triangles of an occluder are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Facing {
    /// All.
    #[default]
    Both,
    /// Those that are counter-clockwise on the image, seen with y up.
    CounterClockwise,
    /// Those that are clockwise.
    Clockwise,
}

impl Facing {
    /// Whether a triangle of this [`doubled_area`] is drawn.
    #[inline(always)]
    pub(super) fn draws(self, area: i64) -> bool {
        match self {
            Self::Both => area != 0,
            Self::CounterClockwise => area < 0,
            Self::Clockwise => area > 0,
        }
    }
}

/// What is taken off a triangle for the sake of renderers that draw it a little elsewhere.
#[derive(Clone, Copy, Debug)]
pub(super) struct Care {
    /// How far open edges are moved inwards, steps; depths are those of the farthest point so near.
    pub inset: i32,
    /// Depths are farther by this share of themselves.
    pub slack: f64,
}

/// What decides ties, pixels.
const BIAS: f64 = 1.0 / (1u64 << 34) as f64;
/// Relative error of depths in `f32`, generously.
const DEPTH_ERROR: f64 = 1.0 / (1u32 << 20) as f64;
/// Stands for "at every row": an edge's crossing where a side has but one.
const NOWHERE: f64 = 1e6;

/// An edge as a function of the row: the first pixel at or right of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    /// Pixels, at `y`.
    pub x: f64,
    /// Pixels.
    pub y: f64,
    /// Pixels a row.
    pub slope: f64,
}

impl Edge {
    /// Crossing with the centres of `row`; its nearest integer is the first pixel at or right of it.
    #[inline(always)]
    pub(super) fn crossing(&self, row: f64) -> f64 {
        self.x + (row + 0.5 - self.y) * self.slope
    }
}

/// A triangle on the image.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    /// Corners, clockwise as seen with y down.
    pub corners: [Vertex; 3],
    /// Whether the edge from each corner to the next is moved inwards.
    pub open: [bool; 3],
    /// How far open edges are moved inwards, steps.
    pub inset: i32,
    /// Rows that it may cover, half-open, within the image.
    pub rows: [i32; 2],
    /// Columns, likewise.
    pub columns: [i32; 2],
    /// Edges that it lies right of.
    pub left: [Edge; 2],
    /// Edges that it lies left of.
    pub right: [Edge; 2],
    /// Depth.
    pub plane: Plane,
}

/// Depth of a triangle at most so far away: `origin + x * gradient.x + y * gradient.y`, pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    origin: f64,
    gradient: [f64; 2],
    /// Of the farthest pixel of each subtile relative to the tile's corner, rounded away.
    pub offsets: [f32; 8],
    /// No part of the triangle is farther.
    pub farthest: f32,
}

impl Plane {
    /// How much nearer or farther it gets in one pixel, at most.
    #[inline(always)]
    pub(super) fn steepness(&self) -> f64 {
        self.gradient[0].abs() + self.gradient[1].abs()
    }

    /// At the upper left corner of a tile.
    #[inline(always)]
    pub(super) fn at(&self, x: i32, y: i32) -> f32 {
        (self.origin + f64::from(x) * self.gradient[0] + f64::from(y) * self.gradient[1]) as f32
    }
}

/// First pixel whose centre is not before `steps`.
#[inline(always)]
fn first(steps: i32) -> i32 {
    (steps + STEPS / 2 - 1) >> 8
}

/// Twice the signed area in square steps, positive for clockwise as seen with y down.
#[inline(always)]
pub(super) fn doubled_area([a, b, c]: [Vertex; 3]) -> i64 {
    let wide = |from: i32, to: i32| i64::from(to) - i64::from(from);
    wide(a.x, b.x) * wide(a.y, c.y) - wide(a.x, c.x) * wide(a.y, b.y)
}

impl Triangle {
    /// `None` for triangles that face the wrong way or cover no pixel. Edges that are `open` are
    /// moved inwards.
    #[inline(always)]
    pub(super) fn new(
        mut corners: [Vertex; 3],
        mut open: [bool; 3],
        facing: Facing,
        care: Care,
        size: [i32; 2],
    ) -> Option<Self> {
        let area = doubled_area(corners);
        if !facing.draws(area) {
            return None;
        }
        if area < 0 {
            corners.swap(1, 2);
            open.swap(0, 2);
        }
        let [a, b, c] = corners;
        let (top, bottom) = (a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y));
        let rows = [first(top).max(0), first(bottom).min(size[1])];
        let columns =
            [first(a.x.min(b.x).min(c.x)).max(0), first(a.x.max(b.x).max(c.x)).min(size[0])];
        if rows[0] >= rows[1] || columns[0] >= columns[1] {
            return None;
        }
        let mut triangle = Self {
            corners,
            open,
            inset: care.inset,
            rows,
            columns,
            left: [Edge { x: -NOWHERE, y: 0.0, slope: 0.0 }; 2],
            right: [Edge { x: NOWHERE, y: 0.0, slope: 0.0 }; 2],
            plane: Plane::new(corners, area.unsigned_abs() as f64, care),
        };
        triangle.set_edges();
        Some(triangle)
    }

    #[inline(always)]
    fn set_edges(&mut self) {
        let (mut lefts, mut rights) = (0, 0);
        for i in 0..3 {
            let (from, to) = (self.corners[i], self.corners[(i + 1) % 3]);
            let (dx, dy) = (to.x - from.x, to.y - from.y);
            let inset = if self.open[i] { self.inset } else { 0 };
            if dy == 0 {
                // Rightwards is the upper side, leftwards the lower.
                if dx > 0 {
                    self.rows[0] = self.rows[0].max(first(from.y + inset));
                } else {
                    self.rows[1] = self.rows[1].min(first(from.y - inset));
                }
                continue;
            }
            let scale = 1.0 / f64::from(STEPS);
            let slope = f64::from(dx) / f64::from(dy);
            let shift = f64::from(inset) * scale * (1.0 + slope.abs());
            let sign = if dy > 0 { -1.0 } else { 1.0 };
            let edge = Edge {
                x: f64::from(from.x) * scale - BIAS + sign * shift,
                y: f64::from(from.y) * scale,
                slope,
            };
            if dy > 0 {
                self.right[rights & 1] = edge;
                rights += 1;
            } else {
                self.left[lefts & 1] = edge;
                lefts += 1;
            }
        }
    }

    /// Pixels of `row` that are covered, half-open, not cut to the image.
    #[inline(always)]
    pub(super) fn span(&self, row: f64) -> [f64; 2] {
        let [l, m] = [self.left[0].crossing(row), self.left[1].crossing(row)];
        let [r, s] = [self.right[0].crossing(row), self.right[1].crossing(row)];
        [if l > m { l } else { m }, if r < s { r } else { s }]
    }
}

#[inline(always)]
fn pixels(steps: i32) -> f64 {
    f64::from(steps) * (1.0 / STEPS as f64)
}

impl Plane {
    /// From corners and the absolute value of their [`doubled_area`].
    #[inline(always)]
    pub(super) fn new([a, b, c]: [Vertex; 3], area: f64, care: Care) -> Self {
        let [(bx, by), (cx, cy)] = [b, c].map(
            #[inline(always)]
            |v| (pixels(v.x - a.x), pixels(v.y - a.y)),
        );
        let (za, zb, zc) = (f64::from(a.z), f64::from(b.z), f64::from(c.z));
        let (bz, cz) = (zb - za, zc - za);
        let inverse = f64::from(STEPS * STEPS) / area;
        let gradient = [(bz * cy - cz * by) * inverse, (cz * bx - bz * cx) * inverse];
        let origin = za - pixels(a.x) * gradient[0] - pixels(a.y) * gradient[1];

        let nearest = za.abs().max(zb.abs()).max(zc.abs());
        let steep = gradient[0].abs() + gradient[1].abs();
        let reach = bx.abs() + by.abs() + cx.abs() + cy.abs();
        // Gradients of slivers are differences of almost equal numbers. 64 pixels: what lies beyond
        // the triangle in a tile that it touches.
        let sliver = (bz.abs() + cz.abs()) * reach * inverse * (reach + 64.0) * 1e-15;
        // 65536 pixels: how far the plane's origin may be.
        let margin = pixels(care.inset) * steep
            + DEPTH_ERROR * (32.0 * steep + nearest)
            + sliver
            + care.slack * nearest
            + (65_536.0 * steep + nearest) * 1e-14;
        let far = |g: f64, side: f64| if g > 0.0 { 0.5 * g } else { (side - 0.5) * g };
        let corner = far(gradient[0], 8.0) + far(gradient[1], 4.0) - margin;
        let (gx, gy) = (8.0 * gradient[0], 4.0 * gradient[1]);
        let offsets =
            std::array::from_fn(|i| (corner + (i % 4) as f64 * gx + (i / 4) as f64 * gy) as f32);
        let farthest = za.min(zb).min(zc) - (DEPTH_ERROR + care.slack) * nearest;
        Self { origin, gradient, offsets, farthest: farthest as f32 }
    }
}
