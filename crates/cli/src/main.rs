//! `dapple`: what real-time rendering techniques cost, how wrong they are, where they break.

mod args;
mod figures;
mod output;
mod verbs;

use args::{Args, Verb};
use clap::Parser;
use dapple_suite::SuiteError;
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
    reset_pipe_signal();
    let args = Args::parse();
    let result = match args.verb {
        None => verbs::status::run(),
        Some(Verb::List(a)) => verbs::list::run(&a),
        Some(Verb::Doctor(a)) => verbs::doctor::run(&a),
        Some(Verb::Measure(a)) => verbs::measure::run(&a),
        Some(Verb::Front(a)) => verbs::front::run(&a),
        Some(Verb::Verify(a)) => verbs::verify::run(&a),
        Some(Verb::Claims(a)) => verbs::claims::run(&a),
        Some(Verb::Render(a)) => verbs::render::run(&a),
        Some(Verb::Scene(a)) => verbs::scene::run(&a),
        Some(Verb::RunGroup) => verbs::measure::serve(),
    };
    match result {
        Ok(Outcome::Ok) => ExitCode::SUCCESS,
        Ok(Outcome::CheckFailed) => ExitCode::from(1),
        Ok(Outcome::Code(code)) => ExitCode::from(code),
        Err(error) => {
            eprintln!("dapple: {error:#}");
            let code = error.downcast_ref::<SuiteError>().map_or(3, SuiteError::exit_code);
            ExitCode::from(code)
        }
    }
}

#[cfg(unix)]
fn reset_pipe_signal() {
    // SAFETY: called once, before any thread is started; SIG_DFL is a valid disposition.
    unsafe {
        libc::signal(libc::SIGPIPE, libc::SIG_DFL);
    }
}

#[cfg(not(unix))]
fn reset_pipe_signal() {}
