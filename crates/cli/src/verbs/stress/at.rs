//! `dapple stress --at`: one point in this process, with its figures and pictures.

use super::{nothing, plan};
use crate::{
    Outcome, args, feed,
    output::{note, put},
    pictures,
    verbs::open_gpu,
};
use anyhow::Result;
use dapple_records::{Feed, Line, text::significant};
use dapple_suite::{
    SuiteError,
    problem::{Form, Setting},
    problems,
    stress::{
        at::{Shown, show},
        find_axis,
        line::{Points, is_fault},
        run::AxisPlan,
    },
};
use std::path::{Path, PathBuf};

/// Shows the point of every technique and form asked for.
pub fn run(args: &args::Stress) -> Result<Outcome> {
    let whole = plan(args)?;
    if whole.axes.is_empty() {
        return nothing(args);
    }
    let [axis_plan] = &whole.axes[..] else {
        let text =
            format!("--at takes one axis and one scene, and this names {}", whole.axes.len());
        return Err(SuiteError::Usage(text).into());
    };
    let AxisPlan { axis, case, settings, .. } = axis_plan;
    let axis = find_axis(problems::find(&case.problem)?, axis)?;
    let value = axis.values.parse(axis.id, args.at.as_deref().unwrap_or_default())?;
    let gpu = match settings.iter().any(|s| s.form == Form::Gpu) {
        true => open_gpu(args.adapter.as_ref())?,
        false => None,
    };
    // Those of whom nothing is asked there are passed over, unless that leaves none.
    let mut pushed: Vec<&Setting> =
        settings.iter().filter(|s| (axis.setting)(s, value).is_some()).collect();
    if pushed.is_empty() {
        pushed = settings.iter().collect();
    }
    let points = Points { run: "", axis: &axis, case, adapter: args.adapter.as_deref() };
    let mut fault = false;
    for setting in &pushed {
        if setting.form == Form::Gpu && gpu.is_none() {
            note!("{setting}: not run");
            continue;
        }
        let shown = show(&points, setting, value, gpu.as_ref())?;
        let folder = args.output.as_ref().map(|folder| match pushed.len() {
            1 => folder.clone(),
            _ => folder.join(folder_name(setting)),
        });
        tell(args.feed, setting, &shown, folder.as_deref())?;
        fault |= is_fault(&shown.line);
    }
    Ok(if fault { Outcome::CheckFailed } else { Outcome::Ok })
}

fn folder_name(setting: &Setting) -> PathBuf {
    let Setting { technique, variant, form, .. } = setting;
    format!("{technique}-{variant}-{form}").into()
}

fn tell(as_feed: bool, setting: &Setting, shown: &Shown, folder: Option<&Path>) -> Result<()> {
    let line = &shown.line;
    if let (Some(folder), Some(picture)) = (folder, &shown.picture) {
        pictures::write(picture, folder)?;
    }
    if as_feed {
        feed::tell_line(&Line::Stress(Box::new(line.clone())))?;
        for note in &shown.notes {
            feed::tell(&Feed::Note { text: note.clone() })?;
        }
        if let Some(picture) = &shown.picture {
            feed::tell(&feed::picture(0, picture))?;
        }
        return Ok(());
    }
    for note in &shown.notes {
        note!("note: {note}");
    }
    let because = if line.reason.is_empty() { String::new() } else { format!(": {}", line.reason) };
    let unit = if line.unit.is_empty() { String::new() } else { format!(" {}", line.unit) };
    put!("{setting} at {} = {}{unit}", line.axis, line.label)?;
    put!("  {}{because}", line.verdict)?;
    if let Some(limit) = line.limit {
        put!("  {:<16} {:>10}  limit {}", line.metric, figure(line.error), significant(limit))?;
    }
    if let Some(checked) = &shown.checked {
        for (name, value) in checked.errors.iter().filter(|(name, _)| **name != line.metric) {
            put!("  {name:<16} {:>10}", figure(Some(*value)))?;
        }
        for violation in &checked.violations {
            put!("  violated: {violation}")?;
        }
    }
    match (folder, &shown.picture) {
        (Some(folder), Some(_)) => put!("  pictures: {}", folder.display())?,
        (Some(_), None) => note!("{setting}: there is no picture of it"),
        (None, _) => {}
    }
    Ok(())
}

fn figure(value: Option<f64>) -> String {
    value.map_or_else(|| "none".into(), significant)
}
