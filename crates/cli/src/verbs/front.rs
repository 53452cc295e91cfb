//! `dapple front`.

use crate::{Outcome, args, figures, records};
use anyhow::Result;
use dapple_suite::{SuiteError, problems};

/// Prints fronts from records.
pub fn run(args: &args::Front) -> Result<Outcome> {
    let mut rows = records::read(&args.records)?.rows;
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
