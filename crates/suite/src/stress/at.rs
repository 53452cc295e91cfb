//! One point of an axis, looked at closely.

use super::{
    Axis,
    child::{check, unprepared},
    judge::{Home, Judgement, judge},
    line::Points,
    search,
};
use crate::{
    SuiteError,
    case::Case,
    problem::{Checked, Form, Picture, Setting},
    run::child::device_names,
};
use dapple_gpu::Gpu;
use dapple_records::StressLine;

/// A point with what a record does not hold.
pub struct Shown {
    /// As a run would record it.
    pub line: StressLine,
    /// What is told of the case, each a sentence.
    pub notes: Vec<String>,
    /// Errors and violations, if the technique got that far.
    pub checked: Option<Checked>,
    /// Truth and result, where the output is a picture.
    pub picture: Option<Picture>,
}

/// Probes a setting at home, for the limit, and at `value`, in this process.
///
/// # Errors
/// A case that cannot be prepared at home, and a setting to which the axis means nothing.
pub fn show(
    points: &Points<'_>,
    setting: &Setting,
    value: f64,
    gpu: Option<&Gpu>,
) -> Result<Shown, SuiteError> {
    let Points { axis, case, .. } = *points;
    if (axis.setting)(setting, value).is_none() {
        let label = axis.values.label(value);
        let text = format!("{} = {label} means nothing to {setting}", axis.id);
        return Err(SuiteError::Usage(text));
    }
    let home = home(axis, case, setting, value, gpu)?;
    let gpu_of_form = gpu.filter(|_| setting.form == Form::Gpu);
    let (mut notes, mut picture) = (Vec::new(), None);
    let (judged, checked) = match (axis.prepare)(case, value, gpu) {
        Err(error) => (unprepared(&error), None),
        Ok(prepared) => {
            notes = prepared.facts().notes;
            let found =
                check(axis, prepared.as_ref(), setting, value, gpu_of_form, &mut |subject| {
                    picture = subject.picture()?;
                    Ok(())
                });
            (judge(&axis.criterion, &home, (axis.must_refuse)(value), &found), found.ok())
        }
    };
    let line = points.line(setting, value, &device_names(gpu_of_form), &judged);
    Ok(Shown { line, notes, checked, picture })
}

/// What the criterion refers to at `value`.
fn home(
    axis: &Axis,
    case: &Case,
    setting: &Setting,
    value: f64,
    gpu: Option<&Gpu>,
) -> Result<Home, SuiteError> {
    let Some(at) = search::at_home(axis.values, axis.home).filter(|at| *at != value) else {
        return Ok(Home::Here);
    };
    let prepared = (axis.prepare)(case, at, gpu)?;
    let gpu = gpu.filter(|_| setting.form == Form::Gpu);
    let found = check(axis, prepared.as_ref(), setting, at, gpu, &mut |_| Ok(()));
    let judged: Judgement = judge(&axis.criterion, &Home::Here, false, &found);
    Ok(match judged.error.filter(|_| judged.reason.is_empty()) {
        Some(error) => Home::Error(error),
        None => Home::Failed(judged.reason),
    })
}
