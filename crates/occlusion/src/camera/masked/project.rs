//! From positions to snapped vertices, and the clipping of the triangles that need it.

use crate::OcclusionError;
use glam::{Mat4, Vec3};

/// Steps of a pixel that vertices are snapped to.
pub(super) const STEPS: i32 = 256;
/// Distance of the guard band's planes from the middle of the image, pixels. Keeps differences of
/// snapped coordinates below 2^24, so that products of two are exact in `f64`.
const GUARD_PX: f32 = 32_768.0;
/// Vertices at a time.
const LANES: usize = 8;

const LEFT: u32 = 1;
const RIGHT: u32 = 2;
const BELOW: u32 = 4;
const ABOVE: u32 = 8;
const NEAR: u32 = 16;
const GUARD: u32 = 32;
/// A triangle whose vertices share one of these is not seen.
pub(super) const OUTSIDE: u32 = LEFT | RIGHT | BELOW | ABOVE | NEAR;
/// A triangle with such a vertex has to be clipped.
pub(super) const CLIPPED: u32 = NEAR | GUARD;

/// A vertex on the image.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(16))]
pub(super) struct Vertex {
    /// Steps from the left edge.
    pub x: i32,
    /// Steps from the top edge.
    pub y: i32,
    /// Reversed depth.
    pub z: f32,
    /// Planes that the vertex is outside of.
    pub code: u32,
}

/// Clip space to the image.
#[derive(Clone, Copy, Debug)]
pub(super) struct Projection {
    columns: [[f32; 4]; 4],
    /// Half the image, steps.
    half: [f32; 2],
    /// The guard band, in units of half the image.
    guard: [f32; 2],
}

impl Projection {
    pub(super) fn new(clip: &Mat4, width: u32, height: u32) -> Result<Self, OcclusionError> {
        if !clip.is_finite() {
            return Err(OcclusionError::value("occluder's clip matrix", "is not finite"));
        }
        let size = [width as f32, height as f32];
        Ok(Self {
            columns: clip.to_cols_array_2d(),
            half: size.map(|s| 0.5 * s * STEPS as f32),
            guard: size.map(|s| 2.0 * GUARD_PX / s),
        })
    }

    #[inline(always)]
    fn clip(&self, p: [f32; 3]) -> [f32; 4] {
        let [x, y, z, w] = &self.columns;
        std::array::from_fn(|j| x[j] * p[0] + y[j] * p[1] + z[j] * p[2] + w[j])
    }

    /// Where a point of clip space comes to lie; `x` and `y` have no meaning where it must be
    /// clipped.
    #[inline(always)]
    fn snap(&self, [x, y, z, w]: [f32; 4]) -> Vertex {
        let inverse = 1.0 / w;
        let bit = |outside: bool, bit: u32| if outside { bit } else { 0 };
        let inside_guard = (x.abs() <= self.guard[0] * w) & (y.abs() <= self.guard[1] * w);
        let code = bit(x < -w, LEFT)
            | bit(x > w, RIGHT)
            | bit(y < -w, BELOW)
            | bit(y > w, ABOVE)
            | bit(!((z <= w) & (w > 0.0)), NEAR)
            | bit(!inside_guard, GUARD);
        Vertex {
            x: (x * inverse * self.half[0] + self.half[0]).round_ties_even() as i32,
            y: (self.half[1] - y * inverse * self.half[1]).round_ties_even() as i32,
            z: z * inverse,
            code,
        }
    }

    /// Projects all positions. `false` where one is not finite, or not in clip space.
    #[inline(always)]
    pub(super) fn vertices(&self, positions: &[Vec3], out: &mut Vec<Vertex>) -> bool {
        let mut finite = true;
        out.clear();
        out.reserve(positions.len() + LANES);
        let mut chunks = positions.chunks_exact(LANES);
        for chunk in &mut chunks {
            let mut p = [[0.0; LANES]; 3];
            for (lane, position) in chunk.iter().enumerate() {
                p[0][lane] = position.x;
                p[1][lane] = position.y;
                p[2][lane] = position.z;
            }
            let mut block = [Vertex::default(); LANES];
            let mut zero = [0.0; LANES];
            for lane in 0..LANES {
                let c = self.clip([p[0][lane], p[1][lane], p[2][lane]]);
                block[lane] = self.snap(c);
                // 0 times a number is 0, unless that is infinite or none.
                zero[lane] = 0.0 * c[0] + 0.0 * c[1] + 0.0 * c[2] + 0.0 * c[3];
            }
            finite &= zero.iter().all(|&z| z == 0.0);
            out.extend_from_slice(&block);
        }
        for position in chunks.remainder() {
            let c = self.clip(position.to_array());
            finite &= c.iter().all(|c| c.is_finite());
            out.push(self.snap(c));
        }
        finite
    }

