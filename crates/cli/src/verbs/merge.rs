//! `dapple merge`.

use crate::{Outcome, args, output::note, records};
use anyhow::Result;
use dapple_records::{
    RecordError,
    merge::{Merged, Times, merge},
};
use dapple_suite::SuiteError;

/// Joins records and says on standard error what became of them.
pub fn run(args: &args::Merge) -> Result<Outcome> {
    let times = if args.strip_times { Times::Strip } else { Times::Keep };
    let merged = merge(&args.inputs, &args.output, times).map_err(|error| match error {
        // The input is at fault, not the disk.
        RecordError::LaterSchemaIn { .. } | RecordError::Exists(_) | RecordError::Empty(_) => {
            SuiteError::Usage(error.to_string())
        }
        error => error.into(),
    })?;
    if let Some(text) = records::left_out(&merged.left_out) {
        note!("{text}");
    }
    note!("{}", summary(&merged, &args.output.display().to_string()));
    Ok(Outcome::Ok)
}

fn summary(merged: &Merged, output: &str) -> String {
    let Merged { files, runs, unfinished, rows, lines, duplicates, replaced, .. } = merged;
    let mut text = format!(
        "{output}: {rows} rows and {} other lines of {runs} runs from {files} files",
        lines - rows
    );
    for (count, words) in [
        (duplicates, "were there twice"),
        (replaced, "were replaced by a later one of the same key"),
    ] {
        if *count > 0 {
            text += &format!("; {count} lines {words}");
        }
    }
    if *unfinished > 0 {
        text += &format!("; {unfinished} of the runs have no end: interrupted, or still going on");
    }
    text
}
