//! Bias told apart from variance.
//!
//! Based on: the tests of Mitsuba's renderers: a z-test of every pixel's mean against a known mean
//! with a known variance, with Sidak's correction for the number of pixels.
//! Deviations: variances are exact where a sampler's probabilities can be enumerated, and rounding
//! is allowed for by a share of the known mean, so that pixels without variance are held to that.

use glam::{DVec3, Vec3};
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};

/// Running mean and variance of images of one size, by pixel and channel (Welford).
#[derive(Clone, Debug, Default)]
pub struct Moments {
    images: u64,
    mean: Vec<DVec3>,
    /// Sums of squared differences from the mean.
    squares: Vec<DVec3>,
}

/// What a z-test over many means found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZTest {
    /// Means that were tested.
    pub tests: usize,
    /// Those whose z is beyond the limit, or not a number.
    pub failures: usize,
    /// The greatest |z|.
    pub worst: f64,
    /// The greatest |z| allowed.
    pub limit: f64,
}

impl Moments {
    /// Adds an image.
    pub fn push(&mut self, image: &[Vec3]) {
        self.mean.resize(image.len(), DVec3::ZERO);
        self.squares.resize(image.len(), DVec3::ZERO);
        self.images += 1;
        let share = 1.0 / self.images as f64;
        for ((value, mean), squares) in image.iter().zip(&mut self.mean).zip(&mut self.squares) {
            let before = value.as_dvec3() - *mean;
            *mean += before * share;
            *squares += before * (value.as_dvec3() - *mean);
        }
    }

    /// Images so far.
    pub fn images(&self) -> u64 {
        self.images
    }

    /// Mean of each pixel.
    pub fn mean(&self) -> &[DVec3] {
        &self.mean
    }

    /// Variance of one image at each pixel, estimated from all; 0 of fewer than two.
    pub fn variance(&self) -> Vec<DVec3> {
        let over = (self.images.max(2) - 1) as f64;
        self.squares.iter().map(|squares| *squares / over).collect()
    }

    /// Tests the means against known ones. `variance` is that of one image, exact or estimated;
    /// `alpha` the chance, in 0..1, that any pixel of an unbiased sampler fails; `rounding` the share
    /// of a known mean that arithmetic alone may be off by.
    pub fn z_test(&self, known: &[DVec3], variance: &[DVec3], alpha: f64, rounding: f64) -> ZTest {
        let mut scores = Vec::with_capacity(3 * known.len());
        let same = self.mean.len() == known.len() && known.len() == variance.len();
        for ((mean, known), variance) in self.mean.iter().zip(known).zip(variance) {
            for channel in 0..3 {
                let off = (mean[channel] - known[channel]).abs() - rounding * known[channel].abs();
                // Written so that what is not a number stays so.
                let off = if off <= 0.0 { 0.0 } else { off };
                let deviation = (variance[channel] / self.images as f64).sqrt();
                scores.push(if off == 0.0 { 0.0 } else { off / deviation });
            }
        }
        let limit = sidak(alpha, scores.len());
        let failed = scores.iter().filter(|z| z.is_nan() || **z > limit);
        let failures = if same { failed.count() } else { scores.len().max(1) };
        let worst = scores.iter().copied().fold(0.0, f64::max);
        ZTest { tests: scores.len(), failures, worst, limit }
    }
}

impl ZTest {
    /// Whether anything was tested, and nothing failed.
    pub fn passes(&self) -> bool {
        self.tests > 0 && self.failures == 0
    }
}

/// The |z| that any of `tests` normal deviates exceeds with chance `alpha`.
fn sidak(alpha: f64, tests: usize) -> f64 {
    // 1 - (1 - alpha)^(1 / tests), without the rounding of numbers near 1.
    let each = -f64::exp_m1(f64::ln_1p(-alpha) / tests.max(1) as f64);
    -Normal::standard().inverse_cdf(0.5 * each)
}

