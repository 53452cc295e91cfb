//! What happens, and what is to be done about it.

use crate::store::Store;
use dapple_records::{FeedLine, Row};
use ratatui::crossterm::event::KeyEvent;
use std::sync::Arc;

/// A child process, by number; never reused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct JobId(pub u64);

/// What happens.
#[derive(Debug)]
pub enum Msg {
    /// A key was pressed.
    Key(KeyEvent),
    /// The terminal has another size.
    Resize,
    /// Time passes: milliseconds since 1970.
    Tick(i64),
    /// The terminal or the system asks to leave at once.
    Terminate,
    /// The records were read.
    Store(Arc<Store>),
    /// Whole rows that a screen asked for.
    Rows {
        /// The request's number.
        request: u64,
        /// The rows, or why not.
        rows: Result<Vec<Row>, String>,
    },
    /// A child said something.
    Heard {
        /// Who.
        job: JobId,
        /// What.
        line: Box<FeedLine>,
    },
    /// A child wrote to its standard error.
    Grumbled {
        /// Who.
        job: JobId,
        /// One line.
        text: String,
    },
    /// A child is gone.
    Ended {
        /// Who.
        job: JobId,
        /// Its exit code; `None` if it was killed or never started.
        code: Option<i32>,
        /// In words.
        how: String,
    },
}

/// What is to be done.
#[derive(Clone, Debug, PartialEq)]
pub enum Effect {
    /// Leave.
    Quit,
    /// Read the records again.
    Reload,
    /// Read whole rows: positions in the index.
    ReadRows {
        /// Number to answer with.
        request: u64,
        /// Positions in `store.index.entries`.
        entries: Vec<usize>,
    },
    /// Start the program with these arguments.
    Start {
        /// Who it will be.
        job: JobId,
        /// Its arguments.
        arguments: Vec<String>,
        /// Whether lines will be written to it; its input is closed at once if not.
        input: bool,
    },
    /// Write a line to a child's standard input.
    Write {
        /// To whom.
        job: JobId,
        /// The line, without its end.
        line: String,
    },
    /// End a child: an interrupt first, so that it can finish its row; a kill if it stays.
    Stop(JobId),
}
