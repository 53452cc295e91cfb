//! The correctness gate: every gate has a negative control, and checking nothing is a failure.

mod draw;

pub use draw::{anywhere, default_setting, rng};

use crate::{SuiteError, problem::Problem};
use dapple_gpu::Gpu;
use serde::Serialize;

/// What a gate may use.
pub struct GateContext<'a> {
    /// The graphics device, where there is one.
    pub gpu: Option<&'a Gpu>,
    /// Random cases per property.
    pub cases: u32,
    /// Seed of all random input.
    pub seed: u64,
    /// Whether gates that look for rare failures look a hundred times as long.
    pub deep: bool,
}

/// What one run of a gate saw.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Things checked.
    pub checked: u64,
    /// Things that broke the bound; the first few in words.
    pub failed: u64,
    /// The first failures, in words.
    pub failures: Vec<String>,
    /// The deviation nearest to its bound, or furthest beyond, and that bound.
    pub worst: Option<(f64, f64)>,
}

impl Tally {
    /// Counts one check; `describe` is called for a failure.
    pub fn check(&mut self, holds: bool, describe: impl FnOnce() -> String) {
        self.checked += 1;
        if !holds {
            self.failed += 1;
            if self.failures.len() < 3 {
                self.failures.push(describe());
            }
        }
    }

    /// Counts one check of `deviation <= bound` (NaN fails) and keeps the worst.
    pub fn within(&mut self, deviation: f64, bound: f64, describe: impl FnOnce() -> String) {
        if self.worst.is_none_or(|(w, b)| deviation - bound > w - b) {
            self.worst = Some((deviation, bound));
        }
        self.check(deviation <= bound, || {
            format!("{}: {deviation:.3e} exceeds {bound:.3e}", describe())
        });
    }
}

/// Runs a gate, honest or with its deliberate fault.
pub type Run = Box<dyn Fn(&GateContext<'_>) -> Result<Tally, SuiteError> + Send + Sync>;

/// A check of one property of one technique, with a deliberate fault that it must catch.
pub struct Gate {
    /// Technique id, or `-` for what all share.
    pub technique: String,
    /// Short name, e.g. `P7.2 bound`.
    pub name: String,
    /// What holds, one sentence.
    pub statement: &'static str,
    /// Whether it needs a graphics adapter.
    pub needs_gpu: bool,
    /// The check.
    pub run: Run,
    /// What the deliberate fault is.
    pub fault: &'static str,
    /// The same check on the faulty form: must fail.
    pub control: Run,
}

/// What a gate says about itself.
pub struct About {
    /// Technique id, or `-` for what all share.
    pub technique: &'static str,
    /// Short name.
    pub name: &'static str,
    /// What holds, one sentence.
    pub statement: &'static str,
    /// What the deliberate fault is.
    pub fault: &'static str,
}

/// A gate from one check that can be run with its fault.
pub fn gate(
    about: About,
    check: impl Fn(&GateContext<'_>, bool) -> Result<Tally, SuiteError> + Copy + Send + Sync + 'static,
) -> Gate {
    Gate {
        technique: about.technique.into(),
        name: about.name.into(),
        statement: about.statement,
        needs_gpu: false,
        run: Box::new(move |context| check(context, false)),
        fault: about.fault,
        control: Box::new(move |context| check(context, true)),
    }
}

/// How a gate ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// Held, and the control was caught.
    Passed,
    /// Something broke the bound.
    Failed,
    /// The deliberate fault was not caught.
    ControlMissed,
    /// Nothing was checked.
    NothingChecked,
    /// The gate itself could not run.
    Error,
    /// Needs a graphics adapter and there is none.
    NotRun,
}

impl Outcome {
    /// As in records.
    pub fn word(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::Failed => "failed",
            Self::ControlMissed => "control-missed",
            Self::NothingChecked => "nothing-checked",
            Self::Error => "error",
            Self::NotRun => "not-run",
        }
    }
}

/// One line of `verify`'s report.
#[derive(Clone, Debug, Serialize)]
pub struct GateReport {
    /// Problem id.
    pub problem: &'static str,
    /// Technique id.
    pub technique: String,
    /// Gate name.
    pub gate: String,
    /// What holds.
    pub statement: &'static str,
    /// How it ended.
    pub outcome: Outcome,
    /// Things checked.
    pub checked: u64,
    /// Things that failed.
    pub failed: u64,
    /// Largest deviation.
    pub worst: Option<f64>,
    /// Its bound.
    pub bound: Option<f64>,
    /// The control's fault.
    pub fault: &'static str,
    /// Failures that the control produced (must be at least 1).
    pub control_failed: u64,
    /// What went wrong, in words.
    pub detail: String,
}

impl GateReport {
    /// Whether the gate lets a build pass.
    pub fn is_ok(&self) -> bool {
        matches!(self.outcome, Outcome::Passed | Outcome::NotRun)
    }
}

