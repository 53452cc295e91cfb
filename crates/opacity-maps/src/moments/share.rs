//! The share of a ray's absorption in front of a depth, in f32: see [`super`].

use super::{MOST, safe, safe_pivots};
use std::f32::consts::TAU;

/// Share of the absorption before x, plus `own` of that at x, 0..=1.
pub fn share_before(b: &[f32], x: f32, bias: f32, own: f32) -> f32 {
    let mut m = [1.0; MOST];
    let target = safe(b.len() as u32 - 1);
    for (j, (m, safe)) in m[1..].iter_mut().zip(target).enumerate() {
        let normal = b[j + 1] / b[0];
        *m = normal + bias * (*safe as f32 - normal);
    }
    let share = if b.len() == 5 { four(&m, x, bias, own) } else { six(&m, x, bias, own) };
    // NaN becomes 0.
    if share > 0.0 { share.min(1.0) } else { 0.0 }
}

/// With four moments.
fn four(m: &[f32; MOST], x: f32, bias: f32, own: f32) -> f32 {
    let least = safe_pivots(4);
    // B = L D L'.
    let d1 = (m[2] - m[1] * m[1]).max(bias * least[0] as f32);
    let m2 = m[1] * m[1] + d1;
    let l21 = (m[3] - m[1] * m2) / d1;
    let d2 = (m[4] - m2 * m2 - l21 * l21 * d1).max(bias * least[1] as f32);
    // Orthogonal polynomials p1, p2 at x and their derivatives.
    let p1 = x - m[1];
    let p2 = x * x - m2 - l21 * p1;
    let slope2 = 2.0 * x - l21;
    // K(x, x + e) = c0 + c1 e + c2 e^2, so that c0 s^2 + c1 s + c2 = 0.
    let c0 = 1.0 + p1 * p1 / d1 + p2 * p2 / d2;
    let c1 = p1 / d1 + p2 * slope2 / d2;
    let c2 = p2 / d2;
    let [near, far] = quadratic(c0, c1, c2);
    between([m[1] - x, m2 - 2.0 * x * m[1] + x * x, 0.0], [near, far, 0.0], own)
}

/// With six moments.
fn six(m: &[f32; MOST], x: f32, bias: f32, own: f32) -> f32 {
    let least = safe_pivots(6);
    let d1 = (m[2] - m[1] * m[1]).max(bias * least[0] as f32);
    let m2 = m[1] * m[1] + d1;
    let l21 = (m[3] - m[1] * m2) / d1;
    let below4 = m2 * m2 + l21 * l21 * d1;
    let d2 = (m[4] - below4).max(bias * least[1] as f32);
    let m4 = below4 + d2;
    let l31 = (m4 - m[1] * m[3]) / d1;
    let l32 = (m[5] - m2 * m[3] - l31 * l21 * d1) / d2;
    let d3 = m[6] - m[3] * m[3] - l31 * l31 * d1 - l32 * l32 * d2;
    let d3 = d3.max(bias * least[2] as f32);
    let p1 = x - m[1];
    let p2 = x * x - m2 - l21 * p1;
    let p3 = x * x * x - m[3] - l31 * p1 - l32 * p2;
    // Taylor coefficients of p2 and p3 about x: first, then second over 2.
    let slope2 = 2.0 * x - l21;
    let slope3 = 3.0 * x * x - l31 - l32 * slope2;
    let bend3 = 3.0 * x - l32;
    let (w1, w2, w3) = (p1 / d1, p2 / d2, p3 / d3);
    let c0 = 1.0 + p1 * w1 + p2 * w2 + p3 * w3;
    let c1 = w1 + slope2 * w2 + slope3 * w3;
    let c2 = w2 + bend3 * w3;
    let roots = cubic(c1 / c0, c2 / c0, w3 / c0);
    let second = m2 - 2.0 * x * m[1] + x * x;
    let third = m[3] - 3.0 * x * m2 + 3.0 * x * x * m[1] - x * x * x;
    between([m[1] - x, second, third], roots, own)
}

