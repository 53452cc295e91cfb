//! Moment-based transmittance: 4 or 6 power moments of the absorption along a ray.
//!
//! Based on: Cedrick Münstermann, Stefan Krumpen, Reinhard Klein, Christoph Peters, "Moment-based
//! order-independent transparency", Proc. ACM Comput. Graph. Interact. Tech. 1(1) (I3D), 2018, §3
//! (absorbance ω, its moments b_j = Σ ω z^j over depths in -1..=1, bounds of the absorbance in front
//! of a depth, interpolation between them) and the supplement (biases); Christoph Peters, Cedrick
//! Münstermann, Nico Wetzstein, Reinhard Klein, "Improved moment shadow maps for translucent
//! occluders, soft shadows and single scattering", JCGT 6(1), 2017.
//!
//! Among all distributions of b_0 with the moments b_1 .. b_m, the one with a point at the
//! receiver's depth x and least others puts the least before x and the most up to x (Markov,
//! Krein). What lies before x, plus a share of the point's own weight, is Ω(x). Both bounds rise
//! with x, so T is monotone; m/2 different depths are met exactly, but for the bias.
//!
//! The bias moves the moments, divided by b_0, towards those of a distribution that is far from
//! any degenerate one. It costs sharpness, and pays for rounding: in f32 a ray of few depths has a
//! singular matrix of moments, and without bias its inverse is noise.
//!
//! The other points: with y = x + 1/s, the polynomial whose roots they are has, in s, the leading
//! coefficient v(x)' B^-1 v(x) > 0. So no root is at infinity, points before x are the roots s < 0,
//! and far points, which have next to no weight, have s near 0.
//!
//! Deviations: `overestimation` is that of T (the authors' is that of the absorbance, 1 - ours);
//! depths are linear in the light's range, or between each ray's own bounds (`bounded`; two more
//! words), where T is exactly 1 up to the first fragment and e^-b_0 behind the last; halves store
//! moments as they are (the authors' transform suits integers: a half keeps its relative precision
//! near 0), rounded after each addition; where rounding leaves a matrix that no distribution has,
//! its even moments are raised to the nearest that one could have after the bias (without that,
//! halves need thirty times the bias).

use crate::{
    Format, Fragment, Moments,
    code::TexelCode,
    gather::{self, Place, WHOLE},
    layered::placement::Bounds,
};
use std::f32::consts::TAU;

/// Most moments, the zeroth included.
const MOST: usize = 7;

/// Bounds first where there are any, then b_0 .. b_m.
pub struct Code {
    /// Knobs.
    pub settings: Moments,
    /// Whether the opaque fragment stretches the bounds.
    pub opaque_in_bounds: bool,
}

/// Moments of the distribution that the bias moves towards, from the first on (Peters et al. 2017;
/// the supplement of Münstermann et al. 2018).
pub fn safe(moments: u32) -> &'static [f64] {
    if moments == 4 { &[0.0, 0.375, 0.0, 0.375] } else { &[0.0, 0.48, 0.0, 0.451, 0.0, 0.45] }
}

/// The bias that settings ask for. The authors' are 5e-7 and 5e-6 in f32 for 4 and 6 moments; ours
/// are stronger, because sums here are of many fragments at few depths. Through hair that costs
/// less than 1 % of the error; on rays of one to four depths it keeps f32 within 0.01 of f64.
pub fn bias(settings: &Moments) -> f64 {
    if settings.bias > 0.0 {
        return f64::from(settings.bias);
    }
    match (settings.format, settings.moments) {
        (Format::F16, _) => 1e-3,
        (_, 4) => 5e-5,
        _ => 1e-4,
    }
}

impl Code {
    fn header(&self) -> usize {
        if self.settings.bounded { 2 } else { 0 }
    }

    fn count(&self) -> usize {
        1 + if self.settings.moments == 4 { 4 } else { 6 }
    }

    fn transmittance(&self, words: &[f32], depth: f32) -> f32 {
        let bounds = match self.settings.bounded {
            true => Bounds { first: words[0], last: words[1] },
            false => WHOLE,
        };
        let b = &words[self.header()..self.header() + self.count()];
        match gather::place(bounds, depth) {
            _ if b[0] <= 0.0 => 1.0,
            Place::Front => 1.0,
            Place::Behind => (-b[0]).exp(),
            Place::Inside(share) => {
                let own = 1.0 - self.settings.overestimation;
                let bias = bias(&self.settings) as f32;
                (-b[0] * share_before(b, 2.0 * share - 1.0, bias, own)).exp()
            }
        }
    }
}

