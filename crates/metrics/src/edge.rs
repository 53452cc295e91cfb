//! Where a shadow's edge lies and how wide it is.
//!
//! A profile is visibility sampled at even steps across one edge, rising or falling, linear
//! between samples. Positions are in steps from the first sample. Levels are absolute: a shadow
//! that leaks more than 10 % has no 10 % crossing, hence no width. A profile whose ends lie on the
//! same side of 50 % holds no edge.
//!
//! Errors: [`MetricError::Empty`], [`MetricError::NotFinite`].

use crate::error::MetricError;
use crate::input::finite;

/// Every position at which the profile has this level, ascending. A stretch exactly at the level
/// counts by its two ends.
///
/// # Errors
/// See the module.
pub fn crossings(profile: &[f64], level: f64) -> Result<Vec<f64>, MetricError> {
    finite(profile)?;
    let mut positions: Vec<f64> = Vec::new();
    for (i, pair) in profile.windows(2).enumerate() {
        let (a, b) = (pair[0], pair[1]);
        let within = (a <= level && level <= b) || (b <= level && level <= a);
        if a == b || !within {
            continue;
        }
        // In halves: the difference of two huge values may overflow.
        let fraction = (level / 2.0 - a / 2.0) / (b / 2.0 - a / 2.0);
        let position = i as f64 + fraction;
        // A sample exactly at the level ends one step and begins the next.
        if positions.last() != Some(&position) {
            positions.push(position);
        }
    }
    Ok(positions)
}

/// Position of the 50 % crossing; the middle between the first and the last where there are
/// several. None if the profile holds no edge.
///
/// # Errors
/// See the module.
pub fn position_50(profile: &[f64]) -> Result<Option<f64>, MetricError> {
    let positions = crossings(profile, 0.5)?;
    if !is_edge(profile) {
        return Ok(None);
    }
    Ok(positions.first().zip(positions.last()).map(|(first, last)| first + (last - first) / 2.0))
}

/// Width of the edge: from the first 10 % crossing to the last 90 % crossing of a rising profile,
/// from the first 90 % to the last 10 % of a falling one. None if the profile holds no edge or
/// does not reach both levels in this order.
///
/// # Errors
/// See the module.
pub fn width_10_90(profile: &[f64]) -> Result<Option<f64>, MetricError> {
    let (low, high) = (crossings(profile, 0.1)?, crossings(profile, 0.9)?);
    if !is_edge(profile) {
        return Ok(None);
    }
    let rising = profile.first() < profile.last();
    let (start, end) = if rising { (low, high) } else { (high, low) };
    let width = start.first().zip(end.last()).map(|(start, end)| end - start);
    Ok(width.filter(|width| *width >= 0.0))
}

fn is_edge(profile: &[f64]) -> bool {
    match (profile.first(), profile.last()) {
        (Some(&first), Some(&last)) => {
            first != last && first.min(last) <= 0.5 && 0.5 <= first.max(last)
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::test_config::config;

    #[test]
    fn a_ramp_is_exact() {
        // 0 up to sample 2, then 1/8 a step, 1 from sample 10: 50 % at 6, 10-90 % in 6.4 steps.
        let mut profile: Vec<f64> = vec![0.0; 2];
        profile.extend((0..=8).map(|i| f64::from(i) / 8.0));
        profile.extend([1.0; 3]);
        assert_eq!(position_50(&profile), Ok(Some(6.0)));
        assert!((width_10_90(&profile).unwrap().unwrap() - 6.4).abs() < 1e-12);
        profile.reverse();
        assert_eq!(position_50(&profile), Ok(Some(13.0 - 6.0)));
        assert!((width_10_90(&profile).unwrap().unwrap() - 6.4).abs() < 1e-12);
    }

    #[test]
    fn a_step_lies_between_its_samples() {
        assert_eq!(position_50(&[0.0, 0.0, 1.0, 1.0]), Ok(Some(1.5)));
        let width = width_10_90(&[0.0, 0.0, 1.0, 1.0]).unwrap().unwrap();
        assert!((width - 0.8).abs() < 1e-15);
    }

    #[test]
    fn a_stretch_at_the_level_counts_by_its_middle() {
        assert_eq!(crossings(&[0.0, 0.5, 0.5, 0.5, 1.0], 0.5), Ok(vec![1.0, 3.0]));
        assert_eq!(position_50(&[0.0, 0.5, 0.5, 0.5, 1.0]), Ok(Some(2.0)));
        assert_eq!(crossings(&[0.0, 0.5, 1.0], 0.5), Ok(vec![1.0]), "once, not twice");
    }

    #[test]
    fn no_edge_gives_none() {
        for flat in [&[0.0; 4][..], &[1.0; 4], &[0.5; 4], &[0.5], &[0.0, 1.0, 0.0], &[0.2, 0.4]] {
            assert_eq!(position_50(flat), Ok(None), "{flat:?}");
            assert_eq!(width_10_90(flat), Ok(None), "{flat:?}");
        }
        let leaking = [0.2, 0.2, 1.0];
        assert!(position_50(&leaking).unwrap().is_some());
        assert_eq!(width_10_90(&leaking), Ok(None), "never below 10 %");
    }

    #[test]
    fn ripples_widen_the_edge_and_never_narrow_it() {
        let clean = [0.0, 0.0, 0.25, 0.5, 0.75, 1.0, 1.0];
        let ripple = [0.0, 0.2, 0.05, 0.5, 0.75, 1.0, 1.0];
        assert!(width_10_90(&ripple).unwrap() > width_10_90(&clean).unwrap());
    }

    #[test]
    fn bad_input_is_refused() {
        assert_eq!(position_50(&[]), Err(MetricError::Empty));
        assert_eq!(width_10_90(&[0.0, f64::NAN]), Err(MetricError::NotFinite { index: 1 }));
        assert_eq!(position_50(&[f64::MIN, f64::MAX]), Ok(Some(0.5)));
    }

    proptest! {
        #![proptest_config(config())]

        #[test]
        fn ramps_of_any_slope_are_exact(centre in 20.0..80.0_f64, width in 2.5..30.0_f64) {
            let ramp = |i: i32| (0.5 + (f64::from(i) - centre) / width).clamp(0.0, 1.0);
            let profile: Vec<f64> = (0..=100).map(ramp).collect();
            // The clamp bends the ramp within a step of its ends; the middle stays straight.
            let position = position_50(&profile)?;
            prop_assert!(position.is_some_and(|p| (p - centre).abs() < 1e-9), "{position:?}");
            if width >= 10.0 {
                let found = width_10_90(&profile)?;
                prop_assert!(found.is_some_and(|w| (w - 0.8 * width).abs() < 1e-9), "{found:?}");
            }
        }
    }
}
