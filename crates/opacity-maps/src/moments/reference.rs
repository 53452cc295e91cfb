//! Transmittance from moments in f64, another way: the matrix is inverted by elimination, the points
//! are found by halving, and each weighs as much as any distribution with these moments can there.

use super::{bias, safe, safe_pivots};
use crate::{
    Fragment, Moments,
    gather::{self, Place, WHOLE},
    layered::placement::Bounds,
};

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
