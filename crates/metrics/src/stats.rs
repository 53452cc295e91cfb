//! Summaries of samples.
//!
//! Errors: [`MetricError::Empty`], [`MetricError::NotFinite`].

use crate::error::MetricError;
use crate::input::{finite, pairs};

/// Middle value; the mean of the middle two for an even count.
///
/// # Errors
/// See the module.
pub fn median(values: &[f64]) -> Result<f64, MetricError> {
    finite(values)?;
    let mut values = values.to_vec();
    let half = values.len() / 2;
    let even = values.len().is_multiple_of(2);
    let (below, &mut upper, _) = values.select_nth_unstable_by(half, f64::total_cmp);
    if !even {
        return Ok(upper);
    }
    let lower = below.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // Halved first: the sum may overflow.
    Ok(lower / 2.0 + upper / 2.0)
}

/// Median absolute deviation from the median. Not scaled: times 1.4826 it estimates the standard
/// deviation of a normal distribution.
///
/// # Errors
/// See the module; a deviation beyond the range of `f64` is not finite.
pub fn mad(values: &[f64]) -> Result<f64, MetricError> {
    let centre = median(values)?;
    median(&values.iter().map(|v| (v - centre).abs()).collect::<Vec<_>>())
}

/// Percentile by nearest rank: the smallest of the values that at least a share `q` in 0..=1 of
/// them do not exceed. Always one of the values; `q` = 0 is the least, 1 the greatest.
///
/// # Errors
/// See the module; [`MetricError::Parameter`] for a bad `q`.
pub fn percentile(values: &[f64], q: f64) -> Result<f64, MetricError> {
    finite(values)?;
    let rank = nearest_rank(values.len(), q)?;
    let mut values = values.to_vec();
    Ok(*values.select_nth_unstable_by(rank, f64::total_cmp).1)
}

/// [`percentile`] 0.99: the greatest value where there are fewer than 100.
///
/// # Errors
/// See the module.
pub fn p99(values: &[f64]) -> Result<f64, MetricError> {
    percentile(values, 0.99)
}

/// A ratio and its spread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ratio {
    /// Median of the ratios pair by pair.
    pub median: f64,
    /// Their median absolute deviation.
    pub mad: f64,
}

/// Median of `a[i] / b[i]` and its spread. Pairs measured next to each other share the machine's
/// drift, which cancels; a ratio of medians would keep it.
///
/// # Errors
/// See the module; [`MetricError::Length`]; [`MetricError::NotPositive`] if an element of `b` is
/// not above zero.
pub fn paired_ratio(a: &[f64], b: &[f64]) -> Result<Ratio, MetricError> {
    let pairs = pairs(a, b, None)?;
    if let Some(pair) = pairs.iter().find(|p| p.b <= 0.0) {
        return Err(MetricError::NotPositive { index: pair.index });
    }
    let ratios: Vec<f64> = pairs.iter().map(|p| p.a / p.b).collect();
    Ok(Ratio { median: median(&ratios)?, mad: mad(&ratios)? })
}

/// `new / old - 1`: 0.1 is ten per cent more.
///
/// # Errors
/// [`MetricError::NotFinite`] (index 0 is `old`, 1 `new`); [`MetricError::NotPositive`] if `old` is
/// not above zero.
pub fn relative_change(old: f64, new: f64) -> Result<f64, MetricError> {
    finite(&[old, new])?;
    if old <= 0.0 {
        return Err(MetricError::NotPositive { index: 0 });
    }
    // Not new / old - 1, which cancels for small changes.
    Ok((new - old) / old)
}

