//! From local space to the screen: projection and clipping, in f64.

use super::super::{Bounds, Object, Template, View};
use glam::{DMat4, DVec2, DVec3, DVec4, Vec2, Vec3};

/// Corners of the twelve triangles of a box, indices into [`Bounds::corners`].
pub const BOX: [[u8; 3]; 12] = [
    [0, 2, 4],
    [2, 6, 4],
    [1, 5, 3],
    [3, 5, 7],
    [0, 4, 1],
    [1, 4, 5],
    [2, 3, 6],
    [3, 7, 6],
    [0, 1, 2],
    [1, 3, 2],
    [4, 6, 5],
    [5, 6, 7],
];

/// A corner before the division by w.
#[derive(Clone, Copy, Debug, Default)]
pub struct Corner {
    pub clip: DVec4,
    pub uv: DVec2,
}

/// A corner on the screen: pixels from the top left, and reversed depth.
#[derive(Clone, Copy, Debug, Default)]
pub struct OnScreen {
    pub x: f64,
    pub y: f64,
    pub depth: f64,
}

/// One view's way to its image.
#[derive(Clone, Copy, Debug)]
pub struct Projection {
    eye: DVec3,
    // Takes points relative to the eye, so that the distance from the origin costs no digits.
    clip: DMat4,
    /// Half the image's sides, pixels.
    pub half: DVec2,
    pub width: u32,
    pub height: u32,
}

/// Farthest a corner may lie off the image in clipping by [`Polygon::clip_guard`], pixels: edge
/// functions of such corners in 1/256 pixels stay within i64.
pub const GUARD: f64 = (1 << 21) as f64;

impl Projection {
    pub fn new(view: &View) -> Self {
        Self {
            eye: view.eye,
            clip: view.clip * DMat4::from_translation(view.eye),
            half: 0.5 * DVec2::new(f64::from(view.width), f64::from(view.height)),
            width: view.width,
            height: view.height,
        }
    }

    #[inline(always)]
    pub fn clip(&self, local: Vec3) -> DVec4 {
        self.clip * (local.as_dvec3() - self.eye).extend(1.0)
    }

    /// `clip` lies at or beyond the near plane.
    #[inline(always)]
    pub fn screen(&self, clip: DVec4) -> OnScreen {
        let inverse = 1.0 / clip.w;
        OnScreen {
            x: (clip.x * inverse + 1.0) * self.half.x,
            y: (1.0 - clip.y * inverse) * self.half.y,
            depth: clip.z * inverse,
        }
    }

    /// The corners of triangle `index` of a placed template.
    pub fn triangle(&self, object: &Object, template: &Template, index: usize) -> [Corner; 3] {
        template.triangles[index].map(|c| Corner {
            clip: self.clip(object.place(template.positions[c as usize])),
            uv: template.uvs.get(c as usize).copied().unwrap_or(Vec2::ZERO).as_dvec2(),
        })
    }

    /// The twelve triangles of a box.
    pub fn triangles_of(&self, bounds: &Bounds) -> [[Corner; 3]; 12] {
        let corners = bounds.corners().map(|p| Corner { clip: self.clip(p), uv: DVec2::ZERO });
        BOX.map(|t| t.map(|c| corners[usize::from(c)]))
    }

    /// How far inside each side of the guard band a corner lies, in units of `w`'s.
    fn guards(&self) -> [impl Fn(DVec4) -> f64; 4] {
        let half = self.half;
        let side = move |sign: f64, horizontal: bool| {
            move |c: DVec4| {
                let (v, half) = if horizontal { (c.x, half.x) } else { (c.y, half.y) };
                (GUARD - half) * c.w + sign * v * half
            }
        };
        [side(1.0, true), side(-1.0, true), side(1.0, false), side(-1.0, false)]
    }
}

/// How far beyond the near plane a corner lies, not negative where it can be seen.
#[inline(always)]
pub fn beyond_near(clip: DVec4) -> f64 {
    clip.w - clip.z
}

const MOST_CORNERS: usize = 12;

/// A convex polygon: a triangle, and what clipping leaves of it.
#[derive(Clone, Copy, Debug)]
pub struct Polygon {
    corners: [Corner; MOST_CORNERS],
    count: usize,
}

impl Polygon {
    /// What of a triangle lies beyond the near plane.
    pub fn clipped(triangle: &[Corner; 3]) -> Self {
        let mut corners = [Corner::default(); MOST_CORNERS];
        corners[..3].copy_from_slice(triangle);
        let whole = Self { corners, count: 3 };
        if triangle.iter().all(|c| beyond_near(c.clip) >= 0.0) {
            return whole;
        }
        whole.cut(beyond_near)
    }

    /// What of it lies within [`GUARD`] pixels of the image.
    #[must_use]
    pub fn clip_guard(self, projection: &Projection) -> Self {
        projection.guards().iter().fold(self, |polygon, side| polygon.cut(side))
    }

    /// The triangles it consists of.
    pub fn triangles(&self) -> impl Iterator<Item = [Corner; 3]> + '_ {
        (2..self.count).map(|i| [self.corners[0], self.corners[i - 1], self.corners[i]])
    }

    // Cut edges run from inside to outside, so both triangles of an edge get the same new corner.
    // A corner that is not a number is outside.
    fn cut(&self, inside: impl Fn(DVec4) -> f64) -> Self {
        let mut left = Self { corners: [Corner::default(); MOST_CORNERS], count: 0 };
        let corners = &self.corners[..self.count];
        for (i, a) in corners.iter().enumerate() {
            let b = &corners[(i + 1) % corners.len()];
            let (at_a, at_b) = (inside(a.clip), inside(b.clip));
            if at_a >= 0.0 {
                left.push(*a);
            }
            if (at_a >= 0.0) && (at_b < 0.0) {
                left.push(between(a, b, at_a / (at_a - at_b)));
            } else if (at_b >= 0.0) && (at_a < 0.0) {
                left.push(between(b, a, at_b / (at_b - at_a)));
            }
        }
        left
    }

    // Rounding may make a polygon wave about a plane; what is more than the array holds is less
    // than a sample.
    fn push(&mut self, corner: Corner) {
        if self.count < MOST_CORNERS {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }
}

fn between(inner: &Corner, outer: &Corner, t: f64) -> Corner {
    Corner {
        clip: inner.clip + (outer.clip - inner.clip) * t,
        uv: inner.uv + (outer.uv - inner.uv) * t,
    }
}
