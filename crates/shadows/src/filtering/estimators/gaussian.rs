//! Based on: Jesus Gumbau, "Techniques for improving the visualization of natural scenes", 2011,
//! section 7.2.1, eqs. 7.2 to 7.4.
//!
//! Deviations: a minimum variance as in variance shadow maps; a window without variance is a step
//! function rather than a division by 0.

use super::{Real, erf};

/// Estimate (not a bound) of the share of the window that is not nearer than `z`, relative to
/// that at the mean: `1 - erf((z - mean) / (sigma sqrt(2)))` beyond the mean, else 1.
#[inline]
pub fn visibility<R: Real>(mean: R, mean_square: R, z: R, min_variance: R) -> R {
    let distance = z - mean;
    if distance <= R::of(0.0) {
        return R::of(1.0);
    }
    let variance = (mean_square - mean * mean).at_least(min_variance);
    if variance <= R::of(0.0) {
        return R::of(0.0);
    }
    erf::erfc_positive(distance / (R::of(2.0) * variance).sqrt())
}

/// Equation 7.4 clamped to 0..=1 instead of guarded by `z > mean`, with the error function as
/// printed: darkens receivers in front of the mean. Kept as a deliberate fault.
#[inline]
pub fn visibility_printed<R: Real>(mean: R, mean_square: R, z: R, min_variance: R) -> R {
    let variance = (mean_square - mean * mean).at_least(min_variance);
    if variance <= R::of(0.0) {
        return visibility(mean, mean_square, z, min_variance);
    }
    R::of(1.0) - erf::erf_printed((z - mean) / (R::of(2.0) * variance).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_standard_deviation() {
        // 1 - erf(1 / sqrt 2) = 0.31731 (two-sided tail beyond one sigma).
        let v: f64 = visibility(0.4, 0.17, 0.5, 0.0);
        assert!((v - 0.317_31).abs() < 4e-4, "{v}");
    }

    #[test]
    fn no_variance_is_a_step() {
        assert_eq!(visibility(0.5, 0.25, 0.5, 0.0), 1.0);
        assert_eq!(visibility(0.5, 0.25, 0.6, 0.0), 0.0);
        assert_eq!(visibility(0.0f32, 1e-44, 0.5, 0.0), 0.0);
    }

    #[test]
    fn printed_form_darkens_before_the_mean() {
        assert_eq!(visibility(0.5, 0.26, 0.4, 0.0), 1.0);
        assert!(visibility_printed(0.5, 0.26, 0.4, 0.0) < 0.5f64);
    }
}
