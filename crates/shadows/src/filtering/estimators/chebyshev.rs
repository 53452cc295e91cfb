//! Based on: William Donnelly and Andrew Lauritzen, "Variance shadow maps", I3D 2006, section 3,
//! eq. 5 (one-sided Chebyshev inequality); the linear bleed reduction of Andrew Lauritzen,
//! "Summed-area variance shadow maps", GPU Gems 3, 2007, section 8.4.3; Jesus Gumbau, "Techniques
//! for improving the visualization of natural scenes", 2011, eqs. 2.1 and 2.2.
//!
//! Deviations: a window without variance is a step function rather than 0/0.

use super::Real;

/// Upper bound of the share of the window that is not nearer than `z`, from `mean = E[z]` and
/// `mean_square = E[z^2]`. Exact for two depths when `z` is the farther one.
///
/// The variance is raised to `min_variance` (>= 0, squared depth).
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
    variance / (variance + distance * distance)
}

/// Cuts visibilities up to `bleed` (0..1) to 0 and stretches the rest over 0..=1.
#[inline]
pub fn reduce_bleeding<R: Real>(visibility: R, bleed: R) -> R {
    ((visibility - bleed) / (R::of(1.0) - bleed)).at_least(R::of(0.0))
}

/// The bound with 0 beyond the window's largest depth, where it is known to be 0.
#[inline]
pub fn visibility_max<R: Real>(mean: R, mean_square: R, max: R, z: R, min_variance: R) -> R {
    if z > max {
        return R::of(0.0);
    }
    visibility(mean, mean_square, z, min_variance)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_depths_are_exact_at_the_farther_one() {
        // Share 1/4 at depth 0, 3/4 at depth 1: M1 = M2 = 3/4, variance 3/16, distance 1/4.
        assert!((visibility(0.75, 0.75, 1.0, 0.0) - 0.75f64).abs() < 1e-15);
        assert!((visibility(0.75, 0.75, 1.0, 0.0) - 0.75f32).abs() < 1e-6);
    }

    #[test]
    fn no_variance_is_a_step() {
        assert_eq!(visibility(0.5, 0.25, 0.5, 0.0), 1.0);
        assert_eq!(visibility(0.5, 0.25, 0.6, 0.0), 0.0);
        // The squared distance underflows here.
        assert_eq!(visibility(0.0f32, 0.0, 1e-30, 0.0), 0.0);
        // Rounding that makes the variance negative.
        assert_eq!(visibility(0.9f32, 0.8099, 0.95, 0.0), 0.0);
        assert_eq!(visibility(0.5f32, 0.25, f32::MAX, 1e-5), 0.0);
    }

    #[test]
    fn minimum_variance_softens_by_hand() {
        // variance 0.01, distance 0.1: 0.01 / 0.02.
        assert!((visibility(0.5, 0.25, 0.6, 0.01) - 0.5f64).abs() < 1e-12);
    }

    #[test]
    fn bleed_reduction_by_hand() {
        assert_eq!(reduce_bleeding(0.1, 0.2), 0.0);
        assert!((reduce_bleeding(0.6, 0.2) - 0.5f64).abs() < 1e-15);
        assert_eq!(reduce_bleeding(1.0, 0.2), 1.0);
    }

    #[test]
    fn beyond_the_maximum_is_dark() {
        assert_eq!(visibility_max(0.5, 0.5, 0.9, 0.91, 0.1), 0.0);
        assert!(visibility_max(0.5, 0.5, 0.9, 0.9, 0.1) > 0.0);
    }
}
