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
pub(super) fn from_half_chord(s: f32, flip: bool) -> f32 {
    let angle = 2.0 * arc_sine(s);
    if flip { PI - angle } else { angle }
}

/// The greatest half chord of an angle up to π/2, and what rounding adds.
const HALF_CHORD: f32 = 0.7072;
