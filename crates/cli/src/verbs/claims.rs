//! `dapple claims`.

use crate::{
    Outcome,
    args::{self, Format},
    output::significant,
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
    if args.format == Format::Csv {
        println!("problem,id,verdict,figure,value,unit");
    }
    for problem in &chosen {
        reports.extend(claims::run(*problem, args.id.as_deref(), &context, |report| {
            print(report, args.format);
        }));
    }
    if reports.is_empty() {
        let known: Vec<_> = chosen.iter().flat_map(|p| p.claims()).map(|claim| claim.id).collect();
        let id = args.id.clone().unwrap_or_default();
        return Err(SuiteError::unknown("claim", &id, known).into());
    }
    let count = |v: Verdict| reports.iter().filter(|r| r.verdict == Some(v)).count();
    let errors = reports.iter().filter(|r| r.verdict.is_none()).count();
    eprintln!(
        "{} reproduced, {} refuted, {} open, {} need hardware, {errors} could not be judged",
        count(Verdict::Reproduced),
        count(Verdict::Refuted),
        count(Verdict::Open),
        count(Verdict::NeedsHardware)
    );
    Ok(if errors == 0 { Outcome::Ok } else { Outcome::CheckFailed })
}

fn print(report: &ClaimReport, format: Format) {
    let verdict = report.verdict.map_or("ERROR".to_string(), |v| v.to_string());
    match format {
        Format::Table => {
            println!("{}: {}\n  {}", report.id, verdict.to_uppercase(), report.statement);
            println!("  source: {}\n  judged: {}", report.place, report.method);
            for figure in &report.figures {
                let value = significant(figure.value);
                println!("    {:<58} {value:>10} {}", figure.what, figure.unit);
            }
            println!("  because: {}\n", report.because);
        }
        // Plain data of strings and numbers: serialising it cannot fail.
        Format::Jsonl => println!("{}", serde_json::to_string(report).unwrap_or_default()),
        Format::Csv => {
            for figure in &report.figures {
                let what = figure.what.replace('"', "\"\"");
                let (problem, id) = (report.problem, report.id);
                println!("{problem},{id},{verdict},\"{what}\",{},{}", figure.value, figure.unit);
            }
        }
    }
}
