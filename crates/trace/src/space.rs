//! The space rays are traced in: the scene recentred and scaled into the cube -1..=1, and what it
//! takes for f32 boxes there never to lose a hit.
//!
//! Error analysis of the box test (`obvhs::aabb::Aabb::intersect_ray`). Let eps = 2^-24, o the
//! ray's origin, d its unit direction (both f64), p = o + t d a point of a triangle with t >= 0.
//! After [`PreparedRay::new`] every |o_i| <= 2 and every |p_i| <= 1, so |t d_i| <= 3 and
//! t <= 3 sqrt(3) < 5.2. Per axis, with d_i > 0 (the other sign mirrors it) and the box grown by P:
//!
//! - o is rounded to f32: an absolute error of at most 2 eps / 2 = eps.
//! - d_i, its reciprocal, the difference (bound - o_i) and the product are each rounded once: a
//!   relative error of at most 4.01 eps in the slab distance.
//! - So the near slab is at most (t d_i - P + eps) / d_i (1 + 4.01 eps), which is <= t if
//!   P >= eps + 3 * 4.01 eps (1 + small) = 13.1 eps; the far slab is >= t by the same condition.
//! - `safe_inverse` replaces |d_i| <= 2^-23 by 2^-23 of the same sign (of 0 by +2^-23, of -0 by
//!   -2^-23), so no 0 * inf arises, and the reciprocal is exact. The ray drifts by at most
//!   t * 2^-23 <= 10.4 eps: P >= 11.5 eps.
//!
//! [`BOX_PAD`] = 16 eps meets both and leaves 2.9 eps = 1.7e-7, far above the 1e-15 by which the f64
//! triangle test itself may accept a point outside the triangle. Then every box around p reports
//! near <= t <= far with far >= 0. Traversal compares `near < tmax`, strictly; [`above`] makes the
//! f32 `tmax` strictly greater than the f64 distance, so ties are visited too. `tmin` does not
//! prune.

use crate::tracer::Ray;
use crate::watertight::{Corners, Crossing, ShearedRay};
use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb as Box32;

/// How much every f32 box is grown, in units of the normalised space.
pub const BOX_PAD: f64 = 1.0 / (1 << 20) as f64;

/// Rays start inside the cube of this half side; the scene fills at most half of it.
const REACH: f64 = 2.0;

/// The map from world space to the normalised space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Space {
    /// World position of the normalised origin.
    pub centre: DVec3,
    /// Normalised units a metre; a power of two, so that scaling is exact.
    pub scale: f64,
}

impl Space {
    /// The space of a box; `None` where the box is too large for finite arithmetic.
    pub fn of(min: DVec3, max: DVec3) -> Option<Self> {
        let centre = min * 0.5 + max * 0.5;
        let half = (max * 0.5 - min * 0.5).max_element();
        if !(half < 1e300 && centre.is_finite()) {
            return None;
        }
        // half lies in 2^e..2^(e+1); a scene of a single point keeps a scale of 1.
        let exponent = (half.to_bits() >> 52) as i32 - 1023;
        let scale =
            if half > 0.0 { 2.0_f64.powi((-(exponent + 1)).clamp(-1000, 1000)) } else { 1.0 };
        Some(Self { centre, scale })
    }

    /// World to normalised. Equal points stay equal.
    pub fn enter(&self, p: DVec3) -> DVec3 {
        (p - self.centre) * self.scale
    }

    /// Normalised to world.
    pub fn leave(&self, p: DVec3) -> DVec3 {
        p / self.scale + self.centre
    }
}

/// The f32 box of some normalised points, grown by [`BOX_PAD`] and rounded outward.
pub fn padded_box(corners: &Corners) -> Box32 {
    let [a, b, c] = corners.map(DVec3::from_array);
    let (lo, hi) = (a.min(b).min(c) - BOX_PAD, a.max(b).max(c) + BOX_PAD);
    let down = lo.to_array().map(|x| (x as f32).next_down());
    let up = hi.to_array().map(|x| (x as f32).next_up());
    Box32::new(Vec3A::from_array(down), Vec3A::from_array(up))
}

