//! `dapple compare`.

mod text;

use crate::{
    Outcome,
    args::{self, CompareFormat, FailOn},
    output::{note, put},
    records,
};
use anyhow::Result;
use dapple_records::{
    Row, Status,
    compare::{Change, Comparison, Options, compare},
};
use dapple_suite::{SuiteError, environment::requires_gpu};
use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

/// Two runs and what became of their rows.
struct Compared<'a> {
    old: &'a [Row],
    new: &'a [Row],
    comparison: &'a Comparison,
    /// Problems and names of cases that share their name with another: they differ in truth.
    same_names: BTreeSet<(&'a str, &'a str)>,
    /// Also what did not change.
    all: bool,
}

/// Compares; exit 1 if something that was named happened.
pub fn run(args: &args::Compare) -> Result<Outcome> {
    check(args)?;
    let (old, new) = (rows(&args.old)?, rows(&args.new)?);
    let options = Options { threshold: args.threshold, any_machine: args.any_machine };
    let comparison = compare(&old, &new, &options);
    if comparison.joined() == 0 {
        let mut text = "the two sides have no row in common".to_string();
        for reason in &comparison.refused {
            text += &format!("; {reason} (--any-machine joins them)");
        }
        return Err(SuiteError::Usage(text).into());
    }
    let same_names = same_names(old.iter().chain(&new));
    let all = args.all;
    let compared = Compared { old: &old, new: &new, comparison: &comparison, same_names, all };
    match args.format {
        CompareFormat::Table => text::table(&compared)?,
        CompareFormat::Jsonl => text::jsonl(&compared)?,
        CompareFormat::Markdown => text::markdown(&compared)?,
    }
    for reason in &comparison.refused {
        note!("not compared: {reason}; --any-machine joins them");
    }
    let superseded = comparison.superseded_old + comparison.superseded_new;
    if superseded > 0 {
        note!("{superseded} rows were measured again later; the latest of each counts");
    }
    let failures = failures(&comparison, &args.fail_on, requires_gpu());
    if failures > 0 {
        let wanted: Vec<_> = args.fail_on.iter().map(|f| word(*f)).collect();
        note!("failed: {failures} rows by --fail-on {}", wanted.join(","));
        return Ok(Outcome::CheckFailed);
    }
    Ok(Outcome::Ok)
}

fn same_names<'a>(rows: impl Iterator<Item = &'a Row>) -> BTreeSet<(&'a str, &'a str)> {
    let mut truths: BTreeMap<(&str, &str), BTreeSet<&str>> = BTreeMap::new();
    // A row that was not prepared knows no truth.
    for row in rows.filter(|row| row.status == Status::Ok) {
        truths.entry((&row.problem, &row.case)).or_default().insert(&row.truth);
    }
    truths.into_iter().filter(|(_, truths)| truths.len() > 1).map(|(case, _)| case).collect()
}

fn check(args: &args::Compare) -> Result<(), SuiteError> {
    if !(args.threshold.is_finite() && args.threshold >= 0.0) {
        return Err(SuiteError::Value {
            what: "flag",
            name: "--threshold".into(),
            value: args.threshold.to_string(),
            limit: "must be a finite share, at least 0".into(),
        });
    }
    if args.any_machine && args.fail_on.contains(&FailOn::Slower) {
        return Err(SuiteError::Usage(
            "--fail-on slower with --any-machine: times of different machines are not judged"
                .into(),
        ));
    }
    Ok(())
}

fn rows(path: &Path) -> Result<Vec<Row>, SuiteError> {
    let rows = records::read(path)?.rows;
    match rows.is_empty() {
        true => Err(SuiteError::Usage(format!("no rows in {}", path.display()))),
        false => Ok(rows),
    }
}

/// Rows to which something named happened. Where an adapter is demanded, a row that is not run for
/// want of one has become worse.
fn failures(comparison: &Comparison, fail_on: &[FailOn], gpu_required: bool) -> usize {
    let fails = |change: &Change| match change {
        Change::Slower => fail_on.contains(&FailOn::Slower),
        Change::Failed | Change::Worse => fail_on.contains(&FailOn::Worse),
        Change::NotRun => gpu_required && fail_on.contains(&FailOn::Worse),
        Change::Counters => fail_on.contains(&FailOn::Counters),
        Change::Gone => fail_on.contains(&FailOn::Gone),
        Change::New | Change::Fixed | Change::Better | Change::Faster => false,
    };
    comparison.pairs.iter().filter(|pair| pair.changes.iter().any(fails)).count()
}

fn word(fail_on: FailOn) -> &'static str {
    match fail_on {
        FailOn::Slower => "slower",
        FailOn::Worse => "worse",
        FailOn::Counters => "counters",
        FailOn::Gone => "gone",
    }
}

/// One line on all rows, and one on their times.
fn summary(compared: &Compared<'_>) -> String {
    let comparison = compared.comparison;
    let counts = comparison.counts();
    let mut words = vec![format!("{} rows compared", comparison.joined())];
    for change in Change::ALL {
        if let Some(count) = counts.get(&change) {
            words.push(format!("{count} {}", change.name()));
        }
    }
    if counts.is_empty() {
        words.push("no change".into());
    }
    let mut text = words.join(", ");
    if let Some(times) = comparison.times() {
        text += &format!(
            "\ntimes after over before: geometric mean {:.3}, spread x/÷ {:.3}, of {} rows; \
             it weighs all rows alike, and a drifting machine moves it",
            times.geometric_mean, times.spread, times.count
        );
        let pairs = comparison.pairs.iter().filter_map(|p| p.time.as_ref());
        let unjudged: Vec<_> = pairs.filter(|t| !t.because.is_empty()).collect();
        if let Some(first) = unjudged.first() {
            text += &format!("\n{} times are not judged: {}", unjudged.len(), first.because);
        }
    }
    text
}

fn put_summary(compared: &Compared<'_>) -> std::io::Result<()> {
    put!("{}", summary(compared))
}
