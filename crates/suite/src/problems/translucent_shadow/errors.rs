//! How wrong transmittances are: every metric that the problem declares.

use super::case::TranslucentCase;
use crate::SuiteError;
use dapple_metrics::{MetricError, flip_gray_mean, max_abs, percentile_abs, rmse, ssim};
use std::collections::BTreeMap;

/// Errors against the truth by metric name; one transmittance a receiver.
///
/// # Errors
/// Another length, or a value that is not finite.
pub fn against_truth(
    case: &TranslucentCase<'_>,
    result: &[f32],
) -> Result<BTreeMap<String, f64>, SuiteError> {
    let truth = case.truth();
    let [width, height] = case.size();
    let (image, true_image) = (case.image(result), case.image(truth));
    let mask = Some(case.mask());
    let n = case.mask().iter().filter(|m| **m).count().max(1) as f64;
    // Receivers that do not count are 1 in both.
    let signed = |sign: f64| {
        let one = |(a, b): (&f32, &f32)| (sign * (f64::from(*a) - f64::from(*b))).max(0.0);
        result.iter().zip(truth).map(one).sum::<f64>() / n
    };
    let figures = [
        ("rmse", rmse(result, truth, mask)),
        ("p95", percentile_abs(result, truth, 0.95, mask)),
        ("max", max_abs(result, truth, mask)),
        ("leak", Ok(signed(1.0))),
        ("dark", Ok(signed(-1.0))),
        ("flip", flip_gray_mean(width, height, &image, &true_image)),
        ("ssim_loss", ssim(width, height, &image, &true_image).map(|s| 1.0 - s)),
    ];
    let mut errors = BTreeMap::new();
    for (name, figure) in figures {
        match figure {
            Ok(value) => {
                errors.insert(name.to_string(), value);
            }
            Err(MetricError::Empty) => {}
            Err(error) => return Err(error.into()),
        }
    }
    Ok(errors)
}
