//! Whether and where a ray meets a triangle, without gaps along shared edges.
//!
//! Based on: S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", Journal of
//! Computer Graphics Techniques 2(1), 2013, section 3.
//!
//! Deviations: all arithmetic is f64 instead of f32 with an f64 fallback for zero edge functions:
//! rounding is monotonic, so a computed edge function is zero or has the sign of the exact one, and
//! zero counts as inside. A test against the box of the sheared corners removes false hits of
//! triangles seen edge-on. Two-sided, so the winding-preserving swap of kx and ky is left out.

/// A triangle's corners.
pub type Corners = [[f64; 3]; 3];

/// Where a ray crosses a triangle's plane inside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Distance in units of the ray's direction.
    pub t: f64,
    /// Weight of the second corner.
    pub u: f64,
    /// Weight of the third corner.
    pub v: f64,
}

/// A ray with the shear that maps its direction onto one axis.
#[derive(Clone, Copy, Debug)]
pub struct ShearedRay {
    origin: [f64; 3],
    // kz of the paper: the longest component of the direction.
    axis: u8,
    shear_x: f64,
    shear_y: f64,
    inverse_z: f64,
}

impl ShearedRay {
    /// `direction` is finite and not zero.
    pub fn new(origin: [f64; 3], direction: [f64; 3]) -> Self {
        let size = direction.map(f64::abs);
        let kz = if size[0] >= size[1] && size[0] >= size[2] {
            0
        } else if size[1] >= size[2] {
            1
        } else {
            2
        };
        let z = direction[kz];
        Self {
            origin,
            axis: kz as u8,
            shear_x: direction[(kz + 1) % 3] / z,
            shear_y: direction[(kz + 2) % 3] / z,
            inverse_z: 1.0 / z,
        }
    }

    /// The crossing at any distance, before or behind the origin. Borders count: see [`weigh`] for
    /// what `ONCE` makes of them.
    #[inline(always)]
    pub fn cross<const ONCE: bool>(&self, corners: &Corners) -> Option<Crossing> {
        match self.axis {
            0 => self.cross_along::<0, 1, 2, ONCE>(corners),
            1 => self.cross_along::<1, 2, 0, ONCE>(corners),
            _ => self.cross_along::<2, 0, 1, ONCE>(corners),
        }
    }

    // A vertex is sheared by itself, so both triangles of an edge see the same two points.
    #[inline(always)]
    fn cross_along<const Z: usize, const X: usize, const Y: usize, const ONCE: bool>(
        &self,
        corners: &Corners,
    ) -> Option<Crossing> {
        let sheared = |p: &[f64; 3]| {
            let z = p[Z] - self.origin[Z];
            let x = (p[X] - self.origin[X]) - self.shear_x * z;
            let y = (p[Y] - self.origin[Y]) - self.shear_y * z;
            ([x, y], z)
        };
        let (a, az) = sheared(&corners[0]);
        let (b, bz) = sheared(&corners[1]);
        let (c, cz) = sheared(&corners[2]);
        let Weights { a: u, b: v, c: w, inverse } = weigh::<ONCE>(a, b, c)?;
        // + 0.0 turns -0.0 into 0.0: at the origin itself all crossings are at one distance.
        let t = (u * az + v * bz + w * cz) * inverse * self.inverse_z + 0.0;
        Some(Crossing { t, u: v * inverse, v: w * inverse })
    }
}

/// What each corner of a triangle weighs at the origin, times the sum of the three.
#[derive(Clone, Copy, Debug)]
pub struct Weights {
    /// Of the first corner.
    pub a: f64,
    /// Of the second one.
    pub b: f64,
    /// Of the third one.
    pub c: f64,
    /// One over their sum.
    pub inverse: f64,
}

