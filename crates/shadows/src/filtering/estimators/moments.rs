//! Based on: Christoph Peters and Reinhard Klein, "Moment shadow mapping", I3D 2015, algorithm 3
//! (Hamburger four-moment problem); Christoph Peters, Cedrick Muenstermann, Nico Wetzstein,
//! Reinhard Klein, "Improved moment shadow maps for translucent occluders, soft shadows and
//! single scattering", JCGT 6(1), 2017 (depth in -1..=1, 16-bit quantisation, bias targets).
//!
//! Deviations: where rounding leaves the Hankel matrix singular the bound falls back to
//! Chebyshev's, which needs two of the four moments; receivers beyond the far plane are dark and
//! receivers before the near plane lit; the shadow is not divided by 0.98, as the authors' code
//! does against light leaking, so that the result stays a bound.
//!
//! The quantisation of the 2015 paper is for depths in 0..=1; the one used here belongs to
//! -1..=1, where the moments are better conditioned. Its rows, as functions of one depth, are
//! Chebyshev-like polynomials that fill 0..=1 exactly.
//!
//! An unoccluded slope is dimmed by a wide window. There the receiver is the mean of its window,
//! where Chebyshev's bound, both CDFs and ESM are 1 but a share of the depths is nearer; the
//! sharper bound of four moments sees part of it. For depths symmetric about the receiver it is
//! `1 - b2^2 / (2 b4)` in central moments: 13/18 for a slope along one axis of the map (weights
//! 5/18, 8/18, 5/18 of Gauss's rule of three points), 19/24 along both. The bias lights windows
//! whose depths span little: it reaches 1 where `bias * target` is well above `b4`.

use super::{Real, chebyshev};

/// The first four powers of `2 z - 1`.
#[inline]
pub fn pack<R: Real>(z: R) -> [R; 4] {
    let d = z + z - R::of(1.0);
    let square = d * d;
    [d, square, square * d, square * square]
}

/// Moments to their 16-bit representation in 0..=1:
/// `(3/2 b1 - 2 b3 + 1/2, 4 b2 - 4 b4, sqrt(3)/2 b1 - 2 sqrt(3)/9 b3 + 1/2, (b2 + b4) / 2)`.
#[inline]
pub fn to_stored<R: Real>([b1, b2, b3, b4]: [R; 4]) -> [R; 4] {
    let root3 = R::of(3.0f64.sqrt());
    let half = R::of(0.5);
    [
        R::of(1.5) * b1 - R::of(2.0) * b3 + half,
        R::of(4.0) * (b2 - b4),
        root3 * (half * b1 - R::of(2.0 / 9.0) * b3) + half,
        half * (b2 + b4),
    ]
}

/// The inverse of [`to_stored`].
#[inline]
pub fn from_stored<R: Real>([s1, s2, s3, s4]: [R; 4]) -> [R; 4] {
    let odd = s1 - R::of(0.5);
    let odd3 = R::of(3.0f64.sqrt()) * (s3 - R::of(0.5));
    [
        odd3 - odd * R::of(1.0 / 3.0),
        s4 + R::of(0.125) * s2,
        R::of(0.75) * (odd3 - odd),
        s4 - R::of(0.125) * s2,
    ]
}

/// Even moments that biased ones are moved towards (the odd ones are 0): 0.375 for 32-bit
/// floats, 0.628 for 16-bit storage.
#[inline]
pub fn bias_target(sixteen_bit: bool) -> f64 {
    if sixteen_bit { 0.628 } else { 0.375 }
}

/// Sharp upper bound of the share of the window that is not nearer than `z`, from the first four
/// moments of `2 z - 1`, moved by `bias` (0..1) towards (0, `target`, 0, `target`).
#[inline]
pub fn visibility<R: Real>(moments: [R; 4], z: R, bias: R, target: R) -> R {
    let (zero, one) = (R::of(0.0), R::of(1.0));
    if z > one {
        return zero;
    }
    if z < zero {
        return one;
    }
    let keep = one - bias;
    let [b1, b2, b3, b4] = moments;
    let (b1, b3) = (b1 * keep, b3 * keep);
    let (b2, b4) = (b2 * keep + bias * target, b4 * keep + bias * target);
    let d = z + z - one;
    let shadow = hamburger(b1, b2, b3, b4, d);
    match shadow {
        Some(shadow) => one - shadow.at_least(zero).at_most(one),
        None => chebyshev::visibility(b1, b2, d, zero),
    }
}

