//! One axis in one process: every value is prepared once for all techniques that want it.

use super::{
    Axis, find_axis,
    judge::{Home, Judgement, Verdict, judge, verdict_of},
    line::Points,
    search::{self, Known},
};
use crate::{
    SuiteError,
    case::Case,
    problem::{Checked, Form, Prepared, Setting, Subject},
    problems,
    run::{
        child::{Adapter, device_names, is_device_gone, open},
        protocol::{Event, Fault},
    },
};
use dapple_gpu::Gpu;
use dapple_records::StressLine;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// One axis for one process.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct AxisJob {
    /// Id of the run, for its lines.
    pub run: String,
    /// Axis id.
    pub axis: String,
    /// The case it starts from.
    pub case: Case,
    /// Settings to push.
    pub settings: Vec<Setting>,
    /// What is known already.
    pub done: Vec<Done>,
    /// Bisection steps at each end.
    pub refine: u32,
    /// Part of an adapter's name, or none for the best one.
    pub adapter: Option<String>,
    /// A deliberate fault, for tests.
    pub fault: Option<Fault>,
}

/// A point that is finished.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Done {
    /// Position of the setting in the job.
    pub setting: usize,
    /// Where.
    pub value: f64,
    /// Whether the technique did what it must; none where that could not be seen.
    pub safe: Option<bool>,
    /// The criterion's metric.
    pub error: Option<f64>,
    /// Why not.
    pub reason: String,
}

impl Done {
    /// What a recorded point says of a setting.
    pub fn of(setting: usize, line: &StressLine) -> Self {
        let seen = line.verdict != Verdict::NotRun.word();
        Self {
            setting,
            value: line.value,
            safe: seen.then(|| line.is_safe()),
            error: line.error,
            reason: line.reason.clone(),
        }
    }
}

impl AxisJob {
    /// What is known of a setting.
    pub fn known(&self, setting: usize) -> Vec<Known> {
        let of_setting = self.done.iter().filter(|done| done.setting == setting);
        of_setting.map(|done| Known { value: done.value, safe: done.safe }).collect()
    }

    /// Values that a setting is to be probed at next. Those that mean nothing to it are passed
    /// over, and known as such from now on.
    pub fn wanted(&mut self, axis: &Axis, setting: usize) -> Vec<f64> {
        loop {
            let known = self.known(setting);
            let wanted = search::wanted(axis.values, axis.home, &known, self.refine);
            let (means, nothing): (Vec<f64>, Vec<f64>) = wanted
                .into_iter()
                .partition(|value| (axis.setting)(&self.settings[setting], *value).is_some());
            if nothing.is_empty() {
                return means;
            }
            self.done.extend(nothing.into_iter().map(|value| Done {
                setting,
                value,
                safe: None,
                error: None,
                reason: "the axis means nothing to it".into(),
            }));
        }
    }

    /// The value that most settings want next, with those settings; none when all is known.
    /// Of equals the first setting's first: home, then the grid in order.
    pub fn next(&mut self, axis: &Axis) -> Option<(f64, Vec<usize>)> {
        let mut order: Vec<f64> = Vec::new();
        let mut wanting: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
        for setting in 0..self.settings.len() {
            for value in self.wanted(axis, setting) {
                let settings = wanting.entry(value.to_bits()).or_default();
                if settings.is_empty() {
                    order.push(value);
                }
                settings.push(setting);
            }
        }
        let most = wanting.values().map(Vec::len).max()?;
        let value = order.into_iter().find(|value| wanting[&value.to_bits()].len() == most)?;
        Some((value, wanting.remove(&value.to_bits()).unwrap_or_default()))
    }

    /// What the criterion refers to at `value` of a setting.
    pub fn home(&self, axis: &Axis, setting: usize, value: f64) -> Home {
        let Some(home) = search::at_home(axis.values, axis.home).filter(|home| *home != value)
        else {
            return Home::Here;
        };
        match self.done.iter().find(|done| done.setting == setting && done.value == home) {
            Some(Done { safe: Some(true), error: Some(error), .. }) => Home::Error(*error),
            Some(done) => Home::Failed(done.reason.clone()),
            None => Home::Failed("it was not probed".into()),
        }
    }
}

/// Runs a job and emits its events.
pub fn run(job: &AxisJob, emit: &mut dyn FnMut(Event)) {
    let mut job = job.clone();
    let outcome = find(&job).and_then(|axis| match open(&job.settings, job.adapter.as_ref())? {
        Adapter::NotNeeded => probe_all(&mut job, &axis, None, emit),
        Adapter::Open(gpu) => probe_all(&mut job, &axis, Some(&gpu), emit),
        Adapter::Missing(reason) => {
            not_run(&mut job, &axis, &reason, emit);
            probe_all(&mut job, &axis, None, emit)
        }
    });
    match outcome {
        Ok(()) => emit(Event::Done),
        Err(error) => {
            emit(Event::Failed { reason: error.to_string(), code: error.exit_code() });
        }
    }
}

