//! `dapple render`: one technique on one case as pictures.

use crate::{
    Outcome, args,
    output::{note, put, significant},
    pictures,
    verbs::{
        choice,
        measure::{form, lists, measure_block, pick},
    },
};
use anyhow::Result;
use dapple_gpu::Gpu;
use dapple_suite::{SuiteError, problem::Form, problems, sweep::Sweep};

/// Renders result, truth and signed error map.
pub fn run(args: &args::Render) -> Result<Outcome> {
    let problem = problems::find(&args.problem)?;
    let spec = problem.spec();
    let chosen = pick(&args.technique);
    let technique = spec.technique(&chosen.id)?;
    let form = form(&args.form)?;
    let mut block = measure_block(spec, &args.case)?;
    block.knobs = lists("knob", technique.knobs, &args.knob)?;
    block.technique = vec![chosen];
    block.forms = vec![form];
    let sweep = Sweep { about: String::new(), repeats: 1, limit_s: 600, measure: vec![block] };
    let plan = sweep.plan("render").map_err(|e| match e {
        // The technique exists, so an empty plan means that it has no such form.
        SuiteError::Usage(_) => {
            let forms: Vec<_> = technique.forms.iter().map(ToString::to_string).collect();
            SuiteError::unknown("form", &args.form, forms.iter().map(String::as_str))
        }
        e => e,
    })?;
    if plan.rows() != 1 {
        let rows = plan.rows();
        let text = format!("render takes one scene and one setting, and this names {rows}");
        return Err(SuiteError::Usage(text).into());
    }
    let group = &plan.groups[0];
    let gpu = match form {
        Form::Gpu => Some(Gpu::open(&choice(args.adapter.as_ref())).map_err(SuiteError::from)?),
        Form::Reference | Form::Cpu => None,
    };
    let prepared = problem.prepare(&group.case, gpu.as_ref())?;
    let facts = prepared.facts();
    for note in &facts.notes {
        note!("note: {note}");
    }
    let mut subject = prepared.subject(&group.settings[0])?;
    let checked = subject.check()?;
    let picture = subject.picture()?.ok_or_else(|| {
        SuiteError::Usage(format!("{} has no picture: its output is not an image", spec.id))
    })?;
    pictures::write(&picture, &args.output)?;
    put!("{}: {} against {}", group.settings[0], group.case.name(), facts.truth)?;
    for metric in spec.metrics {
        if let Some(value) = checked.errors.get(metric.name) {
            put!("  {:<16} {:>10} {}", metric.name, significant(*value), metric.unit)?;
        }
    }
    for violation in &checked.violations {
        put!("  violated: {violation}")?;
    }
    put!("pictures: {}", args.output.display())?;
    Ok(if checked.violations.is_empty() { Outcome::Ok } else { Outcome::CheckFailed })
}
