//! Bands and layers: how uneven an error is along a line, and how well cells are used.
//!
//! Based on: Voicu 2011 (`voicu2011`), whose claims on layering are judged by eye; these are the
//! figures for them.

use crate::error::MetricError;
use crate::input::finite;
use crate::sum::Sum;

/// Root mean squared step between neighbours of an error that is sampled at equal distances along
/// a line. A constant error has no bands and gives 0; so many jumps of one height in so many
/// steps give the height times the root of their share, wherever they stand.
///
/// # Errors
/// [`MetricError::Empty`] for fewer than two samples; [`MetricError::NotFinite`], also where a
/// step is beyond the range of `f64`.
pub fn banding(errors: &[f64]) -> Result<f64, MetricError> {
    finite(errors)?;
    let steps: Vec<f64> = errors.windows(2).map(|pair| pair[1] - pair[0]).collect();
    finite(&steps)?;
    // Scaled before they are squared: no overflow or underflow.
    let most = steps.iter().fold(0.0_f64, |most, step| most.max(step.abs()));
    if most == 0.0 {
        return Ok(0.0);
    }
    let squares: Sum = steps.iter().map(|step| (step / most).powi(2)).collect();
    Ok(most * (squares.total() / steps.len() as f64).sqrt())
}

/// Share of the cells of a histogram that hold anything, 0..=1.
///
/// # Errors
/// [`MetricError::Empty`] without a cell.
pub fn used_share(counts: &[u64]) -> Result<f64, MetricError> {
    if counts.is_empty() {
        return Err(MetricError::Empty);
    }
    Ok(counts.iter().filter(|n| **n > 0).count() as f64 / counts.len() as f64)
}

/// Entropy of a histogram in bits: 0 where one cell holds all, `log2(cells)` where all hold the
/// same.
///
/// # Errors
/// [`MetricError::Empty`] where nothing is counted.
pub fn entropy_bits(counts: &[u64]) -> Result<f64, MetricError> {
    let total: Sum = counts.iter().map(|n| *n as f64).collect();
    let total = total.total();
    if total == 0.0 {
        return Err(MetricError::Empty);
    }
    let terms: Sum = counts
        .iter()
        .filter(|n| **n > 0)
        .map(|n| {
            let share = *n as f64 / total;
            -share * share.log2()
        })
        .collect();
    // A share that rounds to 1 has the logarithm -0.
    Ok(terms.total().max(0.0))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::test_config::config;

    #[test]
    fn hand_computed_values() {
        // Steps 3, 0, -4, 0: the root of 25 / 4.
        assert_eq!(banding(&[1.0, 4.0, 4.0, 0.0, 0.0]), Ok(2.5));
        assert_eq!(banding(&[0.3; 9]), Ok(0.0));
        assert_eq!(used_share(&[0, 3, 0, 1]), Ok(0.5));
        assert_eq!(used_share(&[0; 4]), Ok(0.0));
        // 1/2 at 1 bit, twice 1/4 at 2 bits.
        assert_eq!(entropy_bits(&[2, 0, 1, 1]), Ok(1.5));
        assert_eq!(entropy_bits(&[0, 7, 0]), Ok(0.0));
        assert_eq!(entropy_bits(&[5; 8]), Ok(3.0));
        assert!(entropy_bits(&[u64::MAX; 4]).is_ok_and(|bits| (bits - 2.0).abs() < 1e-12));
    }

    #[test]
    fn a_staircase_has_more_bands_than_a_ramp_of_the_same_rise() {
        let ramp: Vec<f64> = (0..=64).map(|i| f64::from(i) / 64.0).collect();
        let stairs: Vec<f64> = (0..=64).map(|i| f64::from(i / 16) / 4.0).collect();
        let (smooth, stepped) = (banding(&ramp).unwrap(), banding(&stairs).unwrap());
        assert!((smooth - 1.0 / 64.0).abs() < 1e-15);
        // Four jumps of 1/4 in 64 steps.
        assert!((stepped - 0.25 * (4.0_f64 / 64.0).sqrt()).abs() < 1e-15);
        // The same error with a bias is as banded.
        let biased: Vec<f64> = stairs.iter().map(|x| x + 2.0).collect();
        assert_eq!(banding(&biased), Ok(stepped));
    }

    #[test]
    fn bad_input_is_refused() {
        for short in [&[][..], &[1.0]] {
            assert_eq!(banding(short), Err(MetricError::Empty));
        }
        let bad = [0.0, 1.0, f64::NAN];
        assert_eq!(banding(&bad), Err(MetricError::NotFinite { index: 2 }));
        let far = [0.0, f64::MAX, -f64::MAX];
        assert_eq!(banding(&far), Err(MetricError::NotFinite { index: 1 }));
        assert_eq!(used_share(&[]), Err(MetricError::Empty));
        assert_eq!(entropy_bits(&[]), Err(MetricError::Empty));
        assert_eq!(entropy_bits(&[0, 0]), Err(MetricError::Empty));
    }

    proptest! {
        #![proptest_config(config())]

        #[test]
        fn banding_scales_and_lies_below_the_largest_step(
            errors in prop::collection::vec(-1.0..1.0_f64, 2..50),
            scale in 1e-150..1e150_f64,
        ) {
            let plain = banding(&errors).unwrap();
            let most = errors.windows(2).fold(0.0_f64, |m, p| m.max((p[1] - p[0]).abs()));
            prop_assert!(plain <= most * (1.0 + 1e-12));
            let scaled: Vec<f64> = errors.iter().map(|x| x * scale).collect();
            let ratio = banding(&scaled).unwrap() / scale;
            prop_assert!((ratio - plain).abs() <= 1e-9 * most);
        }

        #[test]
        fn entropy_is_bounded_by_the_cells_in_use_and_ignores_order(
            counts in prop::collection::vec(0..1000_u64, 1..40),
        ) {
            prop_assume!(counts.iter().any(|n| *n > 0));
            let bits = entropy_bits(&counts).unwrap();
            let used = counts.iter().filter(|n| **n > 0).count() as f64;
            prop_assert!((0.0..=used.log2() + 1e-12).contains(&bits));
            let mut turned = counts.clone();
            turned.reverse();
            prop_assert!((entropy_bits(&turned).unwrap() - bits).abs() < 1e-12);
            // Halving each cell adds one bit.
            let halves: Vec<u64> = counts.iter().flat_map(|n| [*n, *n]).collect();
            prop_assert!((entropy_bits(&halves).unwrap() - bits - 1.0).abs() < 1e-12);
        }
    }
}