/// Runs one gate and its control.
pub fn run_gate(problem: &'static str, gate: &Gate, context: &GateContext<'_>) -> GateReport {
    let mut report = GateReport {
        problem,
        technique: gate.technique.clone(),
        gate: gate.name.clone(),
        statement: gate.statement,
        outcome: Outcome::NotRun,
        checked: 0,
        failed: 0,
        worst: None,
        bound: None,
        fault: gate.fault,
        control_failed: 0,
        detail: String::new(),
    };
    if gate.needs_gpu && context.gpu.is_none() {
        report.detail = "no adapter".into();
        return report;
    }
    let tally = match (gate.run)(context) {
        Ok(tally) => tally,
        Err(error) => {
            report.outcome = Outcome::Error;
            report.detail = error.to_string();
            return report;
        }
    };
    report.checked = tally.checked;
    report.failed = tally.failed;
    report.worst = tally.worst.map(|w| w.0);
    report.bound = tally.worst.map(|w| w.1);
    report.detail = tally.failures.join("; ");
    if tally.failed > 0 {
        report.outcome = Outcome::Failed;
        return report;
    }
    if tally.checked == 0 {
        report.outcome = Outcome::NothingChecked;
        return report;
    }
    report.outcome = match (gate.control)(context) {
        // A fault that makes the form refuse its input is caught as well; a lost device or a full
        // disk has caught nothing.
        Err(error) if error.exit_code() == 3 => {
            report.detail = format!("control: {error}");
            Outcome::Error
        }
        Err(error) => {
            report.control_failed = 1;
            report.detail = format!("control refused: {error}");
            Outcome::Passed
        }
        Ok(control) => {
            report.control_failed = control.failed;
            if control.failed > 0 { Outcome::Passed } else { Outcome::ControlMissed }
        }
    };
    report
}

/// What [`run`] tells as it goes.
pub enum Step<'a> {
    /// How many gates there will be.
    Planned(usize),
    /// A gate begins.
    Begun(&'a Gate),
    /// It ended.
    Ended(&'a GateReport),
}

/// Runs every gate of the given problems, or those of one technique.
pub fn run(
    problems: &[&'static dyn Problem],
    technique: Option<&str>,
    context: &GateContext<'_>,
    mut seen: impl FnMut(Step<'_>),
) -> Vec<GateReport> {
    let mut gates: Vec<(&'static str, Gate)> = Vec::new();
    for problem in problems {
        gates.extend(problem.gates().into_iter().map(|gate| (problem.spec().id, gate)));
    }
    gates.retain(|(_, gate)| technique.is_none_or(|t| gate.technique == t));
    seen(Step::Planned(gates.len()));
    let mut reports = Vec::new();
    for (problem, gate) in &gates {
        seen(Step::Begun(gate));
        let report = run_gate(problem, gate, context);
        seen(Step::Ended(&report));
        reports.push(report);
    }
    reports
}

/// Techniques of `problem` that no gate names: each is a hole in the net.
pub fn ungated(problem: &dyn Problem, reports: &[GateReport]) -> Vec<&'static str> {
    let spec = problem.spec();
    let checked = |id: &str| {
        reports.iter().any(|r| r.problem == spec.id && r.technique == id && r.checked > 0)
    };
    spec.techniques.iter().map(|t| t.id).filter(|id| !checked(id)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gate(run: fn() -> Tally, control: fn() -> Tally) -> Gate {
        Gate {
            technique: "t".into(),
            name: "g".into(),
            statement: "s",
            needs_gpu: false,
            run: Box::new(move |_| Ok(run())),
            fault: "f",
            control: Box::new(move |_| Ok(control())),
        }
    }

    fn tally(deviations: &[f64]) -> Tally {
        let mut tally = Tally::default();
        for d in deviations {
            tally.within(*d, 1.0, || "d".into());
        }
        tally
    }

    fn outcome(run: fn() -> Tally, control: fn() -> Tally) -> Outcome {
        let context = GateContext { gpu: None, cases: 1, seed: 0, deep: false };
        run_gate("p", &gate(run, control), &context).outcome
    }

    #[test]
    fn a_gate_passes_only_if_it_checked_something_and_its_control_fails() {
        assert_eq!(outcome(|| tally(&[0.5]), || tally(&[2.0])), Outcome::Passed);
        assert_eq!(outcome(|| tally(&[2.0]), || tally(&[2.0])), Outcome::Failed);
        assert_eq!(outcome(|| tally(&[]), || tally(&[2.0])), Outcome::NothingChecked);
        assert_eq!(outcome(|| tally(&[0.5]), || tally(&[0.5])), Outcome::ControlMissed);
        assert_eq!(outcome(|| tally(&[0.5]), || tally(&[])), Outcome::ControlMissed);
    }

    #[test]
    fn a_control_is_caught_by_a_refusal_and_not_by_a_broken_environment() {
        let context = GateContext { gpu: None, cases: 1, seed: 0, deep: false };
        let with = |control: fn() -> SuiteError| {
            let honest = gate(|| tally(&[0.5]), || tally(&[]));
            let gate = Gate { control: Box::new(move |_| Err(control())), ..honest };
            run_gate("p", &gate, &context).outcome
        };
        assert_eq!(with(|| SuiteError::Usage("refused".into())), Outcome::Passed);
        let disk = || SuiteError::io("disk")(std::io::Error::other("full"));
        assert_eq!(with(disk), Outcome::Error);
    }

    #[test]
    fn the_worst_deviation_stands_beside_its_own_bound() {
        let mut tally = Tally::default();
        tally.within(0.9, 1.0, || "near".into());
        tally.within(5.0, 100.0, || "far".into());
        assert_eq!(tally.worst, Some((0.9, 1.0)));
    }

    #[test]
    fn nan_never_passes() {
        assert_eq!(outcome(|| tally(&[f64::NAN]), || tally(&[2.0])), Outcome::Failed);
    }
}
