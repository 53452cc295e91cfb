//! What can go wrong with records.

use std::io;
use std::path::{Path, PathBuf};

/// Errors of reading, checking and writing records.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The file system refused (full disk, missing directory, no permission).
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// What was tried, e.g. `append to`.
        action: &'static str,
        /// The file or directory.
        path: PathBuf,
        /// The system's answer.
        source: io::Error,
    },
    /// A line is not a JSON object.
    #[error("not a JSON object: {0}")]
    Json(String),
    /// A line was written by a later version of this program.
    #[error("schema {found} is later than {latest}, the latest this program reads")]
    LaterSchema {
        /// The line's schema.
        found: u64,
        /// [`crate::SCHEMA`].
        latest: u32,
    },
    /// A file to merge has a line that only a later program understands.
    #[error("{} line {line}: {reason}", path.display())]
    LaterSchemaIn {
        /// The file.
        path: PathBuf,
        /// From 1.
        line: usize,
        /// Which schema.
        reason: String,
    },
    /// A file to write is there already.
    #[error("{} is there already, and is not among the inputs: it is not overwritten", .0.display())]
    Exists(PathBuf),
    /// Nothing to merge.
    #[error("no record in {}", names(.0))]
    Empty(Vec<PathBuf>),
    /// A file was rewritten while it was read.
    #[error("{} changed while it was read", .0.display())]
    Changed(PathBuf),
    /// Text that cannot be written as comma-separated values.
    #[error("cannot write comma-separated values: {0}")]
    Csv(io::Error),
    /// A line of ours has an unknown kind.
    #[error("unknown kind of line {0:?}")]
    Kind(String),
    /// A key that every line of its kind has is absent.
    #[error("key {0:?} is missing")]
    Missing(String),
    /// A key holds the wrong type of value.
    #[error("key {key:?} is not {expected}")]
    Type {
        /// The key as in the file.
        key: String,
        /// What was expected.
        expected: &'static str,
    },
    /// A row breaks a rule of the schema (see [`crate::validate()`]).
    #[error("row of {problem}/{technique} in case {case:?}: {reason}")]
    Invalid {
        /// The row's problem.
        problem: String,
        /// The row's technique.
        technique: String,
        /// The row's case.
        case: String,
        /// The broken rule.
        reason: String,
    },
    /// A row was appended to another run's file.
    #[error("row of run {row:?} appended to the file of run {file:?}: {}", path.display())]
    OtherRun {
        /// The row's run.
        row: String,
        /// The file's run.
        file: String,
        /// The file.
        path: PathBuf,
    },
    /// Another process holds the file.
    #[error("{} is being written by another process", .0.display())]
    InUse(PathBuf),
    /// A row is no longer where it was in its file.
    #[error("{} was changed since it was read: the row is not where it was", .0.display())]
    Moved(PathBuf),
    /// A file to resume has no readable `run` line.
    #[error("{} has no readable run line; it cannot be resumed", .0.display())]
    NoHeader(PathBuf),
}

fn names(paths: &[PathBuf]) -> String {
    paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ")
}

impl RecordError {
    pub(crate) fn io(action: &'static str, path: &Path, source: io::Error) -> Self {
        Self::Io { action, path: path.to_path_buf(), source }
    }
}
