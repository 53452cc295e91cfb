//! `dapple measure`, and the child process it starts for each group.

use crate::{
    Outcome,
    args::{self, CaseArgs},
    die_of_closed_pipes, feed, figures,
    output::note,
    runner,
};
use anyhow::Result;
use dapple_records::{Feed, Line, Status};
use dapple_suite::{
    SuiteError,
    case::{self, Source},
    knob::{self, Knob},
    plan::{self, Plan},
    problem::{Form, Spec},
    problems,
    run::{self, Finished, Options, Progress, protocol::Fault},
    sweep::{self, Measure, Pick, Sweep},
};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::Value;
use std::{
    collections::BTreeMap,
    io::IsTerminal,
    sync::atomic::{AtomicBool, Ordering},
};

/// Measures a sweep or a problem and prints the fronts of the run, or tells a dashboard.
pub fn run(args: &args::Measure) -> Result<Outcome> {
    runner::told_to_the_end(args.feed, || measure(args))
}

fn measure(args: &args::Measure) -> Result<Outcome> {
    let plan = plan(args)?;
    let stop = runner::stop_flag();
    let options = Options {
        shard: plan.shard.clone(),
        fresh: args.fresh,
        fault: args.fault.as_deref().map(Fault::parse).transpose()?,
        ..runner::options(&args.records, args.adapter.as_ref(), "run-group")?
    };
    let finished =
        if args.feed { told(&plan, &options, &stop) } else { shown(&plan, &options, &stop) };
    runner::note_in_use(&finished);
    let finished = finished?;
    let rows = dapple_records::read_file(&finished.path)?.rows;
    if !args.feed {
        let view = figures::View { metric: None, all: true, format: args.format };
        figures::print_fronts(&rows, &view)?;
        note!("records: {}", finished.path.display());
    }
    if let Some((_, code)) = finished.failed_groups.first() {
        return Ok(Outcome::Code(*code));
    }
    let failed = rows.iter().any(|row| matches!(row.status, Status::Failed { .. }));
    Ok(if failed { Outcome::CheckFailed } else { Outcome::Ok })
}

/// With a progress bar.
fn shown(plan: &Plan, options: &Options, stop: &AtomicBool) -> Result<Finished, SuiteError> {
    let bar = progress_bar(plan.rows());
    // A measuring process that dies at its start, or a reader of our notes that goes away, must
    // not take the sweep along.
    die_of_closed_pipes(false);
    let finished = run::run(plan, options, stop, &mut |progress| show(&bar, &progress));
    die_of_closed_pipes(true);
    bar.finish_and_clear();
    finished
}

/// With JSON lines. A dashboard that goes away ends the run, which can be resumed.
fn told(plan: &Plan, options: &Options, stop: &AtomicBool) -> Result<Finished, SuiteError> {
    let (mut group, mut done) = (String::new(), 0);
    run::run(plan, options, stop, &mut |progress| {
        let told = match progress {
            Progress::Started { path, total, resumed } => {
                done = resumed;
                let path = path.display().to_string();
                feed::tell(&Feed::Started { path, total, resumed })
            }
            Progress::Group(title) => {
                group = title.into();
                let (setting, stage) = (String::new(), String::new());
                feed::tell(&Feed::Stage { what: group.clone(), setting, stage })
            }
            Progress::Stage { setting, stage } => {
                let (setting, stage) = (setting.into(), stage.into());
                feed::tell(&Feed::Stage { what: group.clone(), setting, stage })
            }
            Progress::Note(text) => feed::tell(&Feed::Note { text: text.into() }),
            Progress::Row(row) => {
                done += 1;
                feed::tell_line(&Line::Row(Box::new(row.clone())))
                    .and_then(|()| feed::tell(&Feed::Progress { done }))
            }
        };
        if told.is_err() {
            stop.store(true, Ordering::Relaxed);
        }
    })
}

/// The child's side.
pub fn serve() -> Result<Outcome> {
    // The lock is not held across the job: a driver may print on standard output too.
    run::serve(std::io::stdin(), &mut std::io::stdout())?;
    Ok(Outcome::Ok)
}

