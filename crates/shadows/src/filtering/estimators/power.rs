//! Based on: Jesus Gumbau, "Techniques for improving the visualization of natural scenes", 2011,
//! section 7.2.2, eqs. 7.5 to 7.7.
//!
//! Deviations: eq. 7.7 through `exp_m1` and `ln_1p`, which keep their digits when the exponent is
//! very small or very large; the mean is clamped into the range; a range at the format's
//! resolution is a step at the maximum; a mean at the minimum leaves nothing beyond it.

use super::Real;

/// `beta` of the fitted distribution `F = t^beta`, eq. 7.6; infinite where `mean == max`.
#[inline]
pub fn exponent<R: Real>(min: R, max: R, mean: R) -> R {
    (mean - min) / (max - mean)
}

/// Estimate of the share of the window that is not nearer than `z`, relative to that at the
/// mean, from the window's minimum, maximum and mean.
///
/// A range up to `degenerate_range` (depth) counts as one depth.
#[inline]
pub fn visibility<R: Real>(min: R, max: R, mean: R, z: R, degenerate_range: R) -> R {
    let (zero, one) = (R::of(0.0), R::of(1.0));
    let mean = mean.at_least(min).at_most(max);
    if z <= mean {
        return one;
    }
    let range = max - min;
    if range <= degenerate_range {
        return if z > max { zero } else { one };
    }
    let beta = exponent(min, max, mean);
    if z >= max || beta <= zero {
        return zero;
    }
    let numerator = (beta * ln_share(z, min, max, range)).exp_m1();
    let denominator = (beta * ln_share(mean, min, max, range)).exp_m1();
    (numerator / denominator).at_most(one)
}

/// `ln((z - min) / range)`, from the nearer end so that neither end loses digits.
#[inline]
fn ln_share<R: Real>(z: R, min: R, max: R, range: R) -> R {
    let t = (z - min) / range;
    if t < R::of(0.5) { t.ln() } else { (-((max - z) / range)).ln_1p() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_distribution_by_hand() {
        // mean in the middle: beta = 1, v = (1 - t) / (1 - 1/2).
        assert_eq!(exponent(0.0, 1.0, 0.5), 1.0);
        assert!((visibility(0.0, 1.0, 0.5, 0.75, 0.0) - 0.5f64).abs() < 1e-15);
        assert!((visibility(0.2, 0.6, 0.4, 0.5, 0.0) - 0.5f32).abs() < 1e-6);
    }

    #[test]
    fn edges_of_the_fit() {
        // t >= 1 is dark, whatever the mean.
        assert_eq!(visibility(0.0, 1.0, 0.9, 1.0, 0.0), 0.0);
        // mean == min: dark for every t > 0.
        assert_eq!(visibility(0.2, 0.8, 0.2, 0.200_001, 0.0), 0.0);
        assert_eq!(visibility(0.2, 0.8, 0.2, 0.2, 0.0), 1.0);
        // mean == max, and a mean that rounding put outside.
        assert_eq!(visibility(0.2, 0.8, 0.8, 0.8, 0.0), 1.0);
        assert_eq!(visibility(0.2, 0.8, 0.800_001, 0.8, 0.0), 1.0);
        assert_eq!(visibility(0.2, 0.8, 0.8, 0.9, 0.0), 0.0);
        // One depth.
        assert_eq!(visibility(0.5, 0.5, 0.5, 0.5, 1e-6), 1.0);
        assert_eq!(visibility(0.5f32, 0.5, 0.5, 0.500_001, 1e-6), 0.0);
    }

    #[test]
    fn large_exponents_keep_the_denominator() {
        // mean = 1 - 1e-9: the denominator is expm1(beta ln(beta/(beta+1))) -> 1/e - 1.
        let (max, mean) = (1.0, 1.0 - 1e-9);
        let z = 1.0 - 0.5e-9;
        // beta ln(1 - 0.5e-9) -> -1/2.
        let expected = (1.0 - (-0.5f64).exp()) / (1.0 - (-1.0f64).exp());
        assert!((visibility(0.0, max, mean, z, 0.0) - expected).abs() < 1e-6);
    }
}
