//! Pixel by pixel errors of a result against its truth.
//!
//! `mask` selects the pixels that take part (`true`); without one all do. Values that are left
//! out may be NaN. Errors: [`MetricError::Length`], [`MetricError::Empty`] if nothing takes part,
//! [`MetricError::NotFinite`].

use crate::error::MetricError;
use crate::input::pairs;
use crate::stats::nearest_rank;
use crate::sum::Sum;

/// Root of the mean squared difference. Symmetric; the unit of the input.
///
/// Differences are scaled by their maximum before they are squared: no overflow or underflow
/// between 1e-300 and 1e300.
///
/// # Errors
/// See the module.
pub fn rmse<A: Copy + Into<f64>, B: Copy + Into<f64>>(
    a: &[A],
    b: &[B],
    mask: Option<&[bool]>,
) -> Result<f64, MetricError> {
    let pairs = pairs(a, b, mask)?;
    let most = pairs.iter().fold(0.0_f64, |most, p| most.max((p.a - p.b).abs()));
    if most == 0.0 {
        return Ok(0.0);
    }
    let squares: Sum = pairs.iter().map(|p| ((p.a - p.b) / most).powi(2)).collect();
    Ok(most * (squares.total() / pairs.len() as f64).sqrt())
}

/// Mean absolute difference. Symmetric; the unit of the input.
///
/// # Errors
/// See the module.
pub fn mae<A: Copy + Into<f64>, B: Copy + Into<f64>>(
    a: &[A],
    b: &[B],
    mask: Option<&[bool]>,
) -> Result<f64, MetricError> {
    let pairs = pairs(a, b, mask)?;
    mean(pairs.iter().map(|p| (p.a - p.b).abs()))
}

/// Mean of `result - truth`: above zero where the result is too bright on the whole. Never larger
/// than [`mae`]; equal to it where all errors have one sign.
///
/// # Errors
/// See the module.
pub fn bias<A: Copy + Into<f64>, B: Copy + Into<f64>>(
    result: &[A],
    truth: &[B],
    mask: Option<&[bool]>,
) -> Result<f64, MetricError> {
    let pairs = pairs(result, truth, mask)?;
    mean(pairs.iter().map(|p| p.a - p.b))
}

/// Largest absolute difference.
///
/// # Errors
/// See the module.
pub fn max_abs<A: Copy + Into<f64>, B: Copy + Into<f64>>(
    a: &[A],
    b: &[B],
    mask: Option<&[bool]>,
) -> Result<f64, MetricError> {
    Ok(pairs(a, b, mask)?.iter().fold(0.0, |most, p| most.max((p.a - p.b).abs())))
}

/// The absolute difference that a share `q` in 0..=1 of the pixels do not exceed, by nearest rank
/// (see [`crate::stats::percentile`]). `q` = 1 is [`max_abs`].
///
/// # Errors
/// See the module; [`MetricError::Parameter`] for a bad `q`.
pub fn percentile_abs<A: Copy + Into<f64>, B: Copy + Into<f64>>(
    a: &[A],
    b: &[B],
    q: f64,
    mask: Option<&[bool]>,
) -> Result<f64, MetricError> {
    let mut differences: Vec<f64> = pairs(a, b, mask)?.iter().map(|p| (p.a - p.b).abs()).collect();
    let rank = nearest_rank(differences.len(), q)?;
    Ok(*differences.select_nth_unstable_by(rank, f64::total_cmp).1)
}

/// Peak signal-to-noise ratio in dB, `20 log10(peak / rmse)`. `peak` is the value of white (1 for
/// visibility). Infinite for equal images: a record leaves it out then.
///
/// # Errors
/// See the module; [`MetricError::Parameter`] for a peak that is not above zero.
pub fn psnr<A: Copy + Into<f64>, B: Copy + Into<f64>>(
    a: &[A],
    b: &[B],
    peak: f64,
    mask: Option<&[bool]>,
) -> Result<f64, MetricError> {
    if !(peak.is_finite() && peak > 0.0) {
        return Err(MetricError::Parameter { name: "peak", value: peak, range: "above 0" });
    }
    // A difference of logarithms: the quotient itself may overflow.
    Ok(20.0 * (peak.log10() - rmse(a, b, mask)?.log10()))
}

