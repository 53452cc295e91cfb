//! Leaks and errors of the four estimators over all scenes and biases.

use super::still::{BIASES, STILLS, Score, VSM, VSM_MAX};
use crate::SuiteError;
use dapple_metrics::stats;
use dapple_shadows::filtering::{Estimator, Settings};

/// Scores of one still by estimator and bias.
pub struct Scores {
    /// Scene and seed.
    pub name: String,
    /// One a bias.
    pub vsm: Vec<Score>,
    /// The same.
    pub vsm_max: Vec<Score>,
    /// The same.
    pub gaussian: Vec<Score>,
    /// The same.
    pub power: Vec<Score>,
    /// Of the exact share, as the floor that resolution and bias set.
    pub floor: Vec<f64>,
}

/// Scores over all stills and biases; `variances` are those of the least variance to try (none: the
/// default).
///
/// # Errors
/// Those of [`super::still::Still::score`].
pub fn gather(variances: &[f32]) -> Result<Vec<Scores>, SuiteError> {
    let default = Settings::new(VSM).min_variance;
    let variances = if variances.is_empty() { &[default] } else { variances };
    let mut all = Vec::new();
    for recipe in STILLS {
        let still = recipe.still()?;
        let mut scores = Scores {
            name: still.name.clone(),
            vsm: vec![],
            vsm_max: vec![],
            gaussian: vec![],
            power: vec![],
            floor: vec![],
        };
        for bias in BIASES {
            for &min_variance in variances {
                let score = |estimator| {
                    still.score(&Settings { min_variance, ..still.settings(estimator, bias) })
                };
                scores.vsm.push(score(VSM)?);
                scores.vsm_max.push(score(VSM_MAX)?);
                scores.gaussian.push(score(Estimator::GaussianCdf)?);
                scores.power.push(score(Estimator::PowerCdf)?);
                scores.floor.push(still.exact_leak(&still.settings(VSM, bias))?);
            }
        }
        all.push(scores);
    }
    Ok(all)
}

/// Median of one figure.
///
/// # Errors
/// No score, or one that is not finite.
pub fn median_of(scores: &[Score], of: impl Fn(&Score) -> f64) -> Result<f64, SuiteError> {
    Ok(stats::median(&scores.iter().map(of).collect::<Vec<_>>())?)
}