/// An f32 strictly above `t`.
pub fn above(t: f64) -> f32 {
    (t as f32).next_up()
}

/// A ray in normalised space, moved along itself to where the scene may begin.
pub struct PreparedRay {
    /// For the triangle test: see [`PreparedRay::meet`].
    sheared: ShearedRay,
    /// For the boxes.
    pub coarse: obvhs::ray::Ray,
    /// Range of distances from the moved origin.
    pub t_min: f64,
    /// See `t_min`.
    pub t_max: f64,
    start: f64,
    length: f64,
    scale: f64,
}

impl PreparedRay {
    /// `None` where the ray cannot hit anything: not finite, no direction, an empty range, or past
    /// the scene.
    pub fn new(ray: &Ray, space: &Space) -> Option<Self> {
        let longest = ray.direction.abs().max_element();
        // NaN fails the comparisons; max_element may drop it, so all components are asked.
        let usable = longest > 0.0 && ray.direction.is_finite() && ray.t_min <= ray.t_max;
        if !usable {
            return None;
        }
        // First by the longest component: the squares of 1e-200 or 1e200 are out of range.
        let relative = ray.direction / longest;
        let relative_length = relative.length();
        let length = relative_length * longest;
        let mut d = relative / relative_length;
        // Less than any rounding of a distance, and its reciprocal would overflow.
        for i in 0..3 {
            if d[i].abs() < 1e-300 {
                d[i] = 0.0;
            }
        }
        let o = space.enter(ray.origin);
        if !(o.is_finite() && length.is_finite()) {
            return None;
        }
        let t_min = ray.t_min * length * space.scale;
        let t_max = ray.t_max * length * space.scale;
        let (mut start, mut end) = (t_min.min(0.0), t_max);
        for i in 0..3 {
            if d[i] == 0.0 {
                if o[i].abs() > REACH {
                    return None;
                }
                continue;
            }
            let (a, b) = ((-REACH - o[i]) / d[i], (REACH - o[i]) / d[i]);
            start = start.max(a.min(b));
            end = end.min(a.max(b));
        }
        // Of NaN too there is nothing to find.
        let may_hit = start <= end;
        if !may_hit {
            return None;
        }
        // The clamp only acts where rounding at a far origin left the cube.
        let reach = DVec3::splat(REACH);
        let origin = if start == 0.0 { o } else { (o + d * start).clamp(-reach, reach) };
        let t_max_moved = t_max - start;
        Some(Self {
            sheared: ShearedRay::new(origin.to_array(), d.to_array()),
            coarse: obvhs::ray::Ray::new(
                Vec3A::from(origin.as_vec3()),
                Vec3A::from(d.as_vec3()),
                0.0,
                above(t_max_moved),
            ),
            t_min: (t_min - start).max(0.0),
            t_max: t_max_moved,
            start,
            length,
            scale: space.scale,
        })
    }

    /// Where the ray meets a triangle, at any distance from the moved origin.
    ///
    /// The distance to a triangle crossed edge-on is rounding noise between its corners' distances.
    /// The triangle's own box bounds it from below, so that no crossing is nearer than the boxes on
    /// the way to it, and traversal finds what asking every triangle finds. For any other crossing
    /// this changes nothing. `ONCE` is as in [`crate::watertight::weigh`].
    #[inline(always)]
    pub fn meet<const ONCE: bool>(&self, corners: &Corners) -> Option<Crossing> {
        let crossing = self.sheared.cross::<ONCE>(corners)?;
        let near = f64::from(padded_box(corners).intersect_ray(&self.coarse));
        (near < f64::INFINITY).then_some(Crossing { t: crossing.t.max(near), ..crossing })
    }

