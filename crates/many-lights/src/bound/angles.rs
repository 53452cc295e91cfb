//! Angles and cosines in f32, operation for operation as `common/lights.wgsl` has them: what a device
//! calls acos and cos may be off by 1e-3.

use glam::Vec3;
use std::f32::consts::{FRAC_PI_2, PI};

/// asin(s) = s + s t R(t), t = s², 0 <= s <= sin(π/4): relative error below 1.1e-7 by itself.
const ARC: [f32; 6] =
    [0.166_653_74, 0.075_470_95, 0.039_009_277, 0.060_530_853, -0.054_722_47, 0.100_911_53];

/// sin(y) = y + y t R(t), t = y², 0 <= y <= π/4: relative error below 3.8e-9 by itself.
const SINE: [f32; 3] = [-0.166_666_55, 0.008_332_16, -0.000_195_152_82];

/// The arc sine of a number in 0..=0.7072.
#[inline(always)]
pub fn arc_sine(s: f32) -> f32 {
    let t = s * s;
    let mut series = ARC[5];
    series = ARC[4] + t * series;
    series = ARC[3] + t * series;
    series = ARC[2] + t * series;
    series = ARC[1] + t * series;
    series = ARC[0] + t * series;
    s + s * t * series
}

/// The cosine of an angle of at least 0, but 0 from π/2 on.
#[inline(always)]
pub fn cosine_or_none(angle_rad: f32) -> f32 {
    let y = 0.5 * angle_rad;
    let t = y * y;
    let sine = y + y * t * (SINE[0] + t * (SINE[1] + t * SINE[2]));
    if angle_rad >= FRAC_PI_2 { 0.0 } else { (1.0 - 2.0 * sine * sine).max(0.0) }
}

/// The angle between two unit vectors, radians, by their distance: as exact near 0 and π as elsewhere.
#[inline(always)]
pub fn angle_between(a: Vec3, b: Vec3) -> f32 {
    let flip = a.dot(b) < 0.0;
    let chord = if flip { a + b } else { a - b };
    from_half_chord((0.5 * chord.length()).min(HALF_CHORD), flip)
}

/// The angle whose half has the sine `s`; what is left of it to π where `flip`.
#[inline(always)]
pub(crate) fn from_half_chord(s: f32, flip: bool) -> f32 {
    let angle = 2.0 * arc_sine(s);
    if flip { PI - angle } else { angle }
}

/// The greatest half chord of an angle up to π/2, and what rounding adds.
pub(crate) const HALF_CHORD: f32 = 0.7072;

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn arc_sines_are_good_to_a_few_roundings() {
        for i in 1..=100_000 {
            let s = HALF_CHORD * i as f32 / 100_000.0;
            let exact = f64::from(s).asin();
            let error = (f64::from(arc_sine(s)) - exact).abs() / exact;
            assert!(error < 3e-7, "{s}: {error}");
        }
        assert_eq!(arc_sine(0.0), 0.0);
    }

    #[test]
    fn cosines_are_good_to_a_few_roundings_and_end_at_a_right_angle() {
        for i in 0..=100_000 {
            let angle = PI * i as f32 / 100_000.0;
            let error = f64::from(cosine_or_none(angle)) - f64::from(angle).cos().max(0.0);
            assert!(error.abs() < 2e-7, "{angle}: {error}");
        }
        assert_eq!(cosine_or_none(f32::MAX), 0.0);
    }

    #[test]
    fn angles_keep_their_digits_near_0_and_near_a_half_turn() {
        let exact = |a: Vec3, b: Vec3| crate::light::angle(a.as_dvec3(), b.as_dvec3());
        let a = DVec3::new(0.6, 0.0, 0.8);
        let across = DVec3::new(0.0, 1.0, 0.0);
        for i in 0..2000 {
            // From 1e-7 to a half turn less 1e-7.
            let small = 10f64.powf(-7.0 + 7.5 * f64::from(i) / 2000.0).min(3.1);
            for turn in [small, std::f64::consts::PI - small] {
                let b = (a * turn.cos() + across * turn.sin()).as_vec3();
                let got = f64::from(angle_between(a.as_vec3(), b));
                let off = (got - exact(a.as_vec3(), b)).abs();
                assert!(off < 4e-7, "{turn}: off by {off}");
            }
        }
        assert_eq!(angle_between(Vec3::X, Vec3::X), 0.0);
        assert_eq!(angle_between(Vec3::X, -Vec3::X), PI);
        // What the arc cosine of the product makes of an angle of 1e-4.
        let b = Vec3::new(1.0, 1e-4, 0.0);
        assert!((b.x.acos() - 1e-4).abs() > 9e-5);
    }
}