fn find(job: &AxisJob) -> Result<Axis, SuiteError> {
    find_axis(problems::find(&job.case.problem)?, &job.axis)
}

/// Without an adapter, the grid of each gpu form is there and says so.
fn not_run(job: &mut AxisJob, axis: &Axis, reason: &str, emit: &mut dyn FnMut(Event)) {
    let device = ("none".to_string(), "none".to_string());
    let judged = Judgement::without(Verdict::NotRun, reason);
    for setting in 0..job.settings.len() {
        if job.settings[setting].form != Form::Gpu {
            continue;
        }
        while let Some(value) = job.wanted(axis, setting).first().copied() {
            finish(job, axis, setting, value, &device, &judged, emit);
        }
    }
}

/// Probes until nothing is wanted.
///
/// # Errors
/// A case that cannot be prepared at home, or a device that is gone.
pub fn probe_all(
    job: &mut AxisJob,
    axis: &Axis,
    gpu: Option<&Gpu>,
    emit: &mut dyn FnMut(Event),
) -> Result<(), SuiteError> {
    while let Some((value, settings)) = job.next(axis) {
        probe(job, axis, value, &settings, gpu, emit)?;
    }
    Ok(())
}

/// Probes the settings at one value.
fn probe(
    job: &mut AxisJob,
    axis: &Axis,
    value: f64,
    settings: &[usize],
    gpu: Option<&Gpu>,
    emit: &mut dyn FnMut(Event),
) -> Result<(), SuiteError> {
    let at = Some(value);
    emit(Event::Begin { setting: usize::MAX, stage: "prepare".into(), value: at });
    let prepared = match (axis.prepare)(&job.case, value, gpu) {
        Err(error) if search::at_home(axis.values, axis.home) == at || is_device_gone(&error) => {
            return Err(error);
        }
        prepared => prepared,
    };
    for &setting in settings {
        emit(Event::Begin { setting, stage: "check".into(), value: at });
        let chosen = &job.settings[setting];
        if let Some(fault) = &job.fault {
            fault.commit(&chosen.technique, at);
        }
        let gpu = gpu.filter(|_| chosen.form == Form::Gpu);
        let judged = match &prepared {
            Err(error) => unprepared(error),
            Ok(prepared) => {
                let found = check(axis, prepared.as_ref(), chosen, value, gpu, &mut |_| Ok(()));
                // A lost device is of no use to those that follow: the process ends here.
                if let Err(error) = &found
                    && is_device_gone(error)
                {
                    return Err(SuiteError::Internal(error.to_string()));
                }
                let home = job.home(axis, setting, value);
                judge(&axis.criterion, &home, (axis.must_refuse)(value), &found)
            }
        };
        finish(job, axis, setting, value, &device_names(gpu), &judged, emit);
    }
    Ok(())
}

/// A case that there is not at this value. Whatever its error, no technique has broken.
pub(super) fn unprepared(error: &SuiteError) -> Judgement {
    let verdict = match verdict_of(error) {
        Verdict::Broken => Verdict::Refused,
        verdict => verdict,
    };
    Judgement::without(verdict, error.to_string())
}

/// Makes the subject and checks it; `after` sees it then. What the device has to say of it belongs
/// to it.
pub(super) fn check(
    axis: &Axis,
    prepared: &dyn Prepared,
    setting: &Setting,
    value: f64,
    gpu: Option<&Gpu>,
    after: &mut dyn FnMut(&mut dyn Subject) -> Result<(), SuiteError>,
) -> Result<Checked, SuiteError> {
    let Some(pushed) = (axis.setting)(setting, value) else {
        return Err(SuiteError::Internal(format!("{setting} is not on the axis {}", axis.id)));
    };
    let checked = prepared.subject(&pushed).and_then(|mut subject| {
        let checked = subject.check()?;
        after(subject.as_mut())?;
        Ok(checked)
    });
    if let Some(gpu) = gpu {
        gpu.check()?;
    }
    checked
}

fn finish(
    job: &mut AxisJob,
    axis: &Axis,
    setting: usize,
    value: f64,
    device: &(String, String),
    judged: &Judgement,
    emit: &mut dyn FnMut(Event),
) {
    let points = Points { run: &job.run, axis, case: &job.case, adapter: job.adapter.as_deref() };
    let line = points.line(&job.settings[setting], value, device, judged);
    job.done.push(Done::of(setting, &line));
    emit(Event::Stress(Box::new(line)));
}
