//! Bias and noise of what draws lights by chance, apart: by repeating it under other seeds.

use super::{case::LightsCase, errors::Score};
use crate::SuiteError;
use dapple_many_lights::{Lighting, Shaded};
use glam::DVec3;

/// Repetitions.
pub const REPETITIONS: u32 = 16;

/// Standard errors by which the mean of an unbiased technique may miss the truth. The standard error
/// itself is estimated from few repetitions, so the tails are those of Student's distribution with
/// 15 degrees of freedom: 1 in a million beyond 8.
pub const MOST_Z: f64 = 8.0;

/// What repetitions show.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spread {
    /// Error of the mean over everything, over the mean truth.
    pub bias: f64,
    /// The same in standard errors of that mean.
    pub z: f64,
    /// Root mean squared deviation of a pixel between repetitions, over the mean truth.
    pub noise: f64,
}

/// Repeats a technique's path under seeds behind `seed`.
///
/// # Errors
/// The technique's.
pub fn spread(
    case: &LightsCase<'_>,
    lighting: &mut dyn Lighting,
    seed: u32,
) -> Result<Spread, SuiteError> {
    let truth = case.truth();
    let mut sums = vec![(DVec3::ZERO, DVec3::ZERO); truth.pixels()];
    let mut biases = Vec::new();
    let mut mean_truth = 0.0;
    let mut shaded = Shaded::default();
    for repetition in 0..REPETITIONS {
        lighting.reset(seed.wrapping_add(1 + repetition))?;
        let mut score = Score::default();
        let mut rest = sums.iter_mut();
        for frame in 0..case.world().frames.len() {
            lighting.shade(frame, false)?;
            lighting.read(&mut shaded)?;
            score.add(truth, frame, &shaded.radiance);
            for ((pixel, exact), (sum, squares)) in truth.frame(frame).zip(rest.by_ref()) {
                // About the truth, so that squares do not cancel.
                let error = shaded.radiance[pixel as usize].as_dvec3() - exact;
                *sum += error;
                *squares += error * error;
            }
        }
        biases.push(score.relative_bias());
        mean_truth = score.mean_truth();
    }
    let count = f64::from(REPETITIONS);
    let variance = |(sum, squares): &(DVec3, DVec3)| {
        ((*squares - *sum * *sum / count) / (count - 1.0)).max(DVec3::ZERO).element_sum()
    };
    let variance = sums.iter().map(variance).sum::<f64>() / (3.0 * sums.len().max(1) as f64);
    let bias = biases.iter().sum::<f64>() / count;
    let of_bias = biases.iter().map(|b| (b - bias).powi(2)).sum::<f64>() / (count - 1.0);
    let standard_error = (of_bias / count).sqrt();
    // What repeats exactly has no standard error: then rounding is all that may remain.
    let z = bias.abs() / standard_error.max(1e-6);
    let noise = if mean_truth > 0.0 { variance.sqrt() / mean_truth } else { 0.0 };
    Ok(Spread { bias: bias.abs(), z, noise })
}
