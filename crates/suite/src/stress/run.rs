//! Pushing along axes, each in a process of its own: a crash or a hang is a point like any other.

use super::{
    Axis,
    child::{self, AxisJob, Done},
    find_axis,
    judge::{Judgement, Verdict},
    line::Points,
};
use crate::{
    SuiteError,
    case::Case,
    problem::{Problem, Setting},
    problems,
    run::{
        Options,
        process::{self, Begun, Ended, Limit, run_child},
        protocol::Event,
        records,
    },
    sweep::{self, Measure},
};
use dapple_records::{Line, StressLine, Writer};
use serde::Serialize;
use std::{
    collections::{BTreeMap, BTreeSet},
    io::{Read, Write},
    path::{Path, PathBuf},
    sync::atomic::AtomicBool,
    time::{Duration, Instant},
};

/// Settings to push along one axis of one case.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AxisPlan {
    /// Axis id.
    pub axis: String,
    /// The case it starts from.
    pub case: Case,
    /// The settings; those to which the axis means nothing at home are left out.
    pub settings: Vec<Setting>,
    /// Points of the grid, of all settings together.
    pub points: usize,
}

/// Everything a run pushes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StressPlan {
    /// The axes, in order.
    pub axes: Vec<AxisPlan>,
    /// Bisection steps at each end.
    pub refine: u32,
    /// Seconds that preparing, and each check, may take.
    pub limit_s: u64,
}

impl StressPlan {
    /// Points of all grids; refinement adds to them.
    pub fn points(&self) -> usize {
        self.axes.iter().map(|axis| axis.points).sum()
    }
}

/// What a run tells while it goes on.
pub enum Progress<'a> {
    /// Where the records are, how many points are planned, how many were there already.
    Started {
        /// The record file.
        path: &'a Path,
        /// Points of all grids.
        total: usize,
        /// Points found of an earlier, unfinished run.
        resumed: usize,
    },
    /// An axis begins.
    Axis(&'a AxisPlan),
    /// A point begins.
    Stage {
        /// The axis.
        axis: &'a str,
        /// Where on it.
        label: &'a str,
        /// The setting; empty while the case is prepared.
        setting: &'a str,
        /// `prepare` or `check`.
        stage: &'a str,
    },
    /// A point is on disk.
    Point(&'a StressLine),
    /// An axis ended.
    AxisEnd {
        /// The axis.
        plan: &'a AxisPlan,
        /// Points found now.
        points: usize,
        /// How long it took.
        took: Duration,
    },
}

/// What a finished run left.
#[derive(Debug)]
pub struct Finished {
    /// The record file.
    pub path: PathBuf,
    /// Every point, by axis in order of the plan.
    pub points: Vec<StressLine>,
    /// Axes that could not be pushed: reason and exit code.
    pub failed: Vec<(String, u8)>,
}

/// The axes of a problem that are asked for (all if none are) for the cases and settings of a
/// block.
///
/// # Errors
/// Unknown names, values out of range, or nothing to push.
pub fn axes(
    problem: &dyn Problem,
    asked: &[String],
    block: &Measure,
) -> Result<Vec<AxisPlan>, SuiteError> {
    let spec = problem.spec();
    for id in asked {
        find_axis(problem, id)?;
    }
    let mut axes = problem.stress();
    axes.retain(|axis| asked.is_empty() || asked.iter().any(|id| id == axis.id));
    let mut plans = Vec::new();
    for axis in &axes {
        if let Some(fault) = axis.fault(spec) {
            return Err(SuiteError::Internal(format!("axis {}: {fault}", axis.id)));
        }
        let mut block = block.clone();
        for (name, value) in axis.case_parameters(spec, &BTreeMap::new())? {
            block.parameters.entry(name).or_insert_with(|| vec![value]);
        }
        if block.forms.is_empty() {
            block.forms = axis.forms.to_vec();
        }
        block.forms.retain(|form| axis.forms.contains(form));
        let mut settings = Vec::new();
        if !block.forms.is_empty() {
            settings = sweep::settings(spec, &block, &mut Vec::new())?;
        }
        settings.retain(|setting| (axis.setting)(setting, axis.home).is_some());
        let grid = axis.grid();
        let on_grid =
            |s: &Setting| grid.iter().filter(|v| (axis.setting)(s, **v).is_some()).count();
        let points = settings.iter().map(on_grid).sum();
        let cases = sweep::cases(spec, &block)?;
        let names: BTreeSet<String> = cases.iter().map(Case::name).collect();
        if names.len() < cases.len() {
            let text = "stress takes one value for each parameter, one view and one seed";
            return Err(SuiteError::Usage(text.into()));
        }
        if !settings.is_empty() {
            plans.extend(cases.into_iter().map(|case| {
                let settings = settings.clone();
                AxisPlan { axis: axis.id.into(), case, settings, points }
            }));
        }
    }
    Ok(plans)
}

/// Runs a plan. `stop` ends it early, after which the same command resumes.
///
/// # Errors
/// Records that cannot be written, a child that cannot be started, [`SuiteError::Interrupted`].
pub fn run(
    plan: &StressPlan,
    options: &Options,
    stop: &AtomicBool,
    tell: &mut dyn FnMut(Progress<'_>),
) -> Result<Finished, SuiteError> {
    let hash = blake3::hash(process::line(plan)?.as_bytes()).to_hex();
    let key = records::resume_key(&hash[..16], options);
    let (writer, read) = records::open("stress", &key, options)?;
    let total = plan.points();
    tell(Progress::Started { path: writer.path(), total, resumed: read.stress.len() });
    let (points, failed) = (read.stress, Vec::new());
    let mut state = State { writer, points, failed, devices: BTreeMap::new(), tell };
    for axis in &plan.axes {
        let (before, begun) = (state.points.len(), Instant::now());
        (state.tell)(Progress::Axis(axis));
        state.push(axis, plan, options, stop)?;
        let points = state.points.len() - before;
        (state.tell)(Progress::AxisEnd { plan: axis, points, took: begun.elapsed() });
    }
    state.writer.end()?;
    let path = state.writer.path().to_path_buf();
    Ok(Finished { path, points: state.points, failed: state.failed })
}

/// What is done, and where it goes.
struct State<'a> {
    writer: Writer,
    points: Vec<StressLine>,
    failed: Vec<(String, u8)>,
    /// Name and kind of the device that did the work of each form.
    devices: BTreeMap<String, (String, String)>,
    tell: &'a mut dyn FnMut(Progress<'_>),
}

