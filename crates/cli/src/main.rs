//! `dapple`: what real-time rendering techniques cost, how wrong they are, where they break.

mod args;
mod feed;
mod figures;
mod journal;
mod output;
mod pictures;
mod records;
mod runner;
mod sources;
mod verbs;

use args::{Args, Verb};
use clap::Parser;
use dapple_suite::SuiteError;
use output::note;
use std::process::ExitCode;

/// How a verb ends when it does not fail: a failed check is a result, not an error.
pub enum Outcome {
    /// Exit code 0.
    Ok,
    /// Exit code 1.
    CheckFailed,
    /// A particular code, e.g. of a case that could not be prepared.
    Code(u8),
}

fn main() -> ExitCode {
    // Without this a closed pipe (`dapple list | head`) panics in the middle of a line.
    die_of_closed_pipes(true);
    let args = Args::parse();
    let result = match args.verb {
        None => verbs::dashboard::run(),
        Some(Verb::List(a)) => verbs::list::run(&a),
        Some(Verb::Doctor(a)) => verbs::doctor::run(&a),
        Some(Verb::Measure(a)) => verbs::measure::run(&a),
        Some(Verb::Front(a)) => verbs::front::run(&a),
        Some(Verb::Verify(a)) => verbs::verify::run(&a),
        Some(Verb::Claims(a)) => verbs::claims::run(&a),
        Some(Verb::Render(a)) => verbs::render::run(&a),
        Some(Verb::Scene(a)) => verbs::scene::run(&a),
        Some(Verb::Stress(a)) => verbs::stress::run(&a),
        Some(Verb::StressAxis) => verbs::stress::serve(),
        Some(Verb::Advise(a)) => verbs::advise::run(&a),
        Some(Verb::Compare(a)) => verbs::compare::run(&a),
        Some(Verb::Report(a)) => verbs::report::run(&a),
        Some(Verb::Merge(a)) => verbs::merge::run(&a),
        Some(Verb::Export(a)) => verbs::export::run(&a),
        Some(Verb::Catalogue) => verbs::catalogue::run(),
        Some(Verb::Live(a)) => verbs::live::run(&a),
        Some(Verb::RunGroup) => verbs::measure::serve(),
    };
    if let Err(error) = &result {
        note!("dapple: {}", chain(error));
    }
    ExitCode::from(exit_code(&result))
}

/// What a verb's end means to a shell.
pub fn exit_code(result: &anyhow::Result<Outcome>) -> u8 {
    match result {
        Ok(Outcome::Ok) => 0,
        Ok(Outcome::CheckFailed) => 1,
        Ok(Outcome::Code(code)) => *code,
        Err(error) => error.downcast_ref::<SuiteError>().map_or(3, SuiteError::exit_code),
    }
}

/// An error with its causes, less those that an outer text already ends in.
pub fn chain(error: &anyhow::Error) -> String {
    let mut text = error.to_string();
    for cause in error.chain().skip(1).map(ToString::to_string) {
        if !text.ends_with(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text
}

/// Whether a closed pipe ends the program at once, as it does other filters, or is an error to
/// the one who writes.
#[cfg(unix)]
pub fn die_of_closed_pipes(die: bool) {
    // SAFETY: both are valid dispositions, and no handler is replaced.
    unsafe {
        libc::signal(libc::SIGPIPE, if die { libc::SIG_DFL } else { libc::SIG_IGN });
    }
}

#[cfg(not(unix))]
pub fn die_of_closed_pipes(_: bool) {}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::Context;

    #[test]
    fn a_cause_is_said_once() {
        let cause = || std::io::Error::other("no space");
        let said: anyhow::Error = SuiteError::io("writing x")(cause()).into();
        assert_eq!(chain(&said), "writing x: no space");
        let context = Err::<(), _>(cause()).context("writing y").unwrap_err();
        assert_eq!(chain(&context), "writing y: no space");
    }
}
