//! Triangles made ready for filling: corners snapped to 1/256 of a pixel, depth as a plane.
//!
//! The plane goes through the corners as they were before snapping, so depths are those of f64; at
//! pixels that only snapping covers they are kept within the range of the corners. Differences of
//! corners on the screen lose their digits where a triangle reaches far off the image, so the plane
//! of such a one is solved for in clip space.

use super::project::{Corner, GUARD, OnScreen, Polygon, Projection, beyond_near};
use glam::{DVec2, DVec3, DVec4, Vec2};

/// Sub-pixel steps a pixel, as on most devices.
const STEPS: i64 = 256;

/// Marks a triangle without a mask.
pub const SOLID: u32 = u32::MAX;

/// A corner on the screen, and on which sides of the view it lies outside.
#[derive(Clone, Copy, Debug, Default)]
pub struct Snapped {
    pub screen: OnScreen,
    x: i32,
    y: i32,
    outside: u8,
}

const LEFT: u8 = 1;
const RIGHT: u8 = 2;
const TOP: u8 = 4;
const BOTTOM: u8 = 8;
const NEAR: u8 = 16;
// Inside the near plane, but too far off the image for the edge functions.
const FAR_OFF: u8 = 32;

impl Snapped {
    #[inline(always)]
    pub fn new(projection: &Projection, clip: DVec4) -> Self {
        let mut outside = 0;
        outside |= if clip.x < -clip.w { LEFT } else { 0 };
        outside |= if clip.x > clip.w { RIGHT } else { 0 };
        outside |= if clip.y > clip.w { TOP } else { 0 };
        outside |= if clip.y < -clip.w { BOTTOM } else { 0 };
        let near = beyond_near(clip);
        if near < 0.0 || near.is_nan() {
            return Self { outside: outside | NEAR, ..Self::default() };
        }
        let screen = projection.screen(clip);
        // Clipping leaves corners on the guard band's border, give or take its rounding.
        if screen.x.abs() <= GUARD + 1.0 && screen.y.abs() <= GUARD + 1.0 {
            Self { screen, x: snap(screen.x), y: snap(screen.y), outside }
        } else {
            Self { screen, outside: outside | FAR_OFF, ..Self::default() }
        }
    }
}

/// Nearest sub-pixel step, halves to even: adding 1.5 * 2^52 leaves the whole number in the low
/// bits. `pixels` lies within the guard band.
#[inline(always)]
fn snap(pixels: f64) -> i32 {
    (pixels * STEPS as f64 + 6_755_399_441_055_744.0).to_bits() as i32
}

/// What remains to be done with a triangle.
pub enum Visible {
    /// It covers no pixel's centre.
    Nothing,
    /// It can be filled.
    Whole(Triangle),
    /// It may have to be clipped first, or reaches far off the image: see [`clipped`].
    Clip,
}

/// One triangle to fill.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    /// Edge functions `at + x step_x + y step_y` at the centre of pixel (x, y), not negative inside.
    pub edges: [Edge; 3],
    /// Pixels that may be covered: first and last column, first and last row.
    pub columns: [u16; 2],
    /// Rows.
    pub rows: [u16; 2],
    /// Reversed depth.
    pub depth: Plane,
    /// Least and greatest depth of the corners.
    pub range: [f64; 2],
    /// Object + 1 and triangle.
    pub id: [u32; 2],
    /// Index of its texture coordinates, or [`SOLID`].
    pub masked: u32,
}

/// An edge function in sub-pixel steps squared.
#[derive(Clone, Copy, Debug, Default)]
pub struct Edge {
    pub at: i64,
    pub step_x: i64,
    pub step_y: i64,
}

/// A value that is linear on the screen: `at` in the point `origin`, pixels.
#[derive(Clone, Copy, Debug, Default)]
pub struct Plane {
    pub origin: DVec2,
    pub at: f64,
    pub slope: DVec2,
}

