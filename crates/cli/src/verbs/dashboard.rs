//! `dapple` without a verb: the dashboard on a terminal, the state of the records elsewhere.

use crate::{Outcome, verbs::status};
use anyhow::Result;
use dapple_tui::{Fault, Options};
use std::io::IsTerminal;

/// Opens the dashboard, or prints the state.
pub fn run() -> Result<Outcome> {
    if !(std::io::stdout().is_terminal() && std::io::stdin().is_terminal()) {
        return status::run();
    }
    dapple_tui::run(&Options {
        records: "records".into(),
        program: std::env::current_exe()?,
        colour: std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty()),
        fault: fault(),
    })?;
    Ok(Outcome::Ok)
}

/// A deliberate panic, for the test that the terminal is given back.
fn fault() -> Option<Fault> {
    match std::env::var("DAPPLE_DASHBOARD_FAULT").ok()?.as_str() {
        "view" => Some(Fault::View),
        "thread" => Some(Fault::Thread),
        _ => None,
    }
}