    /// A distance from the moved origin in units of the caller's direction.
    pub fn caller_t(&self, t: f64) -> f64 {
        (self.start + t) / self.length / self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn ray(origin: DVec3, direction: DVec3) -> Ray {
        Ray { origin, direction, t_min: 0.0, t_max: f64::INFINITY }
    }

    #[test]
    fn the_scale_is_a_power_of_two_that_fits_the_cube() {
        for size in [1e-300, 1e-6, 0.5, 1.0, 3.0, 1e6, 1e299] {
            let space = Space::of(DVec3::ZERO, DVec3::splat(2.0 * size)).unwrap();
            assert_eq!(space.scale.to_bits() << 12, 0, "a power of two");
            let reach = space.enter(DVec3::splat(2.0 * size)).x;
            assert!((0.5..=1.0).contains(&reach), "{size}: {reach}");
        }
        assert_eq!(Space::of(DVec3::ONE, DVec3::ONE).unwrap().scale, 1.0);
        assert_eq!(Space::of(DVec3::splat(-1e305), DVec3::splat(1e305)), None);
    }

    #[test]
    fn far_origins_are_moved_to_the_scene() {
        let space = Space { centre: DVec3::ZERO, scale: 1.0 };
        let far =
            PreparedRay::new(&ray(DVec3::new(-1e6, 0.0, 0.0), DVec3::X * 4.0), &space).unwrap();
        assert_eq!(far.coarse.origin, Vec3A::new(-2.0, 0.0, 0.0));
        assert_eq!(far.caller_t(2.0), 1e6 / 4.0);
        let past = ray(DVec3::new(-1e6, 0.0, 0.0), -DVec3::X);
        assert!(PreparedRay::new(&past, &space).is_none());
    }

    fn cases() -> u32 {
        std::env::var("PROPTEST_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(4096)
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: cases(), ..ProptestConfig::default() })]

        // The statement of the error analysis, tried at points of flat boxes (where it is tight),
        // with directions of which some components are tiny or zero.
        #[test]
        fn a_box_around_a_point_of_the_ray_is_entered_no_later(
            o in prop::array::uniform3(-2.0..2.0_f64),
            p in prop::array::uniform3(-1.0..1.0_f64),
            flat in 0..8_u8,
            squeeze in prop::array::uniform2(prop::sample::select(
                vec![1.0, 1.0, 1e-3, 1e-6, 1.2e-7, 1e-7, 1e-9, 0.0])),
            kept in 0..3_usize,
        ) {
            let (mut o, p) = (DVec3::from_array(o), DVec3::from_array(p));
            // All but one component of o come close to those of p.
            o[(kept + 1) % 3] = p[(kept + 1) % 3] + (o - p)[(kept + 1) % 3] * squeeze[0];
            o[(kept + 2) % 3] = p[(kept + 2) % 3] + (o - p)[(kept + 2) % 3] * squeeze[1];
            let d = p - o;
            prop_assume!(d.length() > 1e-3);
            let space = Space { centre: DVec3::ZERO, scale: 1.0 };
            let prepared = PreparedRay::new(&ray(o, d), &space).unwrap();
            let t = d.length();
            // A degenerate "triangle" at p, wide on the axes whose bit in `flat` is set.
            let wide = DVec3::from_array(std::array::from_fn(|i| f64::from(flat >> i & 1) * 0.1));
            let corners = [p.to_array(), (p + wide).to_array(), (p - wide).to_array()];
            let near = padded_box(&corners).intersect_ray(&prepared.coarse);
            prop_assert!(f64::from(near) <= t * (1.0 + 1e-15), "near {near} t {t}");
            prop_assert!(near < above(t));
        }
    }

    // Without the pad the same boxes are lost: the property above can fail.
    #[test]
    fn unpadded_boxes_lose_points() {
        let space = Space { centre: DVec3::ZERO, scale: 1.0 };
        let lost = (0..1000)
            .filter(|&i| {
                let o = DVec3::new(-1.7 + 1e-3 * f64::from(i), 0.3, -0.77);
                let p = DVec3::new(0.1, 0.7, 0.123 + 7e-4 * f64::from(i));
                let prepared = PreparedRay::new(&ray(o, p - o), &space).unwrap();
                let point = Vec3A::from(p.as_vec3());
                !Box32::new(point, point).intersect_ray(&prepared.coarse).is_finite()
            })
            .count();
        assert!(lost > 100, "{lost} of 1000");
    }
}
