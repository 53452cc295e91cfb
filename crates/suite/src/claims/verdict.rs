//! What judges share: votes, the threshold for light that is seen, two codes timed in turn.

pub use super::figure;
use super::{Figure, Judged, Verdict};
use crate::SuiteError;
use dapple_metrics::stats::{self, Ratio};

/// One grey level of an 8-bit image. A mean error below it vanishes when the picture is stored;
/// a mean leak above it brightens the whole of a full shadow by at least one level.
pub const GREY_LEVEL: f64 = 1.0 / 255.0;

/// A judgement.
pub fn judged(verdict: Verdict, because: impl Into<String>, figures: Vec<Figure>) -> Judged {
    Judged { verdict, because: because.into(), figures }
}

/// For a general statement seen in several cases: reproduced if it holds in all, refuted if in
/// none, open if in some or if there is no case.
pub fn vote(holds: &[bool]) -> Verdict {
    match holds.iter().filter(|h| **h).count() {
        0 if holds.is_empty() => Verdict::Open,
        0 => Verdict::Refuted,
        n if n == holds.len() => Verdict::Reproduced,
        _ => Verdict::Open,
    }
}

/// The same where a case may also leave it open (`None`): refuted only if every case contradicts.
pub fn vote_open(cases: &[Option<bool>]) -> Verdict {
    let decided: Vec<bool> = cases.iter().copied().flatten().collect();
    if decided.len() == cases.len() { vote(&decided) } else { Verdict::Open }
}

/// How many cases hold, in words.
pub fn count(holds: &[bool]) -> String {
    format!("{} of {}", holds.iter().filter(|h| **h).count(), holds.len())
}

/// A statement of several parts: refuted if any part is, reproduced if all are, else the first
/// part that is not reproduced speaks.
pub fn all_of(parts: &[Verdict]) -> Verdict {
    if parts.contains(&Verdict::Refuted) {
        return Verdict::Refuted;
    }
    let undecided = parts.iter().copied().find(|v| *v != Verdict::Reproduced);
    undecided.unwrap_or(if parts.is_empty() { Verdict::Open } else { Verdict::Reproduced })
}

/// Reproduced if every value lies within its tolerance of what was predicted: triples of
/// measured, predicted, tolerance.
pub fn near(values: &[(f64, f64, f64)]) -> Verdict {
    if values.is_empty() {
        return Verdict::Open;
    }
    // Written so that a NaN is refused.
    let close = values.iter().all(|(got, expected, slack)| (got - expected).abs() <= *slack);
    if close { Verdict::Reproduced } else { Verdict::Refuted }
}

/// Power of x that y grows as: slope of a straight line through logarithms of pairs (x, y), all above
/// 0; not a number where x does not differ.
pub fn exponent(points: &[(f64, f64)]) -> f64 {
    let count = points.len() as f64;
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let mean_x = logs.iter().map(|p| p.0).sum::<f64>() / count;
    let mean_y = logs.iter().map(|p| p.1).sum::<f64>() / count;
    let over = logs.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum::<f64>();
    over / logs.iter().map(|(x, _)| (x - mean_x).powi(2)).sum::<f64>()
}

/// Runs both `pairs` times in turn, after one run of each that is thrown away: caches and clocks
/// drift, and what is measured side by side drifts together.
///
/// # Errors
/// Those of the two, or no pair.
pub fn paired(
    pairs: usize,
    mut a: impl FnMut() -> Result<f64, SuiteError>,
    mut b: impl FnMut() -> Result<f64, SuiteError>,
) -> Result<Ratio, SuiteError> {
    a()?;
    b()?;
    let (mut first, mut second) = (Vec::new(), Vec::new());
    for _ in 0..pairs {
        first.push(a()?);
        second.push(b()?);
    }
    Ok(stats::paired_ratio(&first, &second)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{NeedsHardware, Open, Refuted, Reproduced};

    #[test]
    fn votes_give_each_verdict() {
        assert_eq!(vote(&[true, true]), Reproduced);
        assert_eq!(vote(&[false, false]), Refuted);
        assert_eq!(vote(&[true, false]), Open);
        assert_eq!(vote(&[]), Open);
        assert_eq!(count(&[true, false, true]), "2 of 3");
        assert_eq!(vote_open(&[Some(true), Some(true)]), Reproduced);
        assert_eq!(vote_open(&[Some(false), Some(false)]), Refuted);
        assert_eq!(vote_open(&[Some(true), None]), Open);
        assert_eq!(vote_open(&[Some(false), None]), Open);
    }

    #[test]
    fn a_refuted_part_outweighs_the_others() {
        assert_eq!(all_of(&[Reproduced, NeedsHardware]), NeedsHardware);
        assert_eq!(all_of(&[Reproduced, Open, Refuted]), Refuted);
        assert_eq!(all_of(&[Open, NeedsHardware]), Open);
        assert_eq!(all_of(&[Reproduced]), Reproduced);
        assert_eq!(all_of(&[]), Open);
    }

    #[test]
    fn predictions_are_met_or_not() {
        assert_eq!(near(&[(0.3125, 0.313, 1e-3)]), Reproduced);
        assert_eq!(near(&[(0.3125, 0.313, 1e-3), (0.31, 0.313, 1e-3)]), Refuted);
        assert_eq!(near(&[(f64::NAN, 0.313, 1e-3)]), Refuted);
        assert_eq!(near(&[]), Open);
    }

    #[test]
    fn exponents_are_those_of_powers() {
        let of = |power: f64| [1.0_f64, 2.0, 7.0].map(|x| (x, 3.0 * x.powf(power)));
        assert!((exponent(&of(0.5)) - 0.5).abs() < 1e-12);
        assert!((exponent(&of(-2.0)) + 2.0).abs() < 1e-12);
        assert!(exponent(&[(2.0, 1.0), (2.0, 3.0)]).is_nan());
    }

    #[test]
    fn pairs_alternate_and_drift_cancels() {
        // The clock slows down: every run takes longer than the one before.
        let clock = std::cell::Cell::new(100.0_f64);
        let tick = |work: f64| {
            clock.set(clock.get() * 1.01);
            Ok(work * clock.get())
        };
        let ratio = paired(21, || tick(3.0), || tick(1.0)).unwrap();
        assert!((ratio.median - 3.0 / 1.01).abs() < 1e-9, "{ratio:?}");
        assert!(paired(0, || Ok(1.0), || Ok(1.0)).is_err());
    }
}
