//! One point on the way to an extreme, as `dapple stress` leaves it.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::error::RecordError;
use crate::fields::{Fields, Object};

/// `"kind": "stress"`: one technique at one value of one axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StressLine {
    /// The run's id.
    pub run: String,
    /// When it ended, RFC 3339 UTC.
    pub time: String,
    /// Which machine.
    pub machine: String,
    /// Graphics adapter; `cpu` for forms that use none.
    pub adapter: String,
    /// `hardware`, `software` or `cpu`.
    pub device: String,
    /// Source revision of the program.
    pub revision: String,
    /// Problem id.
    pub problem: String,
    /// Case the axis starts from.
    pub case: String,
    /// Technique id.
    pub technique: String,
    /// Variant id.
    pub variant: String,
    /// `cpu` or `gpu`.
    pub form: String,
    /// Settings. Keys `knob.NAME`.
    pub knobs: BTreeMap<String, Value>,
    /// Axis id, e.g. `scale`.
    pub axis: String,
    /// Unit of `value`, empty for a pure number.
    pub unit: String,
    /// Whether the axis is stepped in the logarithm.
    pub logarithmic: bool,
    /// Where on the axis: a number, or the position of a word.
    pub value: f64,
    /// The same for people, e.g. `1e-6` or `nan-vertex`.
    pub label: String,
    /// Found by bisection rather than on the grid.
    pub refined: bool,
    /// `safe`, `broken`, `refused` (a clear error: what bad input must get), `crashed`, or
    /// `not-run`.
    pub verdict: String,
    /// Whether a refusal is what the axis asks for at this value.
    pub must_refuse: bool,
    /// The criterion's metric.
    pub metric: String,
    /// Its value here, if the technique got that far.
    pub error: Option<f64>,
    /// The greatest value that counts as safe.
    pub limit: Option<f64>,
    /// Why, for people.
    pub reason: String,
    /// The command that shows this point again.
    pub command: String,
}

impl StressLine {
    /// Whether the technique did here what it must: a right result, or the refusal of bad input.
    pub fn is_safe(&self) -> bool {
        self.verdict == if self.must_refuse { "refused" } else { "safe" }
    }

    /// One JSON line, without its line feed.
    pub fn to_line(&self) -> String {
        let mut out = Object::new("stress");
        out.texts([
            ("run", &self.run),
            ("time", &self.time),
            ("machine", &self.machine),
            ("adapter", &self.adapter),
            ("device", &self.device),
            ("revision", &self.revision),
            ("problem", &self.problem),
            ("case", &self.case),
            ("technique", &self.technique),
            ("variant", &self.variant),
            ("form", &self.form),
        ]);
        for (name, value) in &self.knobs {
            out.put(format!("knob.{name}"), value.clone());
        }
        out.texts([("axis", &self.axis), ("unit", &self.unit)]);
        out.put("logarithmic", self.logarithmic);
        out.put("value", self.value);
        out.texts([("label", &self.label)]);
        out.put("refined", self.refined);
        out.texts([("verdict", &self.verdict)]);
        out.put("must_refuse", self.must_refuse);
        out.texts([("metric", &self.metric)]);
        out.maybe("error", self.error);
        out.maybe("limit", self.limit);
        out.texts([("reason", &self.reason), ("command", &self.command)]);
        out.to_line()
    }

    pub(crate) fn from_fields(f: &mut Fields) -> Result<Self, RecordError> {
        Ok(Self {
            run: f.required("run")?,
            time: f.text("time")?,
            machine: f.text("machine")?,
            adapter: f.text("adapter")?,
            device: f.text("device")?,
            revision: f.text("revision")?,
            problem: f.required("problem")?,
            case: f.required("case")?,
            technique: f.required("technique")?,
            variant: f.text("variant")?,
            form: f.required("form")?,
            knobs: f.values("knob."),
            axis: f.required("axis")?,
            unit: f.text("unit")?,
            logarithmic: f.flag("logarithmic")?,
            value: f.number("value")?.unwrap_or(f64::NAN),
            label: f.text("label")?,
            refined: f.flag("refined")?,
            verdict: f.required("verdict")?,
            must_refuse: f.flag("must_refuse")?,
            metric: f.text("metric")?,
            error: f.number("error")?,
            limit: f.number("limit")?,
            reason: f.text("reason")?,
            command: f.text("command")?,
        })
    }
}
