//! What every verb that measures in child processes needs: a way to be stopped, and the options
//! of a run.

use crate::{Outcome, die_of_closed_pipes, feed, output::note};
use anyhow::Result;
use dapple_records::RecordError;
use dapple_suite::{SuiteError, run::Options, shell::quoted};
use std::{
    path::Path,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
};

/// A flag that Ctrl-C and the like set.
pub fn stop_flag() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    // Where no handler can be set, Ctrl-C still ends the program, and the records still resume.
    let _ = ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed));
    stop
}

/// A run of this program's own children, which are started with the verb `child`; a whole one,
/// that may resume.
///
/// # Errors
/// [`SuiteError::Io`] if this program cannot be found.
pub fn options(
    records: &Path,
    adapter: Option<&String>,
    child: &str,
) -> Result<Options, SuiteError> {
    Ok(Options {
        records: records.into(),
        adapter: adapter.cloned(),
        command: command_line(),
        shard: String::new(),
        program: std::env::current_exe().map_err(SuiteError::io("finding this program"))?,
        arguments: vec![child.into()],
        fresh: false,
        fault: None,
    })
}

/// Carries a verb out and, for a dashboard, tells how it ended. One that goes away must not take
/// along what is just being written.
pub fn told_to_the_end(feed: bool, work: impl FnOnce() -> Result<Outcome>) -> Result<Outcome> {
    if !feed {
        return work();
    }
    die_of_closed_pipes(false);
    let result = work();
    // Nobody may be there to hear it.
    let _ = feed::tell_end(&result);
    result
}

/// Says what can be done where another process has the run's records.
pub fn note_in_use<T>(finished: &Result<T, SuiteError>) {
    if let Err(SuiteError::Record(RecordError::InUse(_))) = finished {
        note!("`--fresh` begins a run of its own beside it; each then slows the other");
    }
}

/// As a shell would take it again.
pub fn command_line() -> String {
    let arguments = std::env::args_os().skip(1).map(|a| quoted(&a.to_string_lossy()));
    format!("dapple {}", arguments.collect::<Vec<_>>().join(" "))
}
