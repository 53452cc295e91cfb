//! `dapple stress`, and the child process it starts for each axis.

mod at;
mod table;

use crate::{
    Outcome, args, die_of_closed_pipes, feed,
    output::note,
    runner,
    verbs::measure::{form, measure_block, pick, progress_bar},
};
use anyhow::Result;
use dapple_records::{Feed, Line};
use dapple_suite::{
    SuiteError,
    case::{self, Source},
    problem::{Form, Problem},
    problems,
    run::{Options, protocol::Fault},
    stress::{
        line::is_fault,
        run::{self as stress, Finished, Progress, StressPlan},
    },
    sweep::Measure,
};
use std::{
    collections::BTreeSet,
    sync::atomic::{AtomicBool, Ordering},
    time::Duration,
};

/// Pushes techniques along the axes and prints where each is safe, or tells a dashboard.
pub fn run(args: &args::Stress) -> Result<Outcome> {
    let work = if args.at.is_some() { at::run } else { push };
    runner::told_to_the_end(args.feed, || work(args))
}

/// The child's side.
pub fn serve() -> Result<Outcome> {
    stress::serve(std::io::stdin(), &mut std::io::stdout())?;
    Ok(Outcome::Ok)
}

fn push(args: &args::Stress) -> Result<Outcome> {
    let plan = plan(args)?;
    if plan.axes.is_empty() {
        return nothing(args);
    }
    let stop = runner::stop_flag();
    let options = Options {
        fresh: args.fresh,
        fault: args.fault.as_deref().map(Fault::parse).transpose()?,
        ..runner::options(&args.records, args.adapter.as_ref(), "stress-axis")?
    };
    let finished =
        if args.feed { told(&plan, &options, &stop) } else { shown(&plan, &options, &stop) };
    runner::note_in_use(&finished);
    let finished = finished?;
    let reasons: BTreeSet<&str> = finished
        .points
        .iter()
        .filter(|point| point.verdict == "not-run")
        .map(|point| point.reason.as_str())
        .collect();
    for reason in reasons {
        note!("not run: {reason}");
    }
    if !args.feed {
        table::print(&plan, &finished.points, args.format)?;
        note!("records: {}", finished.path.display());
    }
    for (reason, _) in &finished.failed {
        note!("dapple: {reason}");
    }
    if let Some((_, code)) = finished.failed.first() {
        return Ok(Outcome::Code(*code));
    }
    let fault = finished.points.iter().any(is_fault);
    Ok(if fault { Outcome::CheckFailed } else { Outcome::Ok })
}

/// What is asked for.
fn plan(args: &args::Stress) -> Result<StressPlan, SuiteError> {
    let mut axes = Vec::new();
    for problem in chosen(args)? {
        axes.extend(stress::axes(problem, &args.axis, &block(problem, args)?)?);
    }
    Ok(StressPlan { axes, refine: args.refine, limit_s: args.limit })
}

fn chosen(args: &args::Stress) -> Result<Vec<&'static dyn Problem>, SuiteError> {
    let case = &args.case;
    let about_one = !args.axis.is_empty()
        || !args.technique.is_empty()
        || !case.scene.is_empty()
        || !case.parameters.is_empty()
        || case.view.is_some()
        || args.at.is_some();
    match &args.problem {
        Some(problem) => Ok(vec![problems::find(problem)?]),
        None if about_one => {
            let known: Vec<_> = problems::ALL.iter().map(|p| p.spec().id).collect();
            let known = known.join(", ");
            let text = format!("name the problem ({known}) that these arguments are about");
            Err(SuiteError::Usage(text))
        }
        None => Ok(problems::ALL.to_vec()),
    }
}

