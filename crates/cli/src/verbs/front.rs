//! `dapple front`.

use crate::{Outcome, args, figures, output::note};
use anyhow::Result;
use dapple_records::Read;
use dapple_suite::{SuiteError, problems};
use std::path::Path;

/// Prints fronts from records.
pub fn run(args: &args::Front) -> Result<Outcome> {
    let mut rows = read(&args.records)?.rows;
    if let Some(id) = &args.problem {
        let id = problems::find(id)?.spec().id;
        rows.retain(|row| row.problem == id);
    }
    if rows.is_empty() {
        let folder = args.records.display();
        return Err(SuiteError::Usage(format!(
            "no rows in {folder}: `dapple measure --sweep quick` makes some"
        ))
        .into());
    }
    let view = figures::View { metric: args.metric.as_deref(), all: args.all, format: args.format };
    figures::print_fronts(&rows, &view)?;
    Ok(Outcome::Ok)
}

/// Reads a file or a folder, and says what was skipped.
fn read(path: &Path) -> Result<Read, SuiteError> {
    let read = if path.is_dir() {
        dapple_records::read_dir(path)?
    } else {
        dapple_records::read_file(path)?
    };
    if let Some(first) = read.skipped.first() {
        let count = read.skipped.len();
        note!("lines skipped: {count}; the first is line {}: {}", first.line, first.reason);
    }
    Ok(read)
}