impl State<'_> {
    fn keep(&mut self, line: StressLine) -> Result<(), SuiteError> {
        let point = Line::Stress(Box::new(line.clone()));
        self.writer.append_line(&point)?;
        (self.tell)(Progress::Point(&line));
        self.points.push(line);
        Ok(())
    }

    /// One axis to its end, in as many processes as it takes: each but the last dies of a point,
    /// which is known from then on.
    fn push(
        &mut self,
        plan: &AxisPlan,
        whole: &StressPlan,
        options: &Options,
        stop: &AtomicBool,
    ) -> Result<(), SuiteError> {
        let axis = find_axis(problems::find(&plan.case.problem)?, &plan.axis)?;
        let mut job = AxisJob {
            run: self.writer.run().into(),
            axis: plan.axis.clone(),
            case: plan.case.clone(),
            settings: plan.settings.clone(),
            done: Vec::new(),
            refine: whole.refine,
            adapter: options.adapter.clone(),
            fault: options.fault.clone(),
        };
        for line in &self.points {
            job.done.extend(done_of(&job, line));
        }
        let limit = Limit::Stage(Duration::from_secs(whole.limit_s));
        while job.next(&axis).is_some() {
            let known = job.done.len();
            let line = process::line(&job)?;
            let settings = job.settings.len();
            let ended = run_child(&line, settings, options, limit, stop, &mut |event| {
                self.hear(&mut job, &axis, event)
            })?;
            match ended {
                Ended::Stopped => {
                    let (path, done) = (self.writer.path().to_path_buf(), self.points.len());
                    return Err(SuiteError::Interrupted { done, total: whole.points(), path });
                }
                Ended::Failed { reason, code } => return self.fail(plan, &reason, code),
                Ended::Died { begun: Some(Begun { setting, value: Some(value), .. }), reason } => {
                    for culprit in culprits(&mut job, &axis, setting, value) {
                        self.crashed(&mut job, &axis, culprit, value, &reason)?;
                    }
                }
                Ended::Died { reason, .. } => return self.fail(plan, &reason, 3),
                Ended::Done => {}
            }
            // Every turn ends a point: nothing may go round for ever.
            if job.done.len() == known {
                return self.fail(plan, "its process ended without a point", 3);
            }
        }
        Ok(())
    }

    fn fail(&mut self, plan: &AxisPlan, reason: &str, code: u8) -> Result<(), SuiteError> {
        let AxisPlan { axis, case, .. } = plan;
        self.failed.push((format!("{} {axis} {}: {reason}", case.problem, case.name()), code));
        Ok(())
    }

    fn hear(&mut self, job: &mut AxisJob, axis: &Axis, event: Event) -> Result<(), SuiteError> {
        match event {
            Event::Stress(line) => {
                let device = (line.adapter.clone(), line.device.clone());
                self.devices.insert(line.form.clone(), device);
                let done = done_of(job, &line);
                job.done.extend(done);
                self.keep(*line)?;
            }
            Event::Begin { setting, stage, value: Some(value) } => {
                let setting = job.settings.get(setting).map(ToString::to_string);
                let (setting, label) = (setting.unwrap_or_default(), axis.values.label(value));
                let (axis, stage) = (axis.id, stage.as_str());
                (self.tell)(Progress::Stage { axis, label: &label, setting: &setting, stage });
            }
            Event::Begin { .. }
            | Event::Note(_)
            | Event::Row(_)
            | Event::Failed { .. }
            | Event::Done => {}
        }
        Ok(())
    }

    /// The point that a process died of.
    fn crashed(
        &mut self,
        job: &mut AxisJob,
        axis: &Axis,
        setting: usize,
        value: f64,
        reason: &str,
    ) -> Result<(), SuiteError> {
        let unknown = || ("unknown".to_string(), "unknown".to_string());
        let form = job.settings[setting].form.to_string();
        let device = match form.as_str() {
            "cpu" => ("cpu".into(), "cpu".into()),
            _ => self.devices.get(&form).cloned().unwrap_or_else(unknown),
        };
        let adapter = job.adapter.as_deref();
        let points = Points { run: &job.run, axis, case: &job.case, adapter };
        let judged = Judgement::without(Verdict::Crashed, reason);
        let line = points.line(&job.settings[setting], value, &device, &judged);
        job.done.push(Done::of(setting, &line));
        self.keep(line)
    }
}