/// What the arguments ask for, expanded.
pub fn plan(args: &args::Measure) -> Result<Plan, SuiteError> {
    let (name, mut sweep) = match (&args.sweep, &args.problem) {
        (Some(name), _) => sweep::load(name)?,
        (None, Some(problem)) => (problem.clone(), ad_hoc(problem, args)?),
        (None, None) => {
            let known: Vec<_> = problems::ALL.iter().map(|p| p.spec().id).collect();
            let known = known.join(", ");
            return Err(SuiteError::Usage(format!("give a problem ({known}) or --sweep")));
        }
    };
    if let Some(repeats) = args.repeats {
        sweep.repeats = repeats;
    }
    let plan = sweep.plan(&name)?;
    match &args.shard {
        None => Ok(plan),
        Some(text) => {
            let (index, count) = plan::parse_shard(text)?;
            plan.shard(index, count)
        }
    }
}

fn ad_hoc(problem: &str, args: &args::Measure) -> Result<Sweep, SuiteError> {
    let spec = problems::find(problem)?.spec();
    // A sweep passes over data that are not at hand; a scene asked for by name must be there.
    for scene in &args.case.scene {
        if let Source::MissingData(path) = case::source(scene)? {
            return Err(case::missing_data(&path));
        }
    }
    let mut measure = measure_block(spec, &args.case)?;
    measure.forms = args.form.iter().map(|f| form(f)).collect::<Result<_, _>>()?;
    let knobs: Vec<Knob> = spec.techniques.iter().flat_map(|t| t.knobs).copied().collect();
    measure.knobs = lists("knob", &knobs, &args.knob)?;
    measure.technique = args.technique.iter().map(|t| pick(t)).collect();
    Ok(Sweep { about: String::new(), repeats: 5, limit_s: 600, measure: vec![measure] })
}

/// The block of a sweep that the case's flags describe.
pub fn measure_block(spec: &Spec, case: &CaseArgs) -> Result<Measure, SuiteError> {
    Ok(Measure {
        problem: spec.id.into(),
        scenes: case.scene.clone(),
        views: case.view.iter().cloned().collect(),
        seeds: case.seed.iter().copied().collect(),
        parameters: lists("parameter", spec.parameters, &case.parameters)?,
        forms: Vec::new(),
        knobs: BTreeMap::new(),
        technique: Vec::new(),
    })
}

/// A form by name.
pub fn form(name: &str) -> Result<Form, SuiteError> {
    match name {
        "reference" => Ok(Form::Reference),
        "cpu" => Ok(Form::Cpu),
        "gpu" => Ok(Form::Gpu),
        _ => Err(SuiteError::unknown("form", name, ["reference", "cpu", "gpu"])),
    }
}

/// `TECHNIQUE` or `TECHNIQUE/VARIANT`.
pub fn pick(text: &str) -> Pick {
    let (id, variant) = text.split_once('/').map_or((text, None), |(id, v)| (id, Some(v)));
    Pick {
        id: id.into(),
        variants: variant.map(Into::into).into_iter().collect(),
        knobs: BTreeMap::new(),
    }
}

/// Reads `NAME=A,B` flags into lists of values.
pub fn lists(
    what: &'static str,
    knobs: &[Knob],
    flags: &[String],
) -> Result<BTreeMap<String, Vec<Value>>, SuiteError> {
    let mut lists: BTreeMap<String, Vec<Value>> = BTreeMap::new();
    for flag in flags {
        let (name, values) = flag.split_once('=').unwrap_or((flag, ""));
        for value in values.split(',') {
            let assignment =
                if flag.contains('=') { format!("{name}={value}") } else { flag.clone() };
            let (name, value) = knob::parse_assignment(what, knobs, &assignment)?;
            lists.entry(name).or_default().push(value);
        }
    }
    Ok(lists)
}

/// A bar on a terminal, nothing elsewhere.
pub fn progress_bar(rows: usize) -> ProgressBar {
    let bar = ProgressBar::new(rows as u64);
    if !std::io::stderr().is_terminal() {
        bar.set_draw_target(ProgressDrawTarget::hidden());
    }
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} {elapsed}<{eta} {msg}") {
        bar.set_style(style);
    }
    bar
}

fn show(bar: &ProgressBar, progress: &Progress<'_>) {
    match progress {
        Progress::Started { path, resumed, .. } => {
            bar.set_position(*resumed as u64);
            if *resumed > 0 {
                bar.suspend(|| note!("resuming {}: {resumed} rows are there", path.display()));
            }
        }
        Progress::Group(title) => bar.set_message((*title).to_string()),
        Progress::Stage { setting, stage } => bar.set_message(format!("{stage} {setting}")),
        Progress::Note(text) => bar.suspend(|| note!("note: {text}")),
        Progress::Row(_) => bar.inc(1),
    }
}