    /// Names the first position that no clip space holds.
    pub(super) fn refusal(&self, positions: &[Vec3]) -> OcclusionError {
        let bad = |p: &Vec3| self.clip(p.to_array()).iter().any(|c| !c.is_finite());
        let index = positions.iter().position(bad).unwrap_or_default();
        let place = positions.get(index).copied().unwrap_or_default();
        OcclusionError::value(
            format!("occluder vertex {index} at {place}"),
            "is not finite in clip space",
        )
    }

    /// Clips a triangle against the near plane and the guard band and hands on the triangles of
    /// what is left. A new vertex is computed from the inside of its edge to the outside, so that
    /// both triangles at the edge get the same.
    pub(super) fn clipped(
        &self,
        corners: [(Vec3, Vertex); 3],
        open: [bool; 3],
        mut each: impl FnMut([Vertex; 3], [bool; 3]),
    ) {
        let corner = |i: usize| {
            let (p, vertex) = corners[i];
            let at = self.clip(p.to_array()).map(f64::from);
            Corner { at, vertex: (vertex.code & CLIPPED == 0).then_some(vertex), open: open[i] }
        };
        let mut polygon = Polygon::EMPTY;
        (0..3).for_each(|i| polygon.push(corner(i)));
        let [gx, gy] = self.guard.map(f64::from);
        let planes: [[f64; 4]; 5] = [
            [0.0, 0.0, -1.0, 1.0],
            [1.0, 0.0, 0.0, gx],
            [-1.0, 0.0, 0.0, gx],
            [0.0, 1.0, 0.0, gy],
            [0.0, -1.0, 0.0, gy],
        ];
        for plane in planes {
            polygon = cut(polygon.corners(), plane);
        }
        let polygon = polygon.corners();
        if polygon.len() < 3 || polygon.iter().any(|c| c.at[3] <= 0.0) {
            return;
        }
        let flat = |i: usize| {
            let corner = &polygon[i];
            corner.vertex.unwrap_or_else(|| self.snap(corner.at.map(|v| v as f32)))
        };
        let last = polygon.len() - 1;
        for i in 1..last {
            let edges =
                [i == 1 && polygon[0].open, polygon[i].open, i + 1 == last && polygon[last].open];
            each([flat(0), flat(i), flat(i + 1)], edges);
        }
    }
}

/// A corner of a polygon in clip space and the edge from it to the next.
#[derive(Clone, Copy)]
struct Corner {
    at: [f64; 4],
    /// Its place on the image, of corners that were there before clipping.
    vertex: Option<Vertex>,
    open: bool,
}

/// Five cuts give a triangle at most five more corners.
const MOST_CORNERS: usize = 12;

/// What cuts leave of a triangle; takes nothing from the heap.
struct Polygon {
    corners: [Corner; MOST_CORNERS],
    count: usize,
}

impl Polygon {
    const EMPTY: Self = {
        let corner = Corner { at: [0.0; 4], vertex: None, open: true };
        Self { corners: [corner; MOST_CORNERS], count: 0 }
    };

    fn corners(&self) -> &[Corner] {
        &self.corners[..self.count]
    }

    // Rounding may make a polygon wave about a plane; what is more than the array holds is less
    // than a step of the grid.
    fn push(&mut self, corner: Corner) {
        if self.count < MOST_CORNERS {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }
}

fn cut(polygon: &[Corner], plane: [f64; 4]) -> Polygon {
    let distance = |c: &Corner| (0..4).map(|j| plane[j] * c.at[j]).sum::<f64>();
    let mut kept = Polygon::EMPTY;
    for (i, corner) in polygon.iter().enumerate() {
        let next = &polygon[(i + 1) % polygon.len()];
        let (here, there) = (distance(corner), distance(next));
        let between = |inside: &Corner, d_in: f64, outside: &Corner, d_out: f64, open: bool| {
            let t = d_in / (d_in - d_out);
            let at = std::array::from_fn(|j| inside.at[j] + t * (outside.at[j] - inside.at[j]));
            Corner { at, vertex: None, open }
        };
        match (here >= 0.0, there >= 0.0) {
            (true, true) => kept.push(*corner),
            (true, false) => {
                kept.push(*corner);
                // What follows runs along the plane: outside of the image, or in front of the near
                // plane, where nothing else closes it.
                kept.push(between(corner, here, next, there, true));
            }
            (false, true) => kept.push(between(next, there, corner, here, corner.open)),
            (false, false) => {}
        }
    }
    kept
}
