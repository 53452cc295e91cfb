//! Points as records hold them, with the command that shows each again.

use super::{
    Axis,
    judge::{Judgement, Verdict},
    search::is_logarithmic,
};
use crate::{
    case::Case,
    environment::environment,
    knob::Knobs,
    problem::{Setting, Spec},
    problems,
    shell::quoted,
};
use dapple_records::StressLine;
use serde_json::Value;

/// What the points of one axis share.
pub struct Points<'a> {
    /// Id of the run.
    pub run: &'a str,
    /// The axis.
    pub axis: &'a Axis,
    /// The case it starts from.
    pub case: &'a Case,
    /// Part of an adapter's name, as the user gave it.
    pub adapter: Option<&'a str>,
}

impl Points<'_> {
    /// One point's line. `device` is the adapter's name and kind.
    pub fn line(
        &self,
        setting: &Setting,
        value: f64,
        device: &(String, String),
        judged: &Judgement,
    ) -> StressLine {
        let facts = environment();
        let Axis { id, unit, values, criterion, must_refuse, .. } = self.axis;
        let pushed = (self.axis.setting)(setting, value);
        StressLine {
            run: self.run.into(),
            time: dapple_records::now(),
            machine: facts.machine.clone(),
            adapter: device.0.clone(),
            device: device.1.clone(),
            revision: facts.revision.clone(),
            problem: self.case.problem.clone(),
            case: self.case.name(),
            technique: setting.technique.clone(),
            variant: setting.variant.clone(),
            form: setting.form.to_string(),
            knobs: pushed.map_or_else(|| setting.knobs.clone(), |pushed| pushed.knobs),
            axis: (*id).into(),
            unit: (*unit).into(),
            logarithmic: is_logarithmic(*values),
            value,
            label: values.label(value),
            refined: !self.axis.grid().contains(&value),
            verdict: judged.verdict.word().into(),
            must_refuse: must_refuse(value),
            metric: criterion.metric.into(),
            error: judged.error,
            limit: judged.limit,
            reason: one_line(&judged.reason),
            command: self.command(setting, value),
        }
    }

    /// Shows a point again: `dapple stress PROBLEM --axis ... --at VALUE`.
    pub fn command(&self, setting: &Setting, value: f64) -> String {
        let technique = format!("{}/{}", setting.technique, setting.variant);
        let mut words: Vec<String> =
            ["dapple", "stress", &self.case.problem, "--axis", self.axis.id, "--technique"]
                .map(Into::into)
                .into();
        words.extend([technique, "--form".into(), setting.form.to_string()]);
        words.extend(["--at".into(), self.axis.values.label(value)]);
        let spec = problems::find(&self.case.problem).ok().map(|problem| problem.spec());
        words.extend(spec.map(|spec| case_flags(spec, self.axis, self.case)).unwrap_or_default());
        if let Some(adapter) = self.adapter {
            words.extend(["--adapter".into(), adapter.into()]);
        }
        words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
    }
}

/// What of the case is not as the axis would have it.
fn case_flags(spec: &Spec, axis: &Axis, case: &Case) -> Vec<String> {
    let mut flags = Vec::new();
    if case.scene != spec.default_scene {
        flags.extend(["--scene".into(), case.scene.clone()]);
    }
    if !case.view.is_empty() {
        flags.extend(["--view".into(), case.view.clone()]);
    }
    if case.seed != 0 {
        flags.extend(["--seed".into(), case.seed.to_string()]);
    }
    let usual: Knobs = axis.case_parameters(spec, &Knobs::new()).unwrap_or_default();
    for (name, value) in &case.parameters {
        if usual.get(name) != Some(value) {
            let text = match value {
                Value::String(text) => text.clone(),
                other => other.to_string(),
            };
            flags.extend(["--param".into(), format!("{name}={text}")]);
        }
    }
    flags
}

/// Reasons come from errors of every kind; a table has one line for each.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Whether a technique failed in a way that is its own fault and not a limit: it accepted what it
/// must refuse, or it crashed.
pub fn is_fault(line: &StressLine) -> bool {
    let accepted = [Verdict::Safe, Verdict::Broken].map(Verdict::word);
    line.verdict == Verdict::Crashed.word()
        || line.must_refuse && accepted.contains(&line.verdict.as_str())
}