/// Chance of counts as far from what was expected of `probabilities` or farther (Pearson's test),
/// in 0..=1. Cells of fewer than 5 expected are taken together; anything counted where nothing can
/// be makes it 0.
pub fn chi_squared(counts: &[u64], probabilities: &[f64]) -> f64 {
    let total: u64 = counts.iter().sum();
    let (mut statistic, mut cells) = (0.0, 0u32);
    let (mut rare, mut rare_expected) = (0u64, 0.0);
    let mut add = |count: u64, expected: f64| {
        statistic += (count as f64 - expected).powi(2) / expected;
        cells += 1;
    };
    for (&count, &probability) in counts.iter().zip(probabilities) {
        let expected = probability * total as f64;
        if expected >= 5.0 {
            add(count, expected);
        } else if probability > 0.0 {
            rare += count;
            rare_expected += expected;
        } else if count > 0 {
            return 0.0;
        }
    }
    if rare_expected > 0.0 {
        add(rare, rare_expected);
    }
    // One cell is always as expected.
    match ChiSquared::new(f64::from(cells.saturating_sub(1))) {
        Ok(distribution) => distribution.sf(statistic),
        Err(_) => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::Random;

    /// Images of 16 pixels whose values are 0 or 2 with equal chance, and `shift` more.
    fn coins(images: u32, shift: f32) -> Moments {
        let mut moments = Moments::default();
        for seed in 0..images {
            let one = |pixel| {
                let mut random = Random::new(seed, 0, pixel);
                Vec3::from_array(std::array::from_fn(|_| {
                    shift + if random.unit() < 0.5 { 0.0 } else { 2.0 }
                }))
            };
            moments.push(&(0..16).map(one).collect::<Vec<_>>());
        }
        moments
    }

    #[test]
    fn moments_are_those_of_the_definition() {
        let mut moments = Moments::default();
        for value in [1.0, 2.0, 6.0] {
            moments.push(&[Vec3::splat(value)]);
        }
        assert_eq!(moments.images(), 3);
        assert!((moments.mean()[0].x - 3.0).abs() < 1e-15);
        assert!((moments.variance()[0].y - 7.0).abs() < 1e-14);
    }

    #[test]
    fn a_shifted_mean_fails_and_a_true_one_does_not() {
        let (known, variance) = ([DVec3::ONE; 16], [DVec3::ONE; 16]);
        let fair = coins(4000, 0.0).z_test(&known, &variance, 0.01, 0.0);
        assert!(fair.passes() && fair.tests == 48, "{fair:?}");
        // 0.1 is 6.3 deviations of the mean.
        let shifted = coins(4000, 0.1).z_test(&known, &variance, 0.01, 0.0);
        assert!(!shifted.passes(), "{shifted:?}");
        // Variance alone is no bias, and a bias below rounding is none either.
        assert!(coins(4000, 0.001).z_test(&known, &variance, 0.01, 0.1).passes());
    }

    #[test]
    fn pixels_without_variance_are_held_to_rounding() {
        let mut moments = Moments::default();
        moments.push(&[Vec3::splat(1.001)]);
        let zero = [DVec3::ZERO];
        assert!(moments.z_test(&[DVec3::ONE], &zero, 0.01, 0.01).passes());
        assert!(!moments.z_test(&[DVec3::ONE], &zero, 0.01, 1e-4).passes());
    }

    #[test]
    fn what_is_not_a_number_or_missing_fails() {
        let mut moments = Moments::default();
        moments.push(&[Vec3::NAN]);
        assert!(!moments.z_test(&[DVec3::ONE], &[DVec3::ONE], 0.01, 0.0).passes());
        assert!(!moments.z_test(&[DVec3::ONE; 2], &[DVec3::ONE; 2], 0.01, 0.0).passes());
        assert!(!Moments::default().z_test(&[], &[], 0.01, 0.0).passes());
    }

    #[test]
    fn the_limit_is_that_of_one_test_and_grows_with_their_number() {
        assert!((sidak(0.05, 1) - 1.959_963_984_540_054).abs() < 1e-9);
        assert!(sidak(0.05, 1_000_000) > 5.0);
    }

    #[test]
    fn counts_are_held_against_probabilities() {
        let mut counts = [0u64; 4];
        let mut random = Random::new(1, 2, 3);
        for _ in 0..10_000 {
            let at = random.unit();
            counts[if at < 0.5 {
                0
            } else if at < 0.75 {
                1
            } else if at < 0.9999 {
                2
            } else {
                3
            }] += 1;
        }
        assert!(chi_squared(&counts, &[0.5, 0.25, 0.2499, 0.0001]) > 1e-3);
        assert!(chi_squared(&counts, &[0.45, 0.3, 0.2499, 0.0001]) < 1e-6);
        // What cannot be drawn never is.
        assert_eq!(chi_squared(&[3, 1], &[1.0, 0.0]), 0.0);
        assert_eq!(chi_squared(&[3, 0], &[1.0, 0.0]), 1.0);
    }
}
