//! One correctness gate's outcome, as `dapple verify` leaves it.

use crate::error::RecordError;
use crate::fields::{Fields, Object};

/// `"kind": "gate"`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GateLine {
    /// The run's id.
    pub run: String,
    /// When it ended, RFC 3339 UTC.
    pub time: String,
    /// Which machine.
    pub machine: String,
    /// Graphics adapter at hand; `none` without one.
    pub adapter: String,
    /// Source revision of the program.
    pub revision: String,
    /// Problem id.
    pub problem: String,
    /// Technique id, or `-` for what all share.
    pub technique: String,
    /// The gate's name.
    pub gate: String,
    /// What holds, one sentence.
    pub statement: String,
    /// `passed`, `failed`, `control-missed`, `nothing-checked`, `error` or `not-run`.
    pub outcome: String,
    /// Things checked.
    pub checked: u64,
    /// Things that failed.
    pub failed: u64,
    /// The deviation nearest to its bound.
    pub worst: Option<f64>,
    /// That bound.
    pub bound: Option<f64>,
    /// The negative control's deliberate fault.
    pub fault: String,
    /// What went wrong, in words.
    pub detail: String,
}

impl GateLine {
    /// Whether the gate lets a build pass.
    pub fn is_ok(&self) -> bool {
        matches!(self.outcome.as_str(), "passed" | "not-run")
    }

    /// One JSON line, without its line feed.
    pub fn to_line(&self) -> String {
        let mut out = Object::new("gate");
        out.texts([
            ("run", &self.run),
            ("time", &self.time),
            ("machine", &self.machine),
            ("adapter", &self.adapter),
            ("revision", &self.revision),
            ("problem", &self.problem),
            ("technique", &self.technique),
            ("gate", &self.gate),
            ("statement", &self.statement),
            ("outcome", &self.outcome),
        ]);
        out.put("checked", self.checked);
        out.put("failed", self.failed);
        out.maybe("worst", self.worst);
        out.maybe("bound", self.bound);
        out.texts([("fault", &self.fault), ("detail", &self.detail)]);
        out.to_line()
    }

    pub(crate) fn from_fields(f: &mut Fields) -> Result<Self, RecordError> {
        Ok(Self {
            run: f.required("run")?,
            time: f.text("time")?,
            machine: f.text("machine")?,
            adapter: f.text("adapter")?,
            revision: f.text("revision")?,
            problem: f.required("problem")?,
            technique: f.required("technique")?,
            gate: f.required("gate")?,
            statement: f.text("statement")?,
            outcome: f.required("outcome")?,
            checked: f.count("checked")?,
            failed: f.count("failed")?,
            worst: f.number("worst")?,
            bound: f.number("bound")?,
            fault: f.text("fault")?,
            detail: f.text("detail")?,
        })
    }
}
