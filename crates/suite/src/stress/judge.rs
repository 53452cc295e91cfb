//! What a technique did at one point of an axis.

use super::Criterion;
use crate::{SuiteError, problem::Checked};
use dapple_gpu::GpuError;
use dapple_records::text::significant;

/// How a point ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// As good as the criterion asks.
    Safe,
    /// Wrong: an error beyond the limit or not finite, an invariant broken, or bad input accepted.
    Broken,
    /// A clear error in place of a result.
    Refused,
    /// The process died, hung, or met a fault of its own.
    Crashed,
    /// Nothing could be seen, for a reason outside the technique.
    NotRun,
}

impl Verdict {
    /// As in records.
    pub fn word(self) -> &'static str {
        match self {
            Self::Safe => "safe",
            Self::Broken => "broken",
            Self::Refused => "refused",
            Self::Crashed => "crashed",
            Self::NotRun => "not-run",
        }
    }
}

/// What the criterion refers to.
#[derive(Clone, Debug, PartialEq)]
pub enum Home {
    /// This point is home.
    Here,
    /// The error at home.
    Error(f64),
    /// There is none, and why.
    Failed(String),
}

/// A verdict with its figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Judgement {
    /// How it ended.
    pub verdict: Verdict,
    /// The criterion's metric, where there is one and it is finite.
    pub error: Option<f64>,
    /// The greatest error that counts as safe.
    pub limit: Option<f64>,
    /// Why, where it is not safe.
    pub reason: String,
}

impl Judgement {
    /// A verdict without figures.
    pub fn without(verdict: Verdict, reason: impl Into<String>) -> Self {
        Self { verdict, error: None, limit: None, reason: reason.into() }
    }
}

impl Criterion {
    /// The greatest error that counts as safe.
    pub fn limit(&self, home: f64) -> f64 {
        self.times * home + self.plus
    }
}

/// Judges what a check found.
pub fn judge(
    criterion: &Criterion,
    home: &Home,
    must_refuse: bool,
    found: &Result<Checked, SuiteError>,
) -> Judgement {
    match found {
        Ok(checked) => judge_result(criterion, home, must_refuse, checked),
        Err(error) => Judgement::without(verdict_of(error), error.to_string()),
    }
}

fn judge_result(
    criterion: &Criterion,
    home: &Home,
    must_refuse: bool,
    checked: &Checked,
) -> Judgement {
    let name = criterion.metric;
    let error = checked.errors.get(name).copied();
    let limit = match home {
        Home::Here => error.map(|error| criterion.limit(error)),
        Home::Error(error) => Some(criterion.limit(*error)),
        Home::Failed(_) => None,
    };
    let judged = |verdict, reason: String| Judgement {
        verdict,
        error: error.filter(|error| error.is_finite()),
        limit: limit.filter(|limit| limit.is_finite()),
        reason,
    };
    if must_refuse {
        let with = error.map_or(String::new(), |e| format!(" ({name} = {})", significant(e)));
        return judged(Verdict::Broken, format!("accepted: this input must be refused{with}"));
    }
    if let Some((metric, value)) = checked.errors.iter().find(|(_, value)| !value.is_finite()) {
        return judged(Verdict::Broken, format!("{metric} = {value} is not finite"));
    }
    if let Some(first) = checked.violations.first() {
        let more = match checked.violations.len() {
            1 => String::new(),
            n => format!(" (and {} more)", n - 1),
        };
        return judged(Verdict::Broken, format!("{first}{more}"));
    }
    match (error, limit, home) {
        (None, ..) => judged(Verdict::Broken, format!("the result has no {name}")),
        (_, _, Home::Failed(why)) => {
            judged(Verdict::Broken, format!("nothing at home to compare with: {why}"))
        }
        (Some(error), Some(limit), _) if error <= limit => judged(Verdict::Safe, String::new()),
        (Some(error), limit, _) => {
            let limit = limit.unwrap_or(f64::NAN);
            let (error, limit) = (significant(error), significant(limit));
            judged(Verdict::Broken, format!("{name} {error} exceeds {limit}"))
        }
    }
}

