//! One group in one process: check everything, then time A B C A B C ...

use super::protocol::{Event, Job, adapter_choice};
use crate::{
    SuiteError,
    environment::{environment, requires_gpu},
    knob::Knobs,
    plan::Group,
    problem::{Checked, Facts, Form, FrameTime, Setting, Subject},
    problems,
};
use dapple_gpu::{AdapterKind, Gpu, GpuError};
use dapple_metrics::stats;
use dapple_records::{Row, Status};
use std::collections::BTreeMap;

/// A subject that passed its check, with the samples taken of it so far.
struct Timed<'a> {
    setting: usize,
    subject: Box<dyn Subject + 'a>,
    checked: Checked,
    wall: Vec<Vec<u64>>,
    gpu: Vec<Vec<u64>>,
    passes: BTreeMap<&'static str, Vec<u64>>,
    failure: Option<String>,
}

/// Runs a job and emits its events.
pub fn run(job: &Job, emit: &mut dyn FnMut(Event)) {
    let settings = &job.group.settings;
    let outcome = open(settings, job.adapter.as_ref()).and_then(|gpu| match gpu {
        Adapter::Missing(reason) => {
            not_run(job, &reason, emit);
            Ok(())
        }
        Adapter::NotNeeded => measure(job, None, emit),
        Adapter::Open(gpu) => measure(job, Some(&gpu), emit),
    });
    match outcome {
        Ok(()) => emit(Event::Done),
        Err(error @ SuiteError::MissingData { .. }) => {
            not_run(job, &error.to_string(), emit);
            emit(Event::Done);
        }
        Err(error) => {
            emit(Event::Failed { reason: error.to_string(), code: error.exit_code() });
        }
    }
}

/// The adapter that a job works on.
pub(crate) enum Adapter {
    NotNeeded,
    Missing(String),
    Open(Box<Gpu>),
}

/// Opens the adapter where a setting needs one.
pub(crate) fn open(settings: &[Setting], named: Option<&String>) -> Result<Adapter, SuiteError> {
    if !settings.iter().any(|s| s.form == Form::Gpu) {
        return Ok(Adapter::NotNeeded);
    }
    match Gpu::open(&adapter_choice(named)) {
        Ok(gpu) => Ok(Adapter::Open(Box::new(gpu))),
        Err(error @ (GpuError::NoAdapter { .. } | GpuError::Unsound { .. }))
            if named.is_none() && !requires_gpu() =>
        {
            Ok(Adapter::Missing(error.to_string()))
        }
        Err(error) => Err(error.into()),
    }
}

fn measure(job: &Job, gpu: Option<&Gpu>, emit: &mut dyn FnMut(Event)) -> Result<(), SuiteError> {
    emit(Event::Begin { setting: usize::MAX, stage: "prepare".into(), value: None });
    let prepared = problems::find(&job.group.case.problem)?.prepare(&job.group.case, gpu)?;
    let facts = prepared.facts();
    for note in &facts.notes {
        emit(Event::Note(format!("{}: {note}", job.group.case.name())));
    }
    let mut timed = Vec::new();
    for (i, setting) in job.group.settings.iter().enumerate() {
        let wanted = job.todo.contains(&i) || i == 0;
        if !wanted || job.banned.contains(&i) {
            continue;
        }
        emit(Event::Begin { setting: i, stage: "check".into(), value: None });
        if let Some(fault) = &job.fault {
            fault.commit(&setting.technique, None);
        }
        let made = prepared.subject(setting).and_then(|mut subject| {
            let checked = subject.check()?;
            Ok((subject, checked))
        });
        match made {
            // A reference is an oracle, written for reading: its time would say nothing.
            Ok((_, checked))
                if checked.violations.is_empty() && setting.form == Form::Reference =>
            {
                let mut row = row(job, i, &facts, gpu);
                fill_checked(&mut row, &checked);
                row.clock = "none".into();
                finish(job, i, row, emit);
            }
            Ok((subject, checked)) if checked.violations.is_empty() => {
                timed.push(Timed::new(i, subject, checked));
            }
            Ok((_, checked)) => {
                let reason = checked.violations.join("; ");
                let mut row = row(job, i, &facts, gpu);
                fill_checked(&mut row, &checked);
                row.status = Status::Failed { stage: "check".into(), reason };
                finish(job, i, row, emit);
            }
            Err(error) if is_device_gone(&error) => return Err(error),
            Err(error) => {
                let mut row = row(job, i, &facts, gpu);
                row.status = Status::Failed { stage: "check".into(), reason: error.to_string() };
                finish(job, i, row, emit);
            }
        }
        if let Some(gpu) = gpu {
            gpu.check()?;
        }
    }
    for _ in 0..job.repeats {
        for subject in &mut timed {
            emit(Event::Begin { setting: subject.setting, stage: "time".into(), value: None });
            subject.repeat()?;
        }
    }
    let baseline = timed.first().filter(|t| t.setting == 0 && t.failure.is_none());
    for subject in &timed {
        let mut row = row(job, subject.setting, &facts, gpu);
        fill_checked(&mut row, &subject.checked);
        subject.fill(&mut row, baseline);
        finish(job, subject.setting, row, emit);
    }
    Ok(())
}