/// The weights of a triangle's corners at the origin of the plane, `None` where the origin lies
/// outside it or the triangle has no area.
///
/// The two triangles of an edge compute exactly opposite edge functions, so nothing slips between
/// them. An origin on the edge itself (the computed edge function is zero) belongs to both of them,
/// or, with `ONCE`, to the one that lies on the edge's left or top side (y upwards): to one of two
/// triangles that continue each other, to both or none of two that fold back there.
#[inline(always)]
pub fn weigh<const ONCE: bool>(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> Option<Weights> {
    // Exact negatives need unfused multiplications: no mul_add.
    let edge = |p: [f64; 2], q: [f64; 2]| p[0] * q[1] - p[1] * q[0];
    let (u, v, w) = (edge(c, b), edge(a, c), edge(b, a));
    if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
        return None;
    }
    let determinant = u + v + w;
    if determinant == 0.0 {
        return None;
    }
    // Seen edge-on in line with the origin, edge functions are noise, now and then of one sign.
    // Whatever truly covers the origin has it in the box of its corners, exactly.
    let beside = |a: f64, b: f64, c: f64| a.min(b).min(c) > 0.0 || a.max(b).max(c) < 0.0;
    if beside(a[0], b[0], c[0]) || beside(a[1], b[1], c[1]) {
        return None;
    }
    if ONCE {
        // Of an edge and its reverse exactly one is owned; their difference is exact in sign.
        let owned = |p: [f64; 2], q: [f64; 2]| {
            let (dx, dy) = (q[0] - p[0], q[1] - p[1]);
            let down = dy < 0.0 || (dy == 0.0 && dx < 0.0);
            down == (determinant > 0.0)
        };
        let lost = |weight: f64, p: [f64; 2], q: [f64; 2]| weight == 0.0 && !owned(p, q);
        if lost(u, c, b) || lost(v, a, c) || lost(w, b, a) {
            return None;
        }
    }
    Some(Weights { a: u, b: v, c: w, inverse: 1.0 / determinant })
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    #[test]
    fn crossing_of_the_unit_triangle_by_hand() {
        let ray = ShearedRay::new([0.25, 0.5, 3.0], [0.0, 0.0, -2.0]);
        let hit = ray.cross::<false>(&UNIT).unwrap();
        assert_eq!((hit.t, hit.u, hit.v), (1.5, 0.25, 0.5));
        // The other side and the other winding are hit as well.
        let back = ShearedRay::new([0.25, 0.5, -3.0], [0.0, 0.0, 2.0]);
        assert_eq!(back.cross::<false>(&UNIT).unwrap().t, 1.5);
        let flipped = [UNIT[0], UNIT[2], UNIT[1]];
        let hit = ray.cross::<false>(&flipped).unwrap();
        assert_eq!((hit.t, hit.u, hit.v), (1.5, 0.5, 0.25));
    }

    #[test]
    fn the_same_for_every_axis() {
        for k in 0..3 {
            let turn = |p: [f64; 3]| -> [f64; 3] { std::array::from_fn(|i| p[(i + k) % 3]) };
            let ray = ShearedRay::new(turn([0.1, 0.2, 1.0]), turn([0.1, 0.2, -1.0]));
            let hit = ray.cross::<false>(&UNIT.map(turn)).unwrap();
            assert!((hit.t - 1.0).abs() < 1e-15, "axis {k}");
            assert!((hit.u - 0.2).abs() < 1e-15 && (hit.v - 0.4).abs() < 1e-15, "axis {k}");
        }
    }

    #[test]
    fn edges_and_corners_count_and_the_outside_does_not() {
        for (x, y, inside) in [
            (0.0, 0.0, true),
            (1.0, 0.0, true),
            (0.0, 1.0, true),
            (0.5, 0.5, true),
            (0.5, 0.0, true),
            (0.5, -1e-15, false),
            (0.5, 0.5000001, false),
        ] {
            let ray = ShearedRay::new([x, y, 1.0], [0.0, 0.0, -1.0]);
            assert_eq!(ray.cross::<false>(&UNIT).is_some(), inside, "{x} {y}");
        }
    }

    #[test]
    fn edge_on_and_degenerate_triangles_are_missed() {
        let along = ShearedRay::new([-1.0, 0.25, 0.0], [1.0, 0.0, 0.0]);
        assert_eq!(along.cross::<false>(&UNIT), None);
        let point = ShearedRay::new([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]);
        assert_eq!(point.cross::<false>(&[[0.0; 3]; 3]), None);
        assert_eq!(point.cross::<false>(&[[f64::NAN; 3]; 3]).filter(|hit| hit.t >= 0.0), None);
    }
}