/// Whom a death at a value is put down to: the setting at work, or all that waited for the case.
fn culprits(job: &mut AxisJob, axis: &Axis, setting: usize, value: f64) -> Vec<usize> {
    let all = 0..job.settings.len();
    let at_work: Vec<usize> = if all.contains(&setting) { vec![setting] } else { all.collect() };
    at_work.into_iter().filter(|s| job.wanted(axis, *s).contains(&value)).collect()
}

/// The point as the job knows it, if it is one of the job's.
fn done_of(job: &AxisJob, line: &StressLine) -> Option<Done> {
    let of_job =
        line.problem == job.case.problem && line.case == job.case.name() && line.axis == job.axis;
    let setting = job.settings.iter().position(|setting| {
        line.technique == setting.technique
            && line.variant == setting.variant
            && line.form == setting.form.to_string()
    });
    setting.filter(|_| of_job).map(|setting| Done::of(setting, line))
}

/// The child's side: reads an [`AxisJob`], one line of `input`, and writes events to `output`.
///
/// # Errors
/// [`SuiteError::Usage`] for a job that cannot be read.
pub fn serve(input: impl Read + Send + 'static, output: &mut dyn Write) -> Result<(), SuiteError> {
    // Where memory runs out, this process is the one to end: it is known what it was at.
    let _ = std::fs::write("/proc/self/oom_score_adj", "1000");
    process::serve(input, output, child::run)
}

#[cfg(test)]
#[path = "run_tests.rs"]
mod tests;
