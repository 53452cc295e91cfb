//! `dapple claims`.

use crate::{
    Outcome,
    args::{self, Format},
    feed,
    journal::{self, Journal},
    output::{Table, note, put, significant},
    runner::command_line,
    verbs::open_gpu,
};
use anyhow::Result;
use dapple_gpu::AdapterKind;
use dapple_records::{ClaimFigure, ClaimLine, Line};
use dapple_suite::{
    SuiteError,
    claims::{self, ClaimContext, ClaimReport, Step, Verdict},
    environment::environment,
    problem::Problem,
    problems,
};

/// Judges claims; exit 1 only if a judge could not run: a refuted claim is a result.
pub fn run(args: &args::Claims) -> Result<Outcome> {
    let result = judge(args);
    if args.feed {
        feed::tell_end(&result)?;
    }
    result
}

fn judge(args: &args::Claims) -> Result<Outcome> {
    let chosen: Vec<&'static dyn Problem> = match &args.problem {
        Some(id) => vec![problems::find(id)?],
        None => problems::ALL.to_vec(),
    };
    if let Some(id) = &args.id {
        let known: Vec<_> = chosen.iter().flat_map(|p| p.claims()).map(|claim| claim.id).collect();
        if !known.contains(&id.as_str()) {
            return Err(SuiteError::unknown("claim", id, known).into());
        }
    }
    let gpu = open_gpu(args.adapter.as_ref())?;
    let context = ClaimContext {
        gpu: gpu.as_ref(),
        hardware: gpu.as_ref().is_some_and(|g| g.facts.kind == AdapterKind::Hardware),
    };
    let mut journal = Journal::begin(&args.records, "claims", "", &command_line(), args.feed);
    let adapter = journal::adapter_name(gpu.as_ref());
    let mut told = Ok(());
    let reports = claims::run(&chosen, args.id.as_deref(), &context, |step| {
        let said = match step {
            Step::Planned(total) => journal.planned(total),
            Step::Begun(claim) => journal.stage(claim.id, ""),
            Step::Ended(report) => {
                let line = claim_line(report, &journal.run, &adapter);
                let kept = journal.put(&Line::Claim(Box::new(line)));
                if args.feed { kept } else { kept.and_then(|()| print(report, args.format)) }
            }
        };
        if told.is_ok() {
            told = said;
        }
    });
    told?;
    journal.end();
    if args.format == Format::Csv && !args.feed {
        csv(&reports).print(Format::Csv)?;
    }
    let count = |v: Verdict| reports.iter().filter(|r| r.verdict == Some(v)).count();
    let errors = reports.iter().filter(|r| r.verdict.is_none()).count();
    note!(
        "{} reproduced, {} refuted, {} open, {} need hardware, {errors} could not be judged",
        count(Verdict::Reproduced),
        count(Verdict::Refuted),
        count(Verdict::Open),
        count(Verdict::NeedsHardware)
    );
    Ok(if errors == 0 { Outcome::Ok } else { Outcome::CheckFailed })
}

/// What the records keep of a report.
fn claim_line(report: &ClaimReport, run: &str, adapter: &str) -> ClaimLine {
    let facts = environment();
    ClaimLine {
        run: run.into(),
        time: dapple_records::now(),
        machine: facts.machine.clone(),
        adapter: adapter.into(),
        revision: facts.revision.clone(),
        problem: report.problem.into(),
        id: report.id.into(),
        statement: report.statement.into(),
        place: report.place.into(),
        method: report.method.into(),
        verdict: report.verdict.map_or("error", Verdict::word).into(),
        because: report.because.clone(),
        figures: report
            .figures
            .iter()
            .map(|f| ClaimFigure { what: f.what.clone(), value: f.value, unit: f.unit.into() })
            .collect(),
    }
}

fn print(report: &ClaimReport, format: Format) -> std::io::Result<()> {
    match format {
        Format::Table => {
            put!("{}: {}\n  {}", report.id, verdict(report).to_uppercase(), report.statement)?;
            put!("  source: {}\n  judged: {}", report.place, report.method)?;
            for figure in &report.figures {
                let value = significant(figure.value);
                put!("    {:<58} {value:>10} {}", figure.what, figure.unit)?;
            }
            put!("  because: {}\n", report.because)?;
        }
        // Plain data of strings and numbers: serialising it cannot fail.
        Format::Jsonl => put!("{}", serde_json::to_string(report).unwrap_or_default())?,
        // A table of all, at the end.
        Format::Csv => {}
    }
    Ok(())
}

fn verdict(report: &ClaimReport) -> String {
    report.verdict.map_or("error".to_string(), |v| v.to_string())
}

/// A line a figure; a claim without figures has one line all the same.
fn csv(reports: &[ClaimReport]) -> Table {
    let mut table = Table::new(&["problem", "id", "verdict", "figure", "value", "unit"]);
    for report in reports {
        let head = [report.problem.into(), report.id.into(), verdict(report).into()];
        for figure in &report.figures {
            let rest = [figure.what.clone().into(), figure.value.into(), figure.unit.into()];
            table.row([head.clone(), rest].concat());
        }
        if report.figures.is_empty() {
            table.row([head, Default::default()].concat());
        }
    }
    table
}