/// Smallest share of depths below `d` that any distribution with these moments has; `None` where
/// the Hankel matrix is not positive definite in this precision.
#[inline]
fn hamburger<R: Real>(b1: R, b2: R, b3: R, b4: R, d: R) -> Option<R> {
    let zero = R::of(0.0);
    // LDL^T of the Hankel matrix [[1, b1, b2], [b1, b2, b3], [b2, b3, b4]].
    let d11 = b2 - b1 * b1;
    let l21_d11 = b3 - b1 * b2;
    let d22_d11 = (b4 - b2 * b2) * d11 - l21_d11 * l21_d11;
    if !(d11 > zero && d22_d11 > zero) {
        return None;
    }
    let l21 = l21_d11 / d11;
    let d22 = d22_d11 / d11;
    // Solves the Hankel matrix times c = (1, d, d^2).
    let y1 = d - b1;
    let y2 = d * d - b2 - l21 * y1;
    let c2 = y2 / d22;
    let c1 = y1 / d11 - l21 * c2;
    let c0 = R::of(1.0) - c1 * b1 - c2 * b2;
    // The other two depths of the distribution are the roots of c2 x^2 + c1 x + c0.
    let p = c1 / c2;
    let q = c0 / c2;
    let half_p = R::of(0.5) * p;
    let root = (half_p * half_p - q).at_least(zero).sqrt();
    let (low, high) = (-half_p - root, -half_p + root);
    let shadow = if d <= low {
        zero
    } else if d <= high {
        (d * high - b1 * (d + high) + b2) / ((high - low) * (d - low))
    } else {
        R::of(1.0) - (low * high - b1 * (low + high) + b2) / ((d - low) * (d - high))
    };
    shadow.is_finite().then_some(shadow)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean_moments(shares: &[(f64, f64)]) -> [f64; 4] {
        let mut sum = [0.0; 4];
        for &(share, z) in shares {
            for (sum, power) in sum.iter_mut().zip(pack(z)) {
                *sum += share * power;
            }
        }
        sum
    }

    #[test]
    fn stored_moments_fill_the_unit_range() {
        let (mut low, mut high) = ([1.0f64; 4], [0.0f64; 4]);
        for i in 0..=10_000 {
            let stored = to_stored(pack(f64::from(i) / 10_000.0));
            for c in 0..4 {
                low[c] = low[c].min(stored[c]);
                high[c] = high[c].max(stored[c]);
            }
        }
        for c in 0..4 {
            assert!((-1e-12..1e-6).contains(&low[c]), "{low:?}");
            assert!((1.0 - 1e-6..1.0 + 1e-12).contains(&high[c]), "{high:?}");
        }
    }

    #[test]
    fn inverse_quantisation_inverts() {
        // Four unit vectors and the offset show the whole affine map.
        let mut basis = vec![[0.0; 4]];
        for c in 0..4 {
            let mut unit = [0.0; 4];
            unit[c] = 1.0;
            basis.push(unit);
        }
        for b in basis {
            for (there, back) in b.iter().zip(from_stored(to_stored(b))) {
                assert!((there - back).abs() < 1e-14);
            }
            for (there, back) in b.iter().zip(to_stored(from_stored(b))) {
                assert!((there - back).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn three_depths_are_exact_at_each_of_them() {
        // Four moments fix a distribution of three depths when one of them is the receiver's.
        let m = mean_moments(&[(0.3, 0.2), (0.5, 0.5), (0.2, 0.9)]);
        for (z, visible) in [(0.2, 1.0), (0.5, 0.7), (0.9, 0.2)] {
            let v = visibility(m, z, 0.0, 0.375);
            assert!((v - visible).abs() < 1e-6, "{z}: {v}");
        }
    }

    #[test]
    fn an_unoccluded_slope_is_dimmed_by_what_gauss_three_points_leave() {
        let n = 4095;
        let at = |i: u32| 0.3 + 0.2 * (f64::from(i) + 0.5) / f64::from(n);
        let along_one: Vec<_> = (0..n).map(|i| (1.0 / f64::from(n), at(i))).collect();
        // The sum of two equal slopes: a triangle of weights.
        let weight = |i: u32| f64::from((i + 1).min(n - i)) / f64::from((n / 2 + 1).pow(2));
        let along_both: Vec<_> = (0..n).map(|i| (weight(i), at(i))).collect();
        for (shares, expected) in [(along_one, 13.0 / 18.0), (along_both, 19.0 / 24.0)] {
            assert!((shares.iter().map(|s| s.0).sum::<f64>() - 1.0).abs() < 1e-12);
            let m = mean_moments(&shares);
            let v = visibility(m, 0.4, 0.0, 0.375);
            assert!((v - expected).abs() < 1e-4, "{v} {expected}");
            // One standard deviation nearer to the light the bound is 1, just before it is not.
            let mean = 0.4;
            let sigma = 0.5 * (m[1] - m[0] * m[0]).sqrt();
            assert!(visibility(m, mean - 1.001 * sigma, 0.0, 0.375) > 1.0 - 1e-9);
            assert!(visibility(m, mean - 0.8 * sigma, 0.0, 0.375) < 1.0 - 1e-3);
            assert_eq!(chebyshev::visibility(m[0], m[1], 2.0 * mean - 1.0 - 1e-9, 0.0), 1.0);
        }
    }

    #[test]
    fn one_and_two_depths_fall_back_to_an_exact_bound() {
        let one = mean_moments(&[(1.0, 0.5)]);
        assert_eq!(visibility(one, 0.5, 0.0, 0.375), 1.0);
        assert_eq!(visibility(one, 0.6, 0.0, 0.375), 0.0);
        let two = mean_moments(&[(0.25, 0.25), (0.75, 0.75)]);
        assert!((visibility(two, 0.75, 0.0, 0.375) - 0.75).abs() < 1e-6);
    }

    #[test]
    fn bounds_every_sample_set_from_above() {
        let shares = [(0.1, 0.05), (0.2, 0.3), (0.3, 0.35), (0.25, 0.7), (0.15, 0.95)];
        let m = mean_moments(&shares);
        for i in 0..=100 {
            let z = f64::from(i) / 100.0;
            let exact: f64 = shares.iter().filter(|s| s.1 >= z).map(|s| s.0).sum();
            let v = visibility(m, z, 0.0, 0.375);
            assert!(v >= exact - 1e-9, "{z}: {v} < {exact}");
            assert!(v <= chebyshev::visibility(m[0], m[1], 2.0 * z - 1.0, 0.0) + 1e-9);
        }
    }
}