/// Real roots of c0 s^2 + c1 s + c2, c0 > 0, the larger magnitude first.
fn quadratic(c0: f32, c1: f32, c2: f32) -> [f32; 2] {
    let root = (0.25 * c1 * c1 - c0 * c2).max(0.0).sqrt();
    let sum = if c1 < 0.0 { 0.5 * c1 - root } else { 0.5 * c1 + root };
    if sum == 0.0 { [0.0, 0.0] } else { [-sum / c0, -c2 / sum] }
}

/// Real roots of s^3 + a s^2 + b s + c, by falling magnitude; there are three but for rounding.
fn cubic(a: f32, b: f32, c: f32) -> [f32; 3] {
    // Viète: t^3 + p t + q with s = t - a/3 has t = 2 r cos.
    let third = a / 3.0;
    let radius = (third * third - b / 3.0).max(0.0).sqrt();
    let half_q = third * third * third - 0.5 * third * b + 0.5 * c;
    let cube = radius * radius * radius;
    let cosine = if cube > 0.0 { (-half_q / cube).clamp(-1.0, 1.0) } else { 1.0 };
    let angle = cosine.acos() / 3.0;
    let roots = [0.0, 1.0, 2.0].map(|k: f32| 2.0 * radius * (angle + k * TAU / 3.0).cos() - third);
    // The largest is good to rounding; what is left over it is a quadratic with good coefficients.
    let far = |x: f32, y: f32| if x.abs() < y.abs() { y } else { x };
    let largest = polished(roots.into_iter().fold(0.0, far), a, b, c);
    if largest == 0.0 {
        return [0.0; 3];
    }
    let c_left = -c / largest;
    let [second, least] = quadratic(1.0, (c_left - b) / largest, c_left);
    [largest, polished(second, a, b, c), polished(least, a, b, c)]
}

/// One step of Newton's method where it is a small one.
fn polished(s: f32, a: f32, b: f32, c: f32) -> f32 {
    let value = ((s + a) * s + b) * s + c;
    let slope = (3.0 * s + 2.0 * a) * s + b;
    let step = value / slope;
    if step.abs() < 0.1 * s.abs() { s - step } else { s }
}

/// The mean of the function that is `own` at 0, 1 at points 1/s < 0 and 0 at points 1/s > 0, from
/// the moments of y - x: of the polynomial through them, by divided differences from the nearest
/// point to the farthest.
fn between(moments: [f32; 3], roots: [f32; 3], own: f32) -> f32 {
    let step = |s: f32| if s < 0.0 { 1.0 } else { 0.0 };
    let [s1, s2, s3] = roots;
    let (f1, f2, f3) = (step(s1), step(s2), step(s3));
    // (f_i - f_j) / (y_i - y_j) = (f_i - f_j) s_i s_j / (s_j - s_i).
    let divided = |fi: f32, fj: f32, si: f32, sj: f32| {
        if si == sj { 0.0 } else { (fi - fj) * (si * sj) / (sj - si) }
    };
    let f01 = (f1 - own) * s1;
    let f12 = divided(f2, f1, s2, s1);
    let f012 = (f12 - f01) * s2;
    let f23 = divided(f3, f2, s3, s2);
    let f123 = divided(f23, f12, s3, s1);
    let f0123 = (f123 - f012) * s3;
    // own + f01 y + f012 y (y - y1) + f0123 y (y - y1)(y - y2)
    // A point too far for its place to matter must not overflow.
    let over = |s: f32| if s.abs() < 1e-15 { 0.0 } else { 1.0 / s };
    let (y1, y2) = (over(s1), over(s2));
    let [e1, e2, e3] = moments;
    own + f01 * e1 + f012 * (e2 - y1 * e1) + f0123 * (e3 - (y1 + y2) * e2 + y1 * y2 * e1)
}