/// Whoever uses the device next fails as well, and is not to blame: the group ends here.
pub(crate) fn is_device_gone(error: &SuiteError) -> bool {
    matches!(error.device(), Some(GpuError::DeviceLost(_) | GpuError::Timeout { .. }))
}

impl<'a> Timed<'a> {
    fn new(setting: usize, subject: Box<dyn Subject + 'a>, checked: Checked) -> Self {
        Self {
            setting,
            subject,
            checked,
            wall: Vec::new(),
            gpu: Vec::new(),
            passes: BTreeMap::new(),
            failure: None,
        }
    }

    /// One repeat: a reset, then every frame of the path. A failure is kept for the row, unless
    /// the device is gone.
    fn repeat(&mut self) -> Result<(), SuiteError> {
        if self.failure.is_some() {
            return Ok(());
        }
        let frames = self.subject.frames();
        let run: Result<Vec<FrameTime>, SuiteError> = self
            .subject
            .reset()
            .and_then(|()| (0..frames).map(|frame| self.subject.frame(frame)).collect());
        match run {
            Err(error) if is_device_gone(&error) => return Err(error),
            Err(error) => self.failure = Some(error.to_string()),
            Ok(times) => {
                self.wall.push(times.iter().map(|t| t.wall_ns).collect());
                // One frame without a device time makes the whole repeat a wall-clock one.
                if let Some(gpu) = times.iter().map(|t| t.gpu_ns).collect::<Option<Vec<_>>>() {
                    self.gpu.push(gpu);
                }
                for (name, ns) in times.into_iter().flat_map(|t| t.passes) {
                    self.passes.entry(name).or_default().push(ns);
                }
            }
        }
        Ok(())
    }

    /// The clock and the samples that count: the device's where every repeat has them.
    fn samples(&self) -> (&'static str, &Vec<Vec<u64>>) {
        if !self.gpu.is_empty() && self.gpu.len() == self.wall.len() {
            ("gpu", &self.gpu)
        } else {
            ("wall", &self.wall)
        }
    }

    /// Time of a frame, the mean of each repeat: a technique with a path of its own is compared
    /// frame by frame with one that has a still view.
    fn means(&self) -> Vec<f64> {
        let mean = |f: &Vec<u64>| f.iter().sum::<u64>() as f64 / f.len().max(1) as f64;
        self.samples().1.iter().map(mean).collect()
    }

    fn fill(&self, row: &mut Row, baseline: Option<&Timed<'_>>) {
        if let Some(reason) = &self.failure {
            row.status = Status::Failed { stage: "time".into(), reason: reason.clone() };
            return;
        }
        let (clock, samples) = self.samples();
        row.clock = clock.into();
        row.samples_ns = samples.clone();
        for (name, ns) in &self.passes {
            let ns: Vec<f64> = ns.iter().map(|n| *n as f64).collect();
            if let Ok(median) = stats::median(&ns) {
                row.passes_ns.insert((*name).into(), median as u64);
            }
        }
        // A device's time over a wall clock's would say nothing.
        row.ratio = baseline
            .filter(|baseline| baseline.samples().0 == clock)
            .and_then(|baseline| stats::paired_ratio(&self.means(), &baseline.means()).ok())
            .map(|ratio| ratio.median);
    }
}

