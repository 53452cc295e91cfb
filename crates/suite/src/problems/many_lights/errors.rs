//! How far lit pixels are from the truth.

use super::{picture::encoded, truth::Truth};
use crate::SuiteError;
use dapple_metrics::stats::percentile;
use glam::{DVec3, Vec3};
use std::collections::BTreeMap;

/// Errors of pixels, collected over the frames of a path.
#[derive(Clone, Debug, Default)]
pub struct Score {
    /// Of the worst channel, one a pixel.
    worst: Vec<f64>,
    squares: f64,
    most_steps: f64,
    /// Sum of signed errors, and of truths, over channels.
    signed: f64,
    truth: f64,
}

impl Score {
    /// Adds a frame.
    pub fn add(&mut self, truth: &Truth, frame: usize, radiance: &[Vec3]) {
        for (pixel, exact) in truth.frame(frame) {
            let given = radiance[pixel as usize].as_dvec3();
            let error = given - exact;
            self.worst.push(error.abs().max_element());
            self.squares += error.length_squared();
            self.signed += error.element_sum();
            self.truth += exact.element_sum();
            let steps = (srgb_steps(given) - srgb_steps(exact)).abs().max_element();
            self.most_steps = self.most_steps.max(steps);
        }
    }

    /// The mean of the truth over pixels and channels.
    pub fn mean_truth(&self) -> f64 {
        self.truth / (3.0 * self.worst.len().max(1) as f64)
    }

    /// Mean signed error over the mean truth; 0 where there is no light at all and none is given.
    pub fn relative_bias(&self) -> f64 {
        if self.signed == 0.0 { 0.0 } else { self.signed / self.truth }
    }

    /// The metrics of one run.
    ///
    /// # Errors
    /// A radiance that is not a number.
    pub fn errors(&self) -> Result<BTreeMap<String, f64>, SuiteError> {
        let count = 3.0 * self.worst.len().max(1) as f64;
        let metrics = [
            ("error_p99", percentile(&self.worst, 0.99)?),
            ("error_max", percentile(&self.worst, 1.0)?),
            ("rmse", (self.squares / count).sqrt()),
            ("error_8bit", self.most_steps),
        ];
        Ok(metrics.map(|(name, value)| (name.to_string(), value)).into())
    }
}

/// A colour in steps of 8-bit sRGB, rounded, each 0..=255.
pub fn srgb_steps(linear: DVec3) -> DVec3 {
    let one = |v: f64| (255.0 * encoded(v)).round();
    DVec3::new(one(linear.x), one(linear.y), one(linear.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn score(pairs: &[(f32, f64)]) -> Score {
        let exact = pairs.iter().map(|(_, exact)| DVec3::splat(*exact));
        let truth = Truth::given(vec![(0..).zip(exact).collect()]);
        let radiance: Vec<Vec3> = pairs.iter().map(|(given, _)| Vec3::splat(*given)).collect();
        let mut score = Score::default();
        score.add(&truth, 0, &radiance);
        score
    }

    #[test]
    fn metrics_are_those_of_hand() {
        let errors = score(&[(0.5, 0.5), (0.25, 0.5), (1.0, 0.5), (0.0, 0.0)]).errors().unwrap();
        assert_eq!(errors["error_max"], 0.5);
        assert!((errors["rmse"] - (0.3125_f64 / 4.0).sqrt()).abs() < 1e-12);
        // 0.5 is step 188 of 8-bit sRGB, 0.25 step 137, 1 step 255.
        assert_eq!(errors["error_8bit"], 67.0);
    }

    #[test]
    fn bias_has_a_sign_until_it_is_reported() {
        assert!((score(&[(0.5, 1.0), (1.0, 1.0)]).relative_bias() + 0.25).abs() < 1e-12);
        assert_eq!(score(&[(0.0, 0.0)]).relative_bias(), 0.0);
        assert!(score(&[(0.1, 0.0)]).relative_bias().is_infinite());
    }

    #[test]
    fn what_is_not_a_number_is_no_error() {
        assert!(score(&[(f32::NAN, 1.0)]).errors().is_err());
    }

    #[test]
    fn steps_are_those_of_srgb() {
        let steps = srgb_steps(DVec3::new(0.0, 0.215_860_5, 2.0));
        assert_eq!(steps, DVec3::new(0.0, 128.0, 255.0));
    }
}