/// Index into the sorted values.
pub(crate) fn nearest_rank(count: usize, q: f64) -> Result<usize, MetricError> {
    if !(0.0..=1.0).contains(&q) {
        return Err(MetricError::Parameter { name: "q", value: q, range: "0..=1" });
    }
    // The slack undoes roundings such as 0.07 * 100 = 7.000000000000001.
    let rank = (q * count as f64 * (1.0 - 1e-12)).ceil() as usize;
    Ok(rank.clamp(1, count) - 1)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::test_config::config;

    #[test]
    fn hand_computed_values() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), Ok(2.0));
        assert_eq!(median(&[4.0, 1.0, 3.0, 2.0]), Ok(2.5));
        assert_eq!(median(&[7.0]), Ok(7.0));
        // Deviations from 3: 2, 1, 0, 1, 97.
        assert_eq!(mad(&[1.0, 2.0, 3.0, 4.0, 100.0]), Ok(1.0));
        assert_eq!(median(&[f64::MAX, f64::MAX]), Ok(f64::MAX));
        assert!((relative_change(2.0, 2.5).unwrap() - 0.25).abs() < 1e-15);
    }

    #[test]
    fn percentiles_are_nearest_ranks() {
        let values: Vec<f64> = (1..=100).rev().map(f64::from).collect();
        for hundredth in 1..=100 {
            let q = f64::from(hundredth) / 100.0;
            assert_eq!(percentile(&values, q), Ok(f64::from(hundredth)), "{q}");
        }
        assert_eq!(percentile(&values, 0.0), Ok(1.0));
        assert_eq!(p99(&values), Ok(99.0));
        assert_eq!(p99(&values[..99]), Ok(100.0), "fewer than 100 values: the greatest");
        assert_eq!(percentile(&values, 0.991), Ok(100.0));
    }

    #[test]
    fn paired_ratios_cancel_drift() {
        // The machine slows down fourfold; a costs twice b throughout.
        let b = [1.0, 2.0, 3.0, 4.0];
        let a = [2.0, 4.0, 6.0, 8.0];
        assert_eq!(paired_ratio(&a, &b), Ok(Ratio { median: 2.0, mad: 0.0 }));
        // Ratios 1, 2, 4, 8.
        let c = [1.0, 4.0, 12.0, 32.0];
        assert_eq!(paired_ratio(&c, &b), Ok(Ratio { median: 3.0, mad: 1.5 }));
    }

    #[test]
    fn bad_input_is_refused() {
        assert_eq!(median(&[]), Err(MetricError::Empty));
        assert_eq!(mad(&[1.0, f64::NAN]), Err(MetricError::NotFinite { index: 1 }));
        assert_eq!(p99(&[f64::INFINITY]), Err(MetricError::NotFinite { index: 0 }));
        assert_eq!(paired_ratio(&[1.0], &[0.0]), Err(MetricError::NotPositive { index: 0 }));
        assert_eq!(
            paired_ratio(&[1.0, 2.0], &[1.0]),
            Err(MetricError::Length { left: 2, right: 1 })
        );
        assert_eq!(relative_change(0.0, 1.0), Err(MetricError::NotPositive { index: 0 }));
        assert_eq!(relative_change(1.0, f64::NAN), Err(MetricError::NotFinite { index: 1 }));
    }

    proptest! {
        #![proptest_config(config())]

        #[test]
        fn medians_scale_and_half_lies_on_either_side(
            values in prop::collection::vec(-1e6..1e6_f64, 1..100),
            exponent in -6..=6_i32,
        ) {
            let centre = median(&values)?;
            let half = values.len().div_ceil(2);
            prop_assert!(values.iter().filter(|v| **v <= centre).count() >= half);
            prop_assert!(values.iter().filter(|v| **v >= centre).count() >= half);
            // A power of two scales exactly.
            let scale = 2.0_f64.powi(3 * exponent);
            let scaled: Vec<f64> = values.iter().map(|v| v * scale).collect();
            prop_assert_eq!(median(&scaled)?, centre * scale);
            prop_assert_eq!(mad(&scaled)?, mad(&values)? * scale);
        }

        #[test]
        fn percentiles_keep_their_definition(
            values in prop::collection::vec(-10..10_i32, 1..60),
            q in 0.0..=1.0_f64,
        ) {
            let values: Vec<f64> = values.into_iter().map(f64::from).collect();
            let p = percentile(&values, q)?;
            let n = values.len() as f64;
            let share = |limit: f64, strict: bool| {
                let below = |v: &&f64| if strict { **v < limit } else { **v <= limit };
                values.iter().filter(below).count() as f64 / n
            };
            prop_assert!(share(p, false) >= q - 1e-9);
            prop_assert!(share(p, true) <= q);
        }
    }
}
