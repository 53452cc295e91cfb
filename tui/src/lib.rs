//! The dashboard: screens over the records of a folder and over jobs that run beside it.
//!
//! It measures nothing and knows no problem by name. What there is comes from `dapple catalogue`,
//! results come from record files, and work is done by child processes that tell what happens in
//! JSON lines (`dapple_records::feed`). One thread reads the keyboard, one each child, one the
//! records; all feed one channel. [`app::App::update`] turns a message into effects, `view` draws.

pub mod app;
pub mod jobs;
pub mod keys;
pub mod msg;
pub mod plot;
pub mod runtime;
pub mod screens;
pub mod store;
#[cfg(test)]
pub(crate) mod testing;
pub mod theme;
pub mod widgets;

use std::path::PathBuf;

/// How the dashboard is opened.
#[derive(Clone, Debug)]
pub struct Options {
    /// Folder of the records.
    pub records: PathBuf,
    /// The program that jobs are started with.
    pub program: PathBuf,
    /// Whether colours may be used; meaning never depends on them.
    pub colour: bool,
    /// A deliberate fault, to test that the terminal is given back.
    pub fault: Option<Fault>,
}

/// Where the dashboard panics, if asked to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// While it draws.
    View,
    /// In a thread beside the one that draws.
    Thread,
}

/// Errors that end the dashboard.
#[derive(Debug, thiserror::Error)]
pub enum TuiError {
    /// The terminal refused.
    #[error("the terminal: {0}")]
    Terminal(#[from] std::io::Error),
}

/// Runs until the user quits. The terminal is restored whatever happens, a panic included.
///
/// # Errors
/// [`TuiError::Terminal`].
pub fn run(options: &Options) -> Result<(), TuiError> {
    runtime::run(options)
}
