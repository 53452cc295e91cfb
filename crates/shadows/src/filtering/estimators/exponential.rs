//! Based on: Thomas Annen, Tom Mertens, Hans-Peter Seidel, Eddy Flerackers, Jan Kautz,
//! "Exponential shadow maps", Graphics Interface 2008, section 3; Marco Salvi, "Rendering
//! filtered shadows with exponential shadow maps", ShaderX6, 2008 (filtering in log space).
//!
//! Deviations: the log-space map stores `ln(E[exp(c z)]) / c`, a depth in 0..=1, so that 16-bit
//! formats can hold it for every exponent.

use super::Real;

/// `exp(c z)`.
#[inline]
pub fn warp<R: Real>(z: R, c: R) -> R {
    (c * z).exp()
}

/// `exp(-c z) E[exp(c z_o)]`, at most 1, from the filtered `mean_warped = E[exp(c z_o)]`.
///
/// The factor is applied as two square roots: `exp(-88)` alone is subnormal in f32, and adapters
/// may flush it to 0.
#[inline]
pub fn visibility<R: Real>(mean_warped: R, z: R, c: R) -> R {
    let root = (R::of(-0.5) * c * z).exp();
    (mean_warped * root * root).at_most(R::of(1.0))
}

/// The same from the soft maximum `ln(E[exp(c z_o)]) / c`.
#[inline]
pub fn visibility_log<R: Real>(soft_max: R, z: R, c: R) -> R {
    (c * (soft_max - z)).at_most(R::of(0.0)).exp()
}

/// `ln(sum_i w_i exp(c z_i)) / c` for weights that sum to 1: the weighted mean of a log-space
/// map, shifted by its largest value so that nothing overflows.
#[inline]
pub fn log_mean<R: Real>(values: impl Iterator<Item = (R, R)> + Clone, c: R) -> R {
    let mut max = R::of(f64::NEG_INFINITY);
    for (_, z) in values.clone() {
        max = max.at_least(z);
    }
    let mut sum = R::of(0.0);
    for (weight, z) in values {
        sum = sum + weight * (c * (z - max)).exp();
    }
    // The largest value may carry weight 0 in a bilinear lookup; everything else may underflow.
    if sum > R::of(0.0) { max + sum.ln() / c } else { max }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_occluder_by_hand() {
        // exp(-c dz) with c dz = 1.
        let e = (-1.0f64).exp();
        assert!((visibility(warp(0.4, 10.0), 0.5, 10.0) - e).abs() < 1e-12);
        assert!((visibility_log(0.4, 0.5, 10.0) - e).abs() < 1e-12);
        assert_eq!(visibility_log(0.5, 0.4, 10.0), 1.0);
    }

    #[test]
    fn extremes_stay_finite_in_f32() {
        let c = 88.0f32;
        assert!(warp(1.0, c).is_finite());
        assert_eq!(visibility(warp(1.0, c), 1.0 - 1e-3, c), 1.0);
        assert!((visibility(warp(1.0, c), 1.0, c) - 1.0).abs() < 2e-5);
        assert_eq!(visibility(1.0, f32::MAX, c), 0.0);
        assert_eq!(visibility(1.0, -f32::MAX, c), 1.0);
        assert_eq!(visibility_log(1.0f32, -f32::MAX, 700.0), 1.0);
    }

    #[test]
    fn log_mean_is_the_log_of_the_mean() {
        let values = [(0.25, 0.1), (0.75, 0.4)];
        let c = 5.0f64;
        let plain = (0.25 * (c * 0.1).exp() + 0.75 * (c * 0.4).exp()).ln() / c;
        assert!((log_mean(values.into_iter(), c) - plain).abs() < 1e-12);
        // Where the plain sum would overflow f64 it is the maximum plus ln(3/4) / c.
        let c = 5000.0;
        assert!((log_mean(values.into_iter(), c) - (0.4 + 0.75f64.ln() / c)).abs() < 1e-12);
    }
}