/// Share of the absorption before x, plus `own` of that at x, 0..=1.
fn share_before(b: &[f32], x: f32, bias: f32, own: f32) -> f32 {
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

/// Pivots of the safe distribution's matrix after the first, which is 1. A matrix of moments has
/// none below 0, so a biased one has none below `bias` times these: where rounding says otherwise
/// the even moment is raised until it has.
fn safe_pivots(moments: u32) -> &'static [f64] {
    if moments == 4 { &[0.375, 0.234_375] } else { &[0.48, 0.2206, 0.026_247_917] }
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

impl TexelCode for Code {
    fn words(&self) -> usize {
        self.header() + self.count()
    }

    fn encode(
        &self,
        _: usize,
        fragments: &[Fragment],
        opaque: Option<Fragment>,
        _: &mut Vec<Fragment>,
        words: &mut [f32],
    ) {
        let mut bounds = WHOLE;
        if self.settings.bounded {
            bounds = Bounds::of(fragments, opaque, self.opaque_in_bounds);
            words[..2].copy_from_slice(&[bounds.first, bounds.last]);
        }
        let b = &mut words[self.header()..];
        b.fill(0.0);
        for f in gather::everything(fragments, opaque) {
            let z = 2.0 * gather::share(bounds, f.depth) - 1.0;
            let mut term = f64::from(f.omega);
            for sum in b.iter_mut() {
                *sum = gather::stored(self.settings.format, f64::from(*sum) + term);
                term *= z;
            }
        }
    }

    fn decode(&self, _: usize, words: &[f32], depth: f32) -> f32 {
        self.transmittance(words, depth)
    }

    /// Over the whole range moments are averaged, as of one ray of all their fragments.
    fn decode_mean(&self, _: (usize, &[f32]), taps: &[(usize, &[f32])], depth: f32) -> f32 {
        let n = taps.len().max(1) as f32;
        if self.settings.bounded {
            let decoded = taps.iter().map(|(_, words)| self.transmittance(words, depth));
            return decoded.sum::<f32>() / n;
        }
        let mut mean = [0.0; MOST];
        for (_, words) in taps {
            mean.iter_mut().zip(*words).for_each(|(sum, word)| *sum += word / n);
        }
        self.transmittance(&mean, depth)
    }

    fn bytes_per_texel(&self) -> u64 {
        4 * self.header() as u64 + self.count() as u64 * gather::bytes(self.settings.format)
    }

    /// One for all moments; one before it for both bounds.
    fn geometry_passes(&self) -> u64 {
        1 + u64::from(self.settings.bounded)
    }
}

/// T(d) in f64. Halves are rounded after each addition, 32-bit sums are not. The processor's form
/// follows it to [`port_bound`].
pub fn reference(
    settings: &Moments,
    fragments: &[Fragment],
    opaque: Option<Fragment>,
    opaque_in_bounds: bool,
    depth: f32,
) -> f64 {
    let bounds = match settings.bounded {
        true => Bounds::of(fragments, opaque, opaque_in_bounds),
        false => WHOLE,
    };
    let b = reference_moments(settings, fragments, opaque, bounds);
    reference_decode(settings, &b, bounds, depth)
}

/// T(d) of moments averaged over several texels' fragments, over the light's whole range.
pub fn reference_mean<'a>(
    settings: &Moments,
    texels: impl Iterator<Item = (&'a [Fragment], Option<Fragment>)>,
    depth: f32,
) -> f64 {
    let mut sums = vec![0.0; settings.moments as usize + 1];
    let mut n = 0.0;
    for (fragments, opaque) in texels {
        let b = reference_moments(settings, fragments, opaque, WHOLE);
        sums.iter_mut().zip(b).for_each(|(sum, b)| *sum += b);
        n += 1.0;
    }
    sums.iter_mut().for_each(|sum| *sum /= f64::max(n, 1.0));
    reference_decode(settings, &sums, WHOLE, depth)
}

fn reference_moments(
    settings: &Moments,
    fragments: &[Fragment],
    opaque: Option<Fragment>,
    bounds: Bounds,
) -> Vec<f64> {
    let moment = |power: i32| {
        gather::everything(fragments, opaque).fold(0.0, |sum, f| {
            let z = 2.0 * gather::share(bounds, f.depth) - 1.0;
            gather::stored_exactly(settings.format, sum + f64::from(f.omega) * z.powi(power))
        })
    };
    (0..=settings.moments as i32).map(moment).collect()
}

fn reference_decode(settings: &Moments, b: &[f64], bounds: Bounds, depth: f32) -> f64 {
    let place = gather::place(bounds, depth);
    if b[0] <= 0.0 || place == Place::Front {
        return 1.0;
    }
    if place == Place::Behind {
        return (-b[0]).exp();
    }
    let x = 2.0 * gather::share(bounds, depth) - 1.0;
    let bias = bias(settings);
    let mut m: Vec<f64> = b.iter().map(|moment| moment / b[0]).collect();
    for (moment, safe) in m[1..].iter_mut().zip(safe(settings.moments)) {
        *moment = (1.0 - bias) * *moment + bias * safe;
    }
    raise(&mut m, settings.moments, bias);
    let size = settings.moments as usize / 2 + 1;
    let powers = |y: f64| -> Vec<f64> { (0..size as i32).map(|j| y.powi(j)).collect() };
    let kernel = |y: f64| solved(&m, powers(y));
    // Weight of a point: the largest that any distribution with these moments can have there.
    let weight = |y: f64| 1.0 / kernel(y).iter().zip(powers(y)).map(|(k, p)| k * p).sum::<f64>();
    let points = real_roots(&kernel(x));
    let before: f64 = points.iter().filter(|&&y| y < x).map(|&y| weight(y)).sum();
    let own = 1.0 - f64::from(settings.overestimation);
    (-b[0] * (before + own * weight(x)).clamp(0.0, 1.0)).exp()
}

/// Raises even moments until no pivot of the matrix m_(i + j) is less than it can be: the k-th is
/// m_2k less what the smaller matrix leaves of it.
fn raise(m: &mut [f64], moments: u32, bias: f64) {
    for (k, safe) in (1..).zip(safe_pivots(moments)) {
        let beside = m[k..2 * k].to_vec();
        let explained = solved(m, beside.clone());
        let below: f64 = explained.iter().zip(&beside).map(|(a, b)| a * b).sum();
        m[2 * k] = m[2 * k].max(below + bias * safe);
    }
}

/// The matrix m_(i + j) divided into the right-hand side, by elimination with pivots.
fn solved(m: &[f64], mut right: Vec<f64>) -> Vec<f64> {
    let n = right.len();
    let mut rows: Vec<Vec<f64>> = (0..n).map(|i| m[i..i + n].to_vec()).collect();
    for k in 0..n {
        let larger = |&i: &usize, &j: &usize| rows[i][k].abs().total_cmp(&rows[j][k].abs());
        let pivot = (k..n).max_by(larger).unwrap_or(k);
        rows.swap(k, pivot);
        right.swap(k, pivot);
        let row = rows[k].clone();
        for i in (0..n).filter(|&i| i != k) {
            let factor = rows[i][k] / row[k];
            rows[i].iter_mut().zip(&row).for_each(|(a, b)| *a -= factor * b);
            right[i] -= factor * right[k];
        }
    }
    (0..n).map(|k| right[k] / rows[k][k]).collect()
}

/// Simple real roots, found by halving between those of the derivative. Points farther than 1e8
/// have no weight.
fn real_roots(coefficients: &[f64]) -> Vec<f64> {
    if coefficients.len() < 2 {
        return Vec::new();
    }
    let value = |x: f64| coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c);
    let derivative: Vec<f64> =
        coefficients.iter().enumerate().skip(1).map(|(power, c)| power as f64 * c).collect();
    let mut ends = vec![-1e8];
    ends.extend(real_roots(&derivative));
    ends.push(1e8);
    let mut roots = Vec::new();
    for pair in ends.windows(2) {
        let (mut low, mut high) = (pair[0], pair[1]);
        let rises = value(low) < 0.0;
        if rises == (value(high) < 0.0) {
            continue;
        }
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if (value(middle) < 0.0) == rises { low = middle } else { high = middle }
        }
        roots.push(0.5 * (low + high));
    }
    roots
}

/// Most that the processor's T may differ from the reference's. Sums carry the rounding of one
/// addition a fragment, and the inverse of the matrix of moments magnifies it by up to 1 / bias,
/// more for the larger matrix. Halves are rounded alike in both.
pub fn port_bound(settings: &Moments, fragments: &[Fragment], opaque: Option<Fragment>) -> f64 {
    let count = gather::everything(fragments, opaque).count() as f64;
    let size = if settings.moments == 4 { 1.0 } else { 4.0 };
    let sums = match settings.format {
        Format::F16 => size * 2f64.powi(-21),
        _ => size * 2f64.powi(-24) * (8.0 + count.sqrt()),
    };
    (1e-6 + sums / bias(settings)).min(1.0)
}
