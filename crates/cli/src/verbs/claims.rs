//! `dapple claims`.

use crate::{
    Outcome,
    args::{self, Format},
    output::{Table, note, put, significant},
    verbs::open_gpu,
};
use anyhow::Result;
use dapple_gpu::AdapterKind;
use dapple_suite::{
    SuiteError,
    claims::{self, ClaimContext, ClaimReport, Verdict},
    problem::Problem,
    problems,
};

/// Judges claims; exit 1 only if a judge could not run: a refuted claim is a result.
pub fn run(args: &args::Claims) -> Result<Outcome> {
    let chosen: Vec<&'static dyn Problem> = match &args.problem {
        Some(id) => vec![problems::find(id)?],
        None => problems::ALL.to_vec(),
    };
    let gpu = open_gpu(args.adapter.as_ref())?;
    let context = ClaimContext {
        gpu: gpu.as_ref(),
        hardware: gpu.as_ref().is_some_and(|g| g.facts.kind == AdapterKind::Hardware),
    };
    let mut reports = Vec::new();
    let mut printed = Ok(());
    for problem in &chosen {
        reports.extend(claims::run(*problem, args.id.as_deref(), &context, |report| {
            if printed.is_ok() {
                printed = print(report, args.format);
            }
        }));
    }
    printed?;
    if reports.is_empty() {
        let known: Vec<_> = chosen.iter().flat_map(|p| p.claims()).map(|claim| claim.id).collect();
        let id = args.id.clone().unwrap_or_default();
        return Err(SuiteError::unknown("claim", &id, known).into());
    }
    if args.format == Format::Csv {
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