fn fill_checked(row: &mut Row, checked: &Checked) {
    row.errors = checked.errors.clone();
    row.port_errors = checked.port_errors.clone();
    row.counters = checked.counters.clone();
    row.memory_bytes = checked.memory_bytes;
}

/// A row without results yet.
fn row(job: &Job, setting: usize, facts: &Facts, gpu: Option<&Gpu>) -> Row {
    let mut row = blank(&job.group, setting);
    row.run.clone_from(&job.run);
    row.group = job.group.key(setting);
    row.scene.clone_from(&facts.scene);
    row.scene_hash.clone_from(&facts.scene_hash);
    row.view.clone_from(&facts.view);
    row.size.clone_from(&facts.size);
    row.truth.clone_from(&facts.truth);
    let gpu = gpu.filter(|_| job.group.settings[setting].form == Form::Gpu);
    if let Some(gpu) = gpu {
        row.driver = format!("{} {}", gpu.facts.driver, gpu.facts.driver_info);
    }
    (row.adapter, row.device) = device_names(gpu);
    row
}

/// What records call the adapter and its kind; without one, the processor did the work.
pub(crate) fn device_names(gpu: Option<&Gpu>) -> (String, String) {
    let Some(gpu) = gpu else { return ("cpu".into(), "cpu".into()) };
    let device = match gpu.facts.kind {
        AdapterKind::Hardware => "hardware",
        AdapterKind::Software => "software",
    };
    (gpu.facts.name.clone(), device.into())
}

/// What is known of a row before its group was prepared.
pub fn blank(group: &Group, setting: usize) -> Row {
    let facts = environment();
    let chosen = &group.settings[setting];
    let baseline = &group.settings[0];
    Row {
        problem: group.case.problem.clone(),
        technique: chosen.technique.clone(),
        variant: chosen.variant.clone(),
        form: chosen.form.to_string(),
        knobs: chosen.knobs.clone(),
        case: group.case.name(),
        scene: group.case.scene.clone(),
        view: group.case.view.clone(),
        baseline: format!("{}/{}", baseline.technique, baseline.variant),
        // In place of the truth's own words, which only a prepared case has.
        truth: words(&group.case.parameters),
        cpu: facts.cpu.clone(),
        threads: facts.threads,
        machine: facts.machine.clone(),
        revision: facts.revision.clone(),
        dirty: facts.dirty,
        shader_hash: facts.shader_hash.clone(),
        ..Row::default()
    }
}

fn words(parameters: &Knobs) -> String {
    parameters.iter().map(|(name, value)| format!("{name}={value}")).collect::<Vec<_>>().join(" ")
}

fn not_run(job: &Job, reason: &str, emit: &mut dyn FnMut(Event)) {
    for i in job.todo.iter().copied() {
        let mut row = blank(&job.group, i);
        row.run.clone_from(&job.run);
        row.group = job.group.key(i);
        row.adapter = "none".into();
        row.device = "none".into();
        row.status = Status::NotRun { reason: reason.into() };
        finish(job, i, row, emit);
    }
}