/// The cases and settings that the flags describe.
fn block(problem: &dyn Problem, args: &args::Stress) -> Result<Measure, SuiteError> {
    for scene in &args.case.scene {
        if let Source::MissingData(path) = case::source(scene)? {
            return Err(case::missing_data(&path));
        }
    }
    let mut block = measure_block(problem.spec(), &args.case)?;
    block.forms = args.form.iter().map(|f| form(f)).collect::<Result<_, _>>()?;
    if block.forms.contains(&Form::Reference) {
        return Err(SuiteError::unknown("form to push", "reference", ["cpu", "gpu"]));
    }
    block.technique = args.technique.iter().map(|t| pick(t)).collect();
    Ok(block)
}

/// Nothing was pushed: no axes, or none that means anything to what was asked for.
fn nothing(args: &args::Stress) -> Result<Outcome> {
    let mut without = 0;
    for problem in chosen(args)? {
        if problem.stress().is_empty() {
            note!("{} declares no extremes", problem.spec().id);
            without += 1;
        }
    }
    if without > 0 {
        return Ok(Outcome::Ok);
    }
    let text = "the axes mean nothing to these techniques and forms: nothing to push";
    Err(SuiteError::Usage(text.into()).into())
}

/// With a progress bar, and the time left after each axis.
fn shown(plan: &StressPlan, options: &Options, stop: &AtomicBool) -> Result<Finished, SuiteError> {
    let bar = progress_bar(plan.points());
    let (mut spent, mut pushed, mut left) = (Duration::ZERO, 0, plan.points());
    // A child that dies at its start, or a reader of our notes that goes away, must not take the
    // run along.
    die_of_closed_pipes(false);
    let finished = stress::run(plan, options, stop, &mut |progress| match progress {
        Progress::Started { path, total, resumed } => {
            let axes = plan.axes.len();
            bar.suspend(|| note!("axes: {axes}, points on their grids: {total}"));
            if resumed > 0 {
                bar.suspend(|| note!("resuming {}: {resumed} points are there", path.display()));
            }
        }
        Progress::Axis(_) => {}
        Progress::Stage { axis, label, setting, stage } => {
            bar.set_message(format!("{stage} {axis} {label} {setting}"));
        }
        Progress::Point(_) => bar.inc(1),
        Progress::AxisEnd { plan: axis, points, took } => {
            left -= axis.points;
            // What an earlier run had done tells nothing of the time.
            if points > 0 {
                spent += took;
                pushed += axis.points;
            }
            let seconds = spent.as_secs_f64() * left as f64 / pushed.max(1) as f64;
            let (id, took) = (&axis.axis, took.as_secs_f64());
            bar.suspend(|| {
                note!("{id}: {points} points in {took:.1} s; about {seconds:.0} s left")
            });
        }
    });
    die_of_closed_pipes(true);
    bar.finish_and_clear();
    finished
}

/// With JSON lines. A dashboard that goes away ends the run, which can be resumed.
fn told(plan: &StressPlan, options: &Options, stop: &AtomicBool) -> Result<Finished, SuiteError> {
    let mut done = 0;
    stress::run(plan, options, stop, &mut |progress| {
        let told = match progress {
            Progress::Started { path, total, resumed } => {
                done = resumed;
                let path = path.display().to_string();
                feed::tell(&Feed::Started { path, total, resumed })
            }
            Progress::Axis(axis) => {
                let (setting, stage) = (String::new(), String::new());
                feed::tell(&Feed::Stage { what: axis.axis.clone(), setting, stage })
            }
            Progress::Stage { axis, label, setting, stage } => feed::tell(&Feed::Stage {
                what: format!("{axis} {label}"),
                setting: setting.into(),
                stage: stage.into(),
            }),
            Progress::Point(point) => {
                done += 1;
                feed::tell_line(&Line::Stress(Box::new(point.clone())))
                    .and_then(|()| feed::tell(&Feed::Progress { done }))
            }
            Progress::AxisEnd { .. } => Ok(()),
        };
        if told.is_err() {
            stop.store(true, Ordering::Relaxed);
        }
    })
}
