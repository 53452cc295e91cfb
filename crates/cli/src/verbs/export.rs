//! `dapple export`.

use crate::{Outcome, args, output::note, records};
use anyhow::Result;
use dapple_records::export::Export;
use dapple_suite::{SuiteError, problems};
use std::{fs::File, io};

/// Writes rows as CSV: the only format there is, and still asked for by name.
pub fn run(args: &args::Export) -> Result<Outcome> {
    let problem = match &args.problem {
        Some(id) => Some(problems::find(id)?.spec().id),
        None => None,
    };
    let inputs = [args.records.clone()];
    let export = Export::open(&inputs, problem).map_err(SuiteError::from)?;
    if let Some(text) = records::left_out(&export.left_out) {
        note!("{text}");
    }
    if export.rows() == 0 {
        return Err(SuiteError::Usage(format!("no rows in {}", args.records.display())).into());
    }
    match &args.output {
        Some(path) => {
            let file = File::create(path)
                .map_err(SuiteError::io(format!("writing {}", path.display())))?;
            export.write(file).map_err(SuiteError::from)?;
            note!("{}: {} rows", path.display(), export.rows());
        }
        None => export.write(io::stdout().lock()).map_err(SuiteError::from)?,
    }
    Ok(Outcome::Ok)
}