/// What an error in place of a result means.
pub fn verdict_of(error: &SuiteError) -> Verdict {
    if let Some(device) = error.device() {
        return match device {
            GpuError::TooLarge { .. } | GpuError::Missing { .. } | GpuError::OutOfMemory { .. } => {
                Verdict::Refused
            }
            GpuError::NoAdapter { .. } | GpuError::NotFound { .. } | GpuError::Unsound { .. } => {
                Verdict::NotRun
            }
            GpuError::Validation { .. } | GpuError::Map { .. } | GpuError::Shader(_) => {
                Verdict::Broken
            }
            GpuError::DeviceLost(_) | GpuError::Timeout { .. } => Verdict::Crashed,
        };
    }
    match error {
        // The metrics refuse a result that is not finite: the technique made it.
        SuiteError::Metric(_) => Verdict::Broken,
        SuiteError::Internal(_) => Verdict::Crashed,
        other if other.exit_code() == 2 => Verdict::Refused,
        _ => Verdict::NotRun,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_foliage::partition::PartitionError;

    const TWICE: Criterion = Criterion { metric: "rmse", times: 2.0, plus: 0.25 };

    fn found(error: f64, violations: &[&str]) -> Result<Checked, SuiteError> {
        Ok(Checked {
            errors: [("max".into(), 0.5), ("rmse".into(), error)].into(),
            violations: violations.iter().map(ToString::to_string).collect(),
            ..Checked::default()
        })
    }

    fn with(home: &Home, found: &Result<Checked, SuiteError>) -> (Verdict, String) {
        let judged = judge(&TWICE, home, false, found);
        (judged.verdict, judged.reason)
    }

    #[test]
    fn an_error_is_safe_up_to_its_limit_and_the_reason_names_both() {
        let home = Home::Error(0.125);
        let safe = judge(&TWICE, &home, false, &found(0.5, &[]));
        let expected = Judgement {
            verdict: Verdict::Safe,
            error: Some(0.5),
            limit: Some(0.5),
            reason: String::new(),
        };
        assert_eq!(safe, expected);
        let (verdict, reason) = with(&home, &found(0.51, &[]));
        assert_eq!((verdict, reason.as_str()), (Verdict::Broken, "rmse 0.5100 exceeds 0.5000"));
        assert_eq!(with(&Home::Here, &found(0.9, &[])).0, Verdict::Safe);
    }

    #[test]
    fn what_is_not_finite_or_violated_is_broken_even_at_home() {
        for home in [Home::Here, Home::Error(0.1)] {
            let (verdict, reason) = with(&home, &found(f64::NAN, &[]));
            assert_eq!((verdict, reason.as_str()), (Verdict::Broken, "rmse = NaN is not finite"));
            assert_eq!(with(&home, &found(f64::INFINITY, &[])).0, Verdict::Broken);
            let (verdict, reason) = with(&home, &found(0.0, &["v > 1", "v < 0"]));
            assert_eq!((verdict, reason.as_str()), (Verdict::Broken, "v > 1 (and 1 more)"));
        }
        let other = Ok(Checked::default());
        assert_eq!(with(&Home::Here, &other).1, "the result has no rmse");
        let judged = judge(&TWICE, &Home::Here, false, &found(f64::INFINITY, &[]));
        assert_eq!((judged.error, judged.limit), (None, None), "records hold no infinity");
    }

    #[test]
    fn without_an_error_at_home_nothing_is_safe_and_the_reason_says_so() {
        let home = Home::Failed("it overflowed".into());
        let (verdict, reason) = with(&home, &found(0.0, &[]));
        assert_eq!(verdict, Verdict::Broken);
        assert!(reason.contains("at home") && reason.contains("it overflowed"), "{reason}");
    }

    #[test]
    fn bad_input_that_is_accepted_is_broken_however_good_the_result() {
        let judged = judge(&TWICE, &Home::Error(0.1), true, &found(0.0, &[]));
        assert_eq!(judged.verdict, Verdict::Broken);
        assert!(judged.reason.contains("must be refused"));
        let refused = Err(SuiteError::Usage("vertex 3 is NaN".into()));
        let judged = judge(&TWICE, &Home::Error(0.1), true, &refused);
        assert_eq!((judged.verdict, judged.reason.as_str()), (Verdict::Refused, "vertex 3 is NaN"));
    }

    #[test]
    fn errors_are_told_apart_by_who_is_to_blame() {
        let of = |error: SuiteError| verdict_of(&error);
        assert_eq!(of(SuiteError::Usage("odd".into())), Verdict::Refused);
        assert_eq!(of(SuiteError::Internal("lost".into())), Verdict::Crashed);
        let io = std::io::Error::other("full");
        assert_eq!(of(SuiteError::io("disk")(io)), Verdict::NotRun);
        let too_large = || GpuError::TooLarge {
            what: "map".into(),
            asked: 9,
            limit: "max_buffer_size",
            max: 8,
        };
        assert_eq!(of(too_large().into()), Verdict::Refused);
        // A limit that a technique's own error wraps is the same limit.
        assert_eq!(of(PartitionError::from(too_large()).into()), Verdict::Refused);
        let lost = || GpuError::DeviceLost("gone".into());
        assert_eq!(of(PartitionError::from(lost()).into()), Verdict::Crashed);
        assert_eq!(of(GpuError::NoAdapter { hint: String::new() }.into()), Verdict::NotRun);
        let metric = dapple_metrics::rmse(&[f32::NAN], &[0.0], None).unwrap_err();
        assert_eq!(of(metric.into()), Verdict::Broken);
    }
}
