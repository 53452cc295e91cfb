//! Hypotheses of the sources, each with the code that judges it.

pub(crate) mod verdict;

use crate::{SuiteError, problem::Problem};
use dapple_gpu::Gpu;
use serde::Serialize;
use std::fmt;

/// What a claim's judge may use.
pub struct ClaimContext<'a> {
    /// The graphics device, where there is one.
    pub gpu: Option<&'a Gpu>,
    /// Whether that device is hardware: claims about speed are judged on hardware only.
    pub hardware: bool,
}

/// How a hypothesis fared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The figures agree with the statement.
    Reproduced,
    /// The figures contradict it.
    Refuted,
    /// The figures do not decide.
    Open,
    /// It is about the speed of hardware that is not at hand.
    NeedsHardware,
}

impl Verdict {
    /// As in records.
    pub fn word(self) -> &'static str {
        match self {
            Self::Reproduced => "reproduced",
            Self::Refuted => "refuted",
            Self::Open => "open",
            Self::NeedsHardware => "needs-hardware",
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.word().replace('-', " "))
    }
}

/// One figure behind a verdict.
#[derive(Clone, Debug, Serialize)]
pub struct Figure {
    /// What was measured, with scene and setting.
    pub what: String,
    /// Its value.
    pub value: f64,
    /// Unit, empty for a pure number.
    pub unit: &'static str,
}

/// A figure.
pub fn figure(what: impl Into<String>, value: f64, unit: &'static str) -> Figure {
    Figure { what: what.into(), value, unit }
}

/// A verdict with its figures.
#[derive(Clone, Debug)]
pub struct Judged {
    /// The verdict, computed from the figures.
    pub verdict: Verdict,
    /// The figures.
    pub figures: Vec<Figure>,
    /// One sentence: why this verdict.
    pub because: String,
}

/// The code that judges a claim.
pub type Judge = Box<dyn Fn(&ClaimContext<'_>) -> Result<Judged, SuiteError> + Send + Sync>;

/// A hypothesis of a source.
pub struct Claim {
    /// Id, e.g. `gumbau-H7.3`.
    pub id: &'static str,
    /// The statement in our words.
    pub statement: &'static str,
    /// Where it stands in the source.
    pub place: &'static str,
    /// How it is judged here, with the threshold.
    pub method: &'static str,
    /// The judge.
    pub judge: Judge,
}

/// One line of `claims`' report.
#[derive(Clone, Debug, Serialize)]
pub struct ClaimReport {
    /// Problem id.
    pub problem: &'static str,
    /// Claim id.
    pub id: &'static str,
    /// The statement.
    pub statement: &'static str,
    /// Where it stands.
    pub place: &'static str,
    /// How it is judged.
    pub method: &'static str,
    /// The verdict; `None` if the judge could not run.
    pub verdict: Option<Verdict>,
    /// Why, or what went wrong.
    pub because: String,
    /// The figures.
    pub figures: Vec<Figure>,
}

/// What [`run`] tells as it goes.
pub enum Step<'a> {
    /// How many claims there will be.
    Planned(usize),
    /// A claim is about to be judged.
    Begun(&'a Claim),
    /// It was.
    Ended(&'a ClaimReport),
}

/// Judges the claims of the given problems, or the one of that id.
pub fn run(
    problems: &[&'static dyn Problem],
    only: Option<&str>,
    context: &ClaimContext<'_>,
    mut seen: impl FnMut(Step<'_>),
) -> Vec<ClaimReport> {
    let mut claims: Vec<(&'static str, Claim)> = Vec::new();
    for problem in problems {
        claims.extend(problem.claims().into_iter().map(|claim| (problem.spec().id, claim)));
    }
    claims.retain(|(_, claim)| only.is_none_or(|id| id == claim.id));
    seen(Step::Planned(claims.len()));
    let mut reports = Vec::new();
    for (problem, claim) in &claims {
        seen(Step::Begun(claim));
        let (verdict, because, figures) = match (claim.judge)(context) {
            Ok(judged) => (Some(judged.verdict), judged.because, judged.figures),
            Err(error) => (None, error.to_string(), Vec::new()),
        };
        let report = ClaimReport {
            problem,
            id: claim.id,
            statement: claim.statement,
            place: claim.place,
            method: claim.method,
            verdict,
            because,
            figures,
        };
        seen(Step::Ended(&report));
        reports.push(report);
    }
    reports
}
