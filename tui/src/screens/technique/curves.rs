//! Error and time against one knob: the recorded rows that differ in that knob only.

use super::{State, told};
use crate::plot::curve::Step;
use dapple_records::{Row, Value, catalogue::KnobInfo};
use std::cmp::Ordering;

impl State {
    /// The rows that differ from the selected one in `knob` only, itself among them, in the order
    /// of the knob's values.
    fn along(&self, knob: &KnobInfo) -> Vec<(&Row, bool)> {
        let Some(base) = self.row() else { return Vec::new() };
        let same = |row: &Row| {
            let others = |row: &Row| {
                let mut knobs = row.knobs.clone();
                knobs.remove(&knob.name);
                knobs
            };
            row.knobs.contains_key(&knob.name) && others(row) == others(base)
        };
        let mut rows: Vec<&Row> = self.rows.values().filter(|row| same(row)).collect();
        rows.sort_by(|a, b| {
            order(&a.knobs[&knob.name], &b.knobs[&knob.name], &knob.steps).then(a.row.cmp(&b.row))
        });
        rows.into_iter().map(|row| (row, row.row == base.row)).collect()
    }

    /// Error and median time against `knob`.
    pub(super) fn curves(&self, knob: &KnobInfo, metric: &str) -> [Vec<Step>; 2] {
        let step = |(row, current): &(&Row, bool), value: Option<f64>| Step {
            label: row.knobs.get(&knob.name).map(told).unwrap_or_default(),
            value: value.unwrap_or(f64::NAN),
            current: *current,
        };
        let rows = self.along(knob);
        let errors = rows.iter().map(|r| step(r, r.0.errors.get(metric).copied()));
        let times = rows.iter().map(|r| step(r, r.0.median_ns()));
        [errors.collect(), times.collect()]
    }
}

/// Numbers by size; else as declared; else by their text.
fn order(a: &Value, b: &Value, steps: &[Value]) -> Ordering {
    if let (Some(a), Some(b)) = (a.as_f64(), b.as_f64()) {
        return a.total_cmp(&b);
    }
    let at = |value: &Value| steps.iter().position(|s| s == value).unwrap_or(usize::MAX);
    at(a).cmp(&at(b)).then_with(|| told(a).cmp(&told(b)))
}
