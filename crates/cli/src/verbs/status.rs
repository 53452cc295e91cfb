//! `dapple` without a verb: the state of the records, and what to try next.

use crate::{Outcome, output::put};
use anyhow::Result;
use dapple_records::{
    Index,
    index::{Ended, Entry},
};
use dapple_suite::SuiteError;
use std::path::Path;

/// Prints the state.
pub fn run() -> Result<Outcome> {
    let folder = Path::new("records");
    if folder.is_dir() {
        print(&Index::open(folder).map_err(SuiteError::from)?)?;
        put!("\nnext:\n  dapple front                    fronts of these records")?;
    } else {
        put!("no records yet\n\nnext:")?;
    }
    put!(
        "  dapple measure --sweep quick    every technique, under a minute\n  \
         dapple verify                   correctness gates\n  \
         dapple list                     problems, techniques, scenes\n  \
         dapple --help                   all verbs"
    )?;
    Ok(Outcome::Ok)
}

fn print(index: &Index) -> Result<()> {
    let rows = |f: fn(&Entry) -> bool| index.entries.iter().filter(|e| f(e)).count();
    let skipped: usize = index.reasons.values().sum();
    put!(
        "records/: {} runs, {} rows ({} failed, {} not run), {skipped} lines skipped",
        index.headers.len(),
        index.entries.len(),
        rows(|e| e.ended == Ended::Failed),
        rows(|e| e.ended == Ended::NotRun),
    )?;
    for (reason, count) in &index.reasons {
        put!("  skipped: {count} {reason}")?;
    }
    let gates = |word: &str| index.gates.iter().filter(|g| g.outcome == word).count();
    if !index.gates.is_empty() {
        let broken = index.gates.iter().filter(|g| !g.is_ok()).count();
        put!("gates: {} passed, {broken} broken, {} not run", gates("passed"), gates("not-run"))?;
    }
    let claims = |word: &str| index.claims.iter().filter(|c| c.verdict == word).count();
    if !index.claims.is_empty() {
        put!(
            "claims: {} reproduced, {} refuted, {} open, {} need hardware, {} could not be judged",
            claims("reproduced"),
            claims("refuted"),
            claims("open"),
            claims("needs-hardware"),
            claims("error")
        )?;
    }
    if !index.stress.is_empty() {
        let safe = index.stress.iter().filter(|s| s.is_safe()).count();
        put!("stress: {} points, {safe} safe", index.stress.len())?;
    }
    for (header, ended) in index.headers.iter().zip(&index.ended) {
        if !ended {
            let (sweep, time, command) = (&header.sweep, &header.time, &header.command);
            put!("unfinished: {sweep} of {time}; `{command}` resumes it")?;
        }
    }
    Ok(())
}
