//! Running the program as a user would.

use std::{
    path::Path,
    process::{Command, Output},
};

/// The program in `folder`, with no cache, no colour and no test data.
pub fn dapple(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_dapple"));
    command
        .current_dir(folder)
        .env("DAPPLE_CACHE", "off")
        .env("NO_COLOR", "1")
        .env_remove("DAPPLE_DATA")
        .env_remove("DAPPLE_REQUIRE_GPU");
    command
}

/// Runs the program with `arguments`.
pub fn run(folder: &Path, arguments: &[&str]) -> Output {
    dapple(folder).args(arguments).output().expect("the program starts")
}

/// Standard error as text.
pub fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}
