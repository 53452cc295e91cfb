//! `dapple verify`.

use crate::{
    Outcome,
    args::{self, VerifyFormat},
    feed,
    journal::{self, Journal},
    output::{Table, note, put, significant},
    runner::command_line,
    verbs::open_gpu,
};
use anyhow::Result;
use dapple_records::{GateLine, Line};
use dapple_suite::{
    SuiteError,
    environment::environment,
    problem::Problem,
    problems,
    verify::{self, GateContext, GateReport, Outcome as GateOutcome, Step},
};

/// Random cases a property unless asked otherwise.
const DEFAULT_CASES: u32 = 64;

/// Runs the gates; exit 1 if one is broken, a control was missed, or a technique has none.
pub fn run(args: &args::Verify) -> Result<Outcome> {
    let result = verify(args);
    if args.feed {
        feed::tell_end(&result)?;
    }
    result
}

fn verify(args: &args::Verify) -> Result<Outcome> {
    let chosen: Vec<&'static dyn Problem> = match &args.problem {
        Some(id) => vec![problems::find(id)?],
        None => problems::ALL.to_vec(),
    };
    if let Some(technique) = &args.technique {
        let known: Vec<_> = chosen.iter().flat_map(|p| p.spec().techniques).map(|t| t.id).collect();
        if !known.contains(&technique.as_str()) {
            return Err(SuiteError::unknown("technique", technique, known).into());
        }
    }
    let gpu = open_gpu(args.adapter.as_ref())?;
    let wanted = std::env::var("PROPTEST_CASES").ok().and_then(|text| text.parse().ok());
    let context = GateContext {
        gpu: gpu.as_ref(),
        cases: args.cases.or(wanted).unwrap_or(DEFAULT_CASES).max(1),
        seed: args.seed,
        deep: args.deep,
    };
    let depth = if context.deep { ", deep" } else { "" };
    let key = format!("{} cases, seed {}{depth}", context.cases, context.seed);
    let mut journal = Journal::begin(&args.records, "verify", &key, &command_line(), args.feed);
    let adapter = journal::adapter_name(gpu.as_ref());
    let mut told = Ok(());
    let reports = verify::run(&chosen, args.technique.as_deref(), &context, |step| {
        let said = match step {
            Step::Planned(total) => journal.planned(total),
            Step::Begun(gate) => journal.stage(&gate.name, &gate.technique),
            Step::Ended(report) => {
                if !report.is_ok() {
                    note!("{} {}: {:?}", report.technique, report.gate, report.outcome);
                }
                let line = gate_line(report, &journal.run, &adapter);
                journal.put(&Line::Gate(Box::new(line)))
            }
        };
        if told.is_ok() {
            told = said;
        }
    });
    told?;
    journal.end();
    if !args.feed {
        print(args.format, &reports)?;
    }
    let mut ok = reports.iter().all(GateReport::is_ok);
    for problem in &chosen {
        let holes =
            if args.technique.is_none() { verify::ungated(*problem, &reports) } else { Vec::new() };
        for technique in holes {
            note!("{}: nothing was checked for {technique}", problem.spec().id);
            ok = false;
        }
    }
    let checked: u64 = reports.iter().map(|r| r.checked).sum();
    let count = |o: GateOutcome| reports.iter().filter(|r| r.outcome == o).count();
    let broken = reports.iter().filter(|r| !r.is_ok()).count();
    note!(
        "{} gates passed with their controls, {broken} broken, {} not run; {checked} checks",
        count(GateOutcome::Passed),
        count(GateOutcome::NotRun),
    );
    if checked == 0 {
        note!("nothing was checked");
        ok = false;
    }
    Ok(if ok { Outcome::Ok } else { Outcome::CheckFailed })
}