/// Texture coordinates of a triangle with a mask.
#[derive(Clone, Copy, Debug)]
pub struct Masked {
    /// Index of the mask.
    pub mask: u32,
    /// u / w, v / w and 1 / w.
    pub planes: [Plane; 3],
}

impl Masked {
    /// `corners` are those of the triangle before clipping.
    pub fn new(mask: u32, projection: &Projection, corners: &[Corner; 3]) -> Self {
        let plane = |values| Plane::solved(projection, corners, values);
        let [u, v] = [corners.map(|c| c.uv.x), corners.map(|c| c.uv.y)];
        Self { mask, planes: [plane(u), plane(v), plane([1.0; 3])] }
    }

    /// Texture coordinates at the centre of pixel (`x`, `y`).
    pub fn uv(&self, x: u32, y: u32) -> Vec2 {
        let [u, v, w] = self.planes.map(|p| p.row(y).at(x));
        DVec2::new(u / w, v / w).as_vec2()
    }
}

impl Plane {
    /// What is `value / w` at three corners that may lie anywhere, off the image and behind the eye:
    /// `a x + b y + c w = value` at each. 0 where they and the eye lie in one plane.
    fn solved(projection: &Projection, corners: &[Corner; 3], values: [f64; 3]) -> Self {
        let [p, q, r] = corners.map(|c| DVec3::new(c.clip.x, c.clip.y, c.clip.w));
        let normals = [q.cross(r), r.cross(p), p.cross(q)];
        let volume = p.dot(normals[0]);
        let sum = normals[0] * values[0] + normals[1] * values[1] + normals[2] * values[2];
        let solved = if volume == 0.0 { DVec3::ZERO } else { sum / volume };
        let half = projection.half;
        let slope = DVec2::new(solved.x / half.x, -solved.y / half.y);
        Self { origin: half, at: solved.z, slope }
    }

    /// A plane through three corners; level where they lie in one line.
    #[inline(always)]
    pub fn through(corners: &[OnScreen; 3], values: [f64; 3]) -> Self {
        let [a, b, c] = corners;
        let (bx, by, bv) = (b.x - a.x, b.y - a.y, values[1] - values[0]);
        let (cx, cy, cv) = (c.x - a.x, c.y - a.y, values[2] - values[0]);
        let area = bx * cy - by * cx;
        let inverse = if area == 0.0 { 0.0 } else { 1.0 / area };
        Self {
            origin: DVec2::new(a.x, a.y),
            at: values[0],
            slope: DVec2::new((bv * cy - by * cv) * inverse, (bx * cv - bv * cx) * inverse),
        }
    }

    #[inline(always)]
    pub fn row(&self, y: u32) -> Row {
        Row {
            origin: self.origin.x - 0.5,
            at: self.at + self.slope.y * (f64::from(y) + 0.5 - self.origin.y),
            slope: self.slope.x,
        }
    }
}

/// A [`Plane`] along the centres of a row.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    origin: f64,
    at: f64,
    slope: f64,
}

impl Row {
    #[inline(always)]
    pub fn at(&self, x: u32) -> f64 {
        self.at + self.slope * (f64::from(x) - self.origin)
    }
}

/// Widest span of corners of which [`Plane::through`] is exact enough, pixels.
const WIDE: i32 = 4096;

/// A triangle of three corners, if it covers a pixel's centre and needs no further care.
#[inline(always)]
pub fn setup(projection: &Projection, corners: [&Snapped; 3], id: [u32; 2]) -> Visible {
    let [a, b, c] = corners;
    if a.outside & b.outside & c.outside & !FAR_OFF != 0 {
        return Visible::Nothing;
    }
    if (a.outside | b.outside | c.outside) & (NEAR | FAR_OFF) != 0 {
        return Visible::Clip;
    }
    let wide =
        |t: [i32; 3]| t[0].max(t[1]).max(t[2]) - t[0].min(t[1]).min(t[2]) > WIDE * STEPS as i32;
    if wide([a.x, b.x, c.x]) || wide([a.y, b.y, c.y]) {
        return Visible::Clip;
    }
    let depth = || Plane::through(&corners.map(|c| c.screen), corners.map(|c| c.screen.depth));
    match filled(projection, corners, id, depth) {
        Some(triangle) => Visible::Whole(triangle),
        None => Visible::Nothing,
    }
}

