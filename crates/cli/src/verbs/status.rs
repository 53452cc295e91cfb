//! `dapple` without a verb: the state of the records, and what to try next.

use crate::{Outcome, output::put, records};
use anyhow::Result;
use dapple_records::Status;
use std::path::Path;

/// Prints the state.
pub fn run() -> Result<Outcome> {
    let folder = Path::new("records");
    if folder.is_dir() {
        let read = records::read(folder)?;
        let count = |f: fn(&Status) -> bool| read.rows.iter().filter(|r| f(&r.status)).count();
        put!(
            "records/: {} runs, {} rows ({} failed, {} not run), {} lines skipped",
            read.headers.len(),
            read.rows.len(),
            count(|s| matches!(s, Status::Failed { .. })),
            count(|s| matches!(s, Status::NotRun { .. })),
            read.skipped_count()
        )?;
        for header in read.headers.iter().filter(|h| !read.ended.contains(&h.run)) {
            put!(
                "unfinished: {} of {}; `{}` resumes it",
                header.sweep,
                header.time,
                header.command
            )?;
        }
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