/// Emits the row unless this setting was only there for its ratio.
fn finish(job: &Job, setting: usize, mut row: Row, emit: &mut dyn FnMut(Event)) {
    if !job.todo.contains(&setting) {
        return;
    }
    row.time = dapple_records::time::now();
    row.row = row.identity();
    // A row that no record may hold, e.g. with an error that is not a number, fails alone.
    if let Err(error) = dapple_records::validate(&row) {
        row.status = Status::Failed { stage: "record".into(), reason: error.to_string() };
        row.samples_ns.clear();
        row.passes_ns.clear();
        row.ratio = None;
    }
    emit(Event::Row(Box::new(row)));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::Sweep;
    use std::path::Path;

    /// A technique that takes as long as it is told, by the clock it is told.
    struct Fake {
        wall_ns: u64,
        gpu_ns: Option<u64>,
        error: Option<fn() -> SuiteError>,
    }

    impl Subject for Fake {
        fn frames(&self) -> usize {
            2
        }

        fn reset(&mut self) -> Result<(), SuiteError> {
            Ok(())
        }

        fn frame(&mut self, _: usize) -> Result<FrameTime, SuiteError> {
            let time = FrameTime { wall_ns: self.wall_ns, gpu_ns: self.gpu_ns, passes: Vec::new() };
            self.error.map_or(Ok(time), |error| Err(error()))
        }

        fn check(&mut self) -> Result<Checked, SuiteError> {
            Ok(Checked::default())
        }
    }

    fn timed(wall_ns: u64, gpu_ns: Option<u64>) -> Timed<'static> {
        let mut timed = failing(wall_ns, gpu_ns, None);
        for _ in 0..3 {
            timed.repeat().unwrap();
        }
        timed
    }

    fn failing(
        wall_ns: u64,
        gpu_ns: Option<u64>,
        error: Option<fn() -> SuiteError>,
    ) -> Timed<'static> {
        Timed::new(0, Box::new(Fake { wall_ns, gpu_ns, error }), Checked::default())
    }

    fn ratio(subject: &Timed<'_>, baseline: &Timed<'_>) -> Option<f64> {
        let mut row = Row::default();
        subject.fill(&mut row, Some(baseline));
        row.ratio
    }

    #[test]
    fn ratios_are_of_times_by_the_same_clock() {
        assert_eq!(ratio(&timed(30, None), &timed(10, None)), Some(3.0));
        assert_eq!(ratio(&timed(99, Some(8)), &timed(77, Some(4))), Some(2.0));
        assert_eq!(ratio(&timed(30, None), &timed(10, Some(4))), None);
        assert_eq!(ratio(&timed(30, Some(4)), &timed(10, None)), None);
        let mut path = timed(30, None);
        path.wall.iter_mut().for_each(|frames| *frames = vec![20, 30, 40, 30]);
        assert_eq!(ratio(&path, &timed(10, None)), Some(3.0), "a frame, not a path");
    }

    #[test]
    fn a_lost_device_ends_the_group_and_another_error_only_its_setting() {
        let lost = || SuiteError::Gpu(GpuError::DeviceLost("gone".into()));
        assert!(failing(1, None, Some(lost)).repeat().is_err());
        let mut wrong = failing(1, None, Some(|| SuiteError::Usage("odd".into())));
        wrong.repeat().unwrap();
        let mut row = Row::default();
        wrong.fill(&mut row, None);
        assert_eq!(row.status, Status::Failed { stage: "time".into(), reason: "odd".into() });
    }

    fn job() -> Job {
        let text = "about = 't'\n[[measure]]\nproblem = 'partition-offsets'\nforms = ['cpu']\n\
                    parameters = { frames = [1, 2] }";
        let plan = Sweep::parse(Path::new("t"), text).unwrap().plan("t").unwrap();
        Job {
            run: "r".into(),
            group: plan.groups[0].clone(),
            todo: vec![0],
            banned: Vec::new(),
            repeats: 1,
            adapter: None,
            fault: None,
        }
    }

    #[test]
    fn a_row_that_no_record_may_hold_becomes_a_failure() {
        let job = job();
        let mut bad = blank(&job.group, 0);
        bad.run.clone_from(&job.run);
        bad.clock = "wall".into();
        bad.samples_ns = vec![vec![5]];
        bad.ratio = Some(1.0);
        bad.errors.insert("rmse".into(), f64::NAN);
        let mut rows = Vec::new();
        finish(&job, 0, bad, &mut |event| {
            if let Event::Row(row) = event {
                rows.push(*row);
            }
        });
        dapple_records::validate(&rows[0]).unwrap();
        assert!(matches!(&rows[0].status, Status::Failed { stage, .. } if stage == "record"));
    }

    #[test]
    fn a_row_of_a_case_that_was_never_prepared_still_tells_its_parameters() {
        let group = job().group;
        let mut other = group.clone();
        other.case.parameters.insert("frames".into(), 2.into());
        assert!(blank(&group, 0).truth.contains("frames=1"));
        assert_ne!(blank(&group, 0).identity(), blank(&other, 0).identity());
    }
}