/// What of a triangle can be seen, in parts that can be filled.
#[cold]
pub fn clipped(
    projection: &Projection,
    corners: &[Corner; 3],
    id: [u32; 2],
    mut part: impl FnMut(Triangle),
) {
    let depth = Plane::solved(projection, corners, corners.map(|c| c.clip.z));
    for corners in Polygon::clipped(corners).clip_guard(projection).triangles() {
        // A corner that clipping put on the near plane may lie before it by its rounding.
        let snapped = corners.map(|c| {
            let clip = DVec4::new(c.clip.x, c.clip.y, c.clip.z.min(c.clip.w), c.clip.w);
            Snapped::new(projection, clip)
        });
        let outside = snapped.iter().fold(0, |all, c| all | c.outside);
        if outside & (NEAR | FAR_OFF) == 0
            && let Some(triangle) = filled(projection, snapped.each_ref(), id, || depth)
        {
            part(triangle);
        }
    }
}

/// A triangle of corners within the guard band, if it covers a pixel's centre.
#[inline(always)]
fn filled(
    projection: &Projection,
    corners: [&Snapped; 3],
    id: [u32; 2],
    depth: impl Fn() -> Plane,
) -> Option<Triangle> {
    let [a, b, c] = corners;
    let columns = centres([a.x, b.x, c.x], projection.width)?;
    let rows = centres([a.y, b.y, c.y], projection.height)?;
    let (bx, by) = (i64::from(b.x - a.x), i64::from(b.y - a.y));
    let (cx, cy) = (i64::from(c.x - a.x), i64::from(c.y - a.y));
    let area = bx * cy - by * cx;
    if area == 0 {
        return None;
    }
    let edges = if area > 0 {
        [Edge::new(a, b), Edge::new(b, c), Edge::new(c, a)]
    } else {
        [Edge::new(b, a), Edge::new(c, b), Edge::new(a, c)]
    };
    let d = corners.map(|c| c.screen.depth);
    let range = [d[0].min(d[1]).min(d[2]), d[0].max(d[1]).max(d[2])];
    Some(Triangle { edges, columns, rows, depth: depth(), range, id, masked: SOLID })
}

/// Centres of pixels from the least to the greatest coordinate: first and last.
#[inline(always)]
fn centres(t: [i32; 3], pixels: u32) -> Option<[u16; 2]> {
    let least = t[0].min(t[1]).min(t[2]);
    let greatest = t[0].max(t[1]).max(t[2]);
    let half = STEPS as i32 / 2;
    let first = ((least + half - 1) >> 8).max(0);
    let last = ((greatest - half) >> 8).min(pixels as i32 - 1);
    (first <= last).then_some([first as u16, last as u16])
}

impl Edge {
    /// From `a` to `b` of a triangle that runs clockwise as seen. A centre on a left or a top edge
    /// is inside, on another one outside.
    #[inline(always)]
    fn new(a: &Snapped, b: &Snapped) -> Self {
        let (ax, ay) = (i64::from(a.x), i64::from(a.y));
        let (dx, dy) = (i64::from(b.x) - ax, i64::from(b.y) - ay);
        let owned = dy < 0 || (dy == 0 && dx > 0);
        let centre = STEPS / 2;
        Self {
            at: dx * (centre - ay) - dy * (centre - ax) - i64::from(!owned),
            step_x: -dy * STEPS,
            step_y: dx * STEPS,
        }
    }
}