/// Light leaking: the mean result over the pixels whose truth is exactly 0 (in full shadow).
///
/// # Errors
/// See the module; [`MetricError::Empty`] if no pixel is in full shadow.
pub fn leak_energy<A: Copy + Into<f64>, B: Copy + Into<f64>>(
    result: &[A],
    truth: &[B],
    mask: Option<&[bool]>,
) -> Result<f64, MetricError> {
    let pairs = pairs(result, truth, mask)?;
    mean(pairs.iter().filter(|p| p.b == 0.0).map(|p| p.a))
}

/// Light lost (shadow acne): the mean of `1 - result` over the pixels whose truth is exactly 1
/// (fully lit).
///
/// # Errors
/// See the module; [`MetricError::Empty`] if no pixel is fully lit.
pub fn loss_energy<A: Copy + Into<f64>, B: Copy + Into<f64>>(
    result: &[A],
    truth: &[B],
    mask: Option<&[bool]>,
) -> Result<f64, MetricError> {
    let pairs = pairs(result, truth, mask)?;
    mean(pairs.iter().filter(|p| p.b == 1.0).map(|p| 1.0 - p.a))
}

/// Scaled by the largest magnitude, as in [`rmse`]: the sum of huge values may overflow.
fn mean(values: impl Iterator<Item = f64>) -> Result<f64, MetricError> {
    let values: Vec<f64> = values.collect();
    if values.is_empty() {
        return Err(MetricError::Empty);
    }
    let most = values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    if most == 0.0 {
        return Ok(0.0);
    }
    let sum: Sum = values.iter().map(|v| v / most).collect();
    Ok(most * (sum.total() / values.len() as f64))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::test_config::config;

    const A: [f64; 4] = [1.0, 2.0, 3.0, 4.0];
    const B: [f64; 4] = [1.0, 4.0, 3.0, 0.0];

    #[test]
    fn hand_computed_values() {
        // Differences 0, 2, 0, 4.
        assert_eq!(rmse(&A, &B, None), Ok(5.0_f64.sqrt()));
        assert_eq!(mae(&A, &B, None), Ok(1.5));
        // Signed: 0, -2, 0, 4.
        assert_eq!(bias(&A, &B, None), Ok(0.5));
        assert_eq!(bias(&B, &A, None), Ok(-0.5));
        assert_eq!(bias(&A, &B, Some(&[true, true, true, false])), Ok(-2.0 / 3.0));
        assert_eq!(max_abs(&A, &B, None), Ok(4.0));
        assert_eq!(percentile_abs(&A, &B, 0.5, None), Ok(0.0));
        assert_eq!(percentile_abs(&A, &B, 0.75, None), Ok(2.0));
        assert_eq!(percentile_abs(&A, &B, 1.0, None), Ok(4.0));
        // rmse 0.1 of peak 1 is 20 dB.
        assert!((psnr(&[0.5_f64; 3], &[0.6; 3], 1.0, None).unwrap() - 20.0).abs() < 1e-12);
    }

    #[test]
    fn masks_select_and_hide_nan() {
        let mask = [true, true, false, false];
        assert_eq!(mae(&A, &B, Some(&mask)), Ok(1.0));
        let holed = [1.0, 2.0, f64::NAN, 4.0];
        assert_eq!(mae(&holed, &B, Some(&mask)), Ok(1.0));
        assert_eq!(mae(&holed, &B, None), Err(MetricError::NotFinite { index: 2 }));
        assert_eq!(mae(&A, &B, Some(&[false; 4])), Err(MetricError::Empty));
        assert_eq!(mae(&A, &B, Some(&[true])), Err(MetricError::Length { left: 4, right: 1 }));
    }

    #[test]
    fn bad_input_is_refused() {
        let empty: [f32; 0] = [];
        assert_eq!(rmse(&empty, &empty, None), Err(MetricError::Empty));
        assert_eq!(rmse(&A, &[1.0], None), Err(MetricError::Length { left: 4, right: 1 }));
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let wrong = [0.0, bad];
            let none = Err(MetricError::NotFinite { index: 1 });
            assert_eq!(rmse(&wrong, &[0.0; 2], None), none);
            assert_eq!(rmse(&[0.0; 2], &wrong, None), none);
            assert_eq!(max_abs(&wrong, &wrong, None), none);
            assert_eq!(bias(&wrong, &wrong, None), none);
            assert_eq!(leak_energy(&wrong, &[0.0; 2], None), none);
        }
        assert_eq!(
            max_abs(&[f64::MAX], &[f64::MIN], None),
            Err(MetricError::NotFinite { index: 0 })
        );
        for q in [-0.1, 1.1, f64::NAN] {
            assert!(matches!(
                percentile_abs(&A, &B, q, None),
                Err(MetricError::Parameter { name: "q", .. })
            ));
        }
        for peak in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(psnr(&A, &B, peak, None).is_err());
        }
    }

    #[test]
    fn leaks_count_only_full_shadow_and_losses_only_full_light() {
        let truth = [0.0_f64, 0.0, 0.5, 1.0, 1.0];
        let result = [0.25_f32, 0.0, 0.9, 0.5, 1.0];
        assert_eq!(leak_energy(&result, &truth, None), Ok(0.125));
        assert_eq!(loss_energy(&result, &truth, None), Ok(0.25));
        assert_eq!(leak_energy(&truth, &truth, None), Ok(0.0));
        let shadowless = [1.0, 0.001];
        assert_eq!(leak_energy(&shadowless, &shadowless, None), Err(MetricError::Empty));
    }

    #[test]
    fn equal_images_have_infinite_psnr() {
        assert_eq!(psnr(&A, &A, 1.0, None), Ok(f64::INFINITY));
    }

    #[test]
    fn means_of_the_greatest_values_are_finite() {
        assert_eq!(mae(&[f64::MAX; 3], &[0.0; 3], None), Ok(f64::MAX));
        assert_eq!(rmse(&[f64::MAX; 3], &[0.0; 3], None), Ok(f64::MAX));
        assert_eq!(leak_energy(&[f64::MAX; 3], &[0.0; 3], None), Ok(f64::MAX));
    }

    #[test]
    fn squares_neither_overflow_nor_underflow() {
        for scale in [1e-300, 1e-200, 1e-6, 1.0, 1e6, 1e200, 1e300] {
            let a = A.map(|v| v * scale);
            let b = B.map(|v| v * scale);
            let relative = rmse(&a, &b, None).unwrap() / scale / 5.0_f64.sqrt() - 1.0;
            assert!(relative.abs() < 1e-14, "{scale}: {relative}");
            let relative = mae(&a, &b, None).unwrap() / scale / 1.5 - 1.0;
            assert!(relative.abs() < 1e-14, "{scale}: {relative}");
        }
    }

    proptest! {
        #![proptest_config(config())]

        #[test]
        fn means_are_ordered_and_symmetric(
            pairs in prop::collection::vec((-1e6..1e6_f64, -1e6..1e6_f64), 1..200),
            exponent in -6..=6_i32,
        ) {
            let scale = 10.0_f64.powi(exponent);
            let a: Vec<f64> = pairs.iter().map(|p| p.0 * scale).collect();
            let b: Vec<f64> = pairs.iter().map(|p| p.1 * scale).collect();
            let (mae, rmse_, max) =
                (mae(&a, &b, None)?, rmse(&a, &b, None)?, max_abs(&a, &b, None)?);
            let slack = 1.0 + 1e-12;
            prop_assert!(mae <= rmse_ * slack && rmse_ <= max * slack);
            prop_assert!(bias(&a, &b, None)?.abs() <= mae * slack);
            prop_assert_eq!(bias(&a, &b, None)?, -bias(&b, &a, None)?);
            prop_assert_eq!(rmse_, rmse(&b, &a, None)?);
            prop_assert_eq!(max, percentile_abs(&a, &b, 1.0, None)?);
            prop_assert_eq!(rmse(&a, &a, None)?, 0.0);
        }
    }
}
