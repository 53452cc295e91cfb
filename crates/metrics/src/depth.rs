//! Errors of depth maps: linear depths in 0..=1, where 1 marks an empty texel.

use crate::error::MetricError;
use crate::input::pairs;
use crate::sum::Sum;

/// How a depth map differs from its truth. Depth errors are over the texels that both maps cover;
/// NaN-free zeros if there are none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DepthErrors {
    /// Texels compared.
    pub texels: usize,
    /// Texels that both maps cover.
    pub covered: usize,
    /// Texels that the truth covers and the result leaves empty.
    pub missing: usize,
    /// Texels that the result covers and the truth leaves empty.
    pub extra: usize,
    /// Largest absolute error.
    pub max_abs: f64,
    /// Mean absolute error.
    pub mean_abs: f64,
    /// Largest relative error: the difference over the larger of both depths, in 0..=1; equal
    /// depths (also two zeros) have 0.
    pub max_relative: f64,
    /// Mean relative error.
    pub mean_relative: f64,
    /// Share of all texels that are missing, extra or off by more than the tolerance.
    pub share_beyond: f64,
}

/// Compares two depth maps; `tolerance` is absolute.
///
/// # Errors
/// [`MetricError::Length`], [`MetricError::Empty`], [`MetricError::NotFinite`];
/// [`MetricError::Parameter`] for a negative or NaN tolerance or a depth outside 0..=1.
pub fn compare<A: Copy + Into<f64>, B: Copy + Into<f64>>(
    result: &[A],
    truth: &[B],
    tolerance: f64,
) -> Result<DepthErrors, MetricError> {
    if tolerance.is_nan() || tolerance < 0.0 {
        return Err(MetricError::Parameter {
            name: "tolerance",
            value: tolerance,
            range: "at least 0",
        });
    }
    let pairs = pairs(result, truth, None)?;
    let mut errors = DepthErrors { texels: pairs.len(), ..DepthErrors::default() };
    let mut beyond = 0_usize;
    let (mut absolute, mut relative) = (Sum::default(), Sum::default());
    for pair in &pairs {
        if let Some(&value) = [pair.a, pair.b].iter().find(|v| !(0.0..=1.0).contains(*v)) {
            return Err(MetricError::Parameter { name: "depth", value, range: "0..=1" });
        }
        match (pair.a < 1.0, pair.b < 1.0) {
            (false, false) => {}
            (false, true) => errors.missing += 1,
            (true, false) => errors.extra += 1,
            (true, true) => {
                let difference = (pair.a - pair.b).abs();
                let larger = pair.a.max(pair.b);
                let share = if difference == 0.0 { 0.0 } else { difference / larger };
                errors.covered += 1;
                errors.max_abs = errors.max_abs.max(difference);
                errors.max_relative = errors.max_relative.max(share);
                absolute.add(difference);
                relative.add(share);
                beyond += usize::from(difference > tolerance);
            }
        }
    }
    if errors.covered > 0 {
        errors.mean_abs = absolute.total() / errors.covered as f64;
        errors.mean_relative = relative.total() / errors.covered as f64;
    }
    errors.share_beyond = (beyond + errors.missing + errors.extra) as f64 / errors.texels as f64;
    Ok(errors)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hand_computed_values() {
        //              equal  off 1/8  missing extra both empty, both zero
        let truth = [0.5_f64, 0.25, 0.5, 1.0, 1.0, 0.0];
        let result = [0.5_f32, 0.375, 1.0, 0.5, 1.0, 0.0];
        let errors = compare(&result, &truth, 0.1).unwrap();
        assert_eq!(
            errors,
            DepthErrors {
                texels: 6,
                covered: 3,
                missing: 1,
                extra: 1,
                max_abs: 0.125,
                mean_abs: 0.125 / 3.0,
                max_relative: 1.0 / 3.0,
                mean_relative: 1.0 / 9.0,
                share_beyond: 0.5,
            }
        );
        assert_eq!(compare(&result, &truth, 0.125).unwrap().share_beyond, 2.0 / 6.0);
    }

    #[test]
    fn small_depths_have_relative_errors() {
        let errors = compare(&[1e-6], &[2e-6], 1.0).unwrap();
        assert!((errors.max_relative - 0.5).abs() < 1e-12);
        assert_eq!(compare(&[1e-300], &[0.0], 0.0).unwrap().max_relative, 1.0);
    }

    #[test]
    fn bad_input_is_refused() {
        let bad = |depth: f64| compare(&[depth], &[0.5], 0.0);
        assert_eq!(bad(f64::NAN), Err(MetricError::NotFinite { index: 0 }));
        assert!(matches!(bad(1.5), Err(MetricError::Parameter { name: "depth", .. })));
        assert!(matches!(bad(-1e-9), Err(MetricError::Parameter { name: "depth", .. })));
        assert!(compare(&[0.5], &[0.5], f64::NAN).is_err());
        assert!(compare(&[0.5], &[0.5], -1.0).is_err());
        let none: [f32; 0] = [];
        assert_eq!(compare(&none, &none, 0.0), Err(MetricError::Empty));
    }
}