/// What the records keep of a report.
fn gate_line(report: &GateReport, run: &str, adapter: &str) -> GateLine {
    let facts = environment();
    GateLine {
        run: run.into(),
        time: dapple_records::now(),
        machine: facts.machine.clone(),
        adapter: adapter.into(),
        revision: facts.revision.clone(),
        problem: report.problem.into(),
        technique: report.technique.clone(),
        gate: report.gate.clone(),
        statement: report.statement.into(),
        outcome: report.outcome.word().into(),
        checked: report.checked,
        failed: report.failed,
        worst: report.worst,
        bound: report.bound,
        fault: report.fault.into(),
        detail: report.detail.clone(),
    }
}

fn print(format: VerifyFormat, reports: &[GateReport]) -> Result<()> {
    match format {
        VerifyFormat::Table => {
            print_table(reports)?;
            put!("\nchecks by technique: {}", by_technique(reports))?;
        }
        VerifyFormat::Jsonl => {
            for report in reports {
                put!("{}", serde_json::to_string(report)?)?;
            }
        }
        VerifyFormat::Junit => put!("{}", junit(reports))?,
    }
    Ok(())
}

/// `vsm 21890, hard 20490, ...`, in the order of the gates.
fn by_technique(reports: &[GateReport]) -> String {
    let mut sums: Vec<(&str, u64)> = Vec::new();
    for report in reports {
        match sums.iter_mut().find(|(technique, _)| *technique == report.technique) {
            Some((_, sum)) => *sum += report.checked,
            None => sums.push((&report.technique, report.checked)),
        }
    }
    let words: Vec<_> = sums.iter().map(|(technique, sum)| format!("{technique} {sum}")).collect();
    words.join(", ")
}

fn print_table(reports: &[GateReport]) -> Result<()> {
    let mut table =
        Table::new(&["technique", "gate", "outcome", "checked", "worst", "bound", "fault caught"]);
    for r in reports {
        let caught = match r.outcome {
            GateOutcome::Passed => format!("{} ({}x)", r.fault, r.control_failed),
            GateOutcome::NotRun => String::new(),
            GateOutcome::ControlMissed => format!("MISSED: {}", r.fault),
            _ => r.detail.clone(),
        };
        table.row([
            r.technique.clone().into(),
            r.gate.clone().into(),
            r.outcome.word().into(),
            r.checked.into(),
            r.worst.map(significant).into(),
            r.bound.map(significant).into(),
            caught.into(),
        ]);
    }
    table.print(args::Format::Table)
}

/// JUnit's XML, one suite a problem.
fn junit(reports: &[GateReport]) -> String {
    let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n");
    let mut problems: Vec<_> = reports.iter().map(|r| r.problem).collect();
    problems.dedup();
    for problem in problems {
        let of: Vec<_> = reports.iter().filter(|r| r.problem == problem).collect();
        let failures = of.iter().filter(|r| !r.is_ok()).count();
        let skipped = of.iter().filter(|r| r.outcome == GateOutcome::NotRun).count();
        xml += &format!(
            "  <testsuite name=\"{problem}\" tests=\"{}\" failures=\"{failures}\" skipped=\"{skipped}\">\n",
            of.len()
        );
        for r in of {
            let (class, name) = (escape(&r.technique), escape(&r.gate));
            xml += &format!("    <testcase classname=\"{problem}.{class}\" name=\"{name}\"");
            xml += &match r.outcome {
                GateOutcome::Passed => "/>\n".to_string(),
                GateOutcome::NotRun => {
                    format!("><skipped message=\"{}\"/></testcase>\n", escape(&r.detail))
                }
                outcome => format!(
                    "><failure message=\"{outcome:?}: {}\"/></testcase>\n",
                    escape(&r.detail)
                ),
            };
        }
        xml += "  </testsuite>\n";
    }
    xml + "</testsuites>"
}

fn escape(text: &str) -> String {
    // Control characters are no XML at all, not even escaped.
    let text: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let text = text.replace('&', "&amp;").replace('<', "&lt;");
    text.replace('>', "&gt;").replace('"', "&quot;")
}
