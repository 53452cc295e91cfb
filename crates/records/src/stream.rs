//! Files as streams of lines: what merges and exports read in bounded memory.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use crate::error::RecordError;
use crate::line::Line;
use crate::read::blocks::Blocks;
use crate::read::scan::{Found, LATER_SCHEMA, scan};
use crate::read::{Skipped, files, skip};

/// A line of ours: itself, where its text begins in its file, and how many bytes it has.
pub(crate) struct Placed {
    pub line: Line,
    pub offset: u64,
    pub length: usize,
}

/// Lines that were left out: the first of them, and how many by reason.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LeftOut {
    /// The first [`crate::read::MOST_SKIPPED`].
    pub skipped: Vec<Skipped>,
    /// How many in all, worded to follow a number.
    pub reasons: BTreeMap<&'static str, usize>,
    /// The first of a later schema.
    pub later_schema: Option<Skipped>,
}

/// The files that are meant by files and folders, in the order given; those of a folder by name.
///
/// # Errors
/// [`RecordError::Io`] for a folder that cannot be listed.
pub fn record_files(inputs: &[PathBuf]) -> Result<Vec<PathBuf>, RecordError> {
    let mut paths = Vec::new();
    for input in inputs {
        match input.is_dir() {
            true => paths.extend(files(input)?),
            false => paths.push(input.clone()),
        }
    }
    Ok(paths)
}

/// Tells `visit` every line of a file, and keeps a list of those left out.
///
/// # Errors
/// [`RecordError::Io`], and what `visit` returns, at the end of the block that it stands in.
pub(crate) fn lines(
    path: &Path,
    left_out: &mut LeftOut,
    visit: &mut dyn FnMut(Placed) -> Result<(), RecordError>,
) -> Result<(), RecordError> {
    let unreadable = |e| RecordError::io("read", path, e);
    let file = File::open(path).map_err(unreadable)?;
    let mut blocks = Blocks::new(file, 0, 1);
    let mut outcome = Ok(());
    while let Some(block) = blocks.next().map_err(unreadable)? {
        scan(&block, Line::parse, &mut |found| match found {
            Found::Line { offset, length, item } if outcome.is_ok() => {
                outcome = visit(Placed { line: item, offset, length });
            }
            Found::Line { .. } => {}
            Found::Skipped { line, kind, reason } => {
                let skipped = Skipped { path: path.to_path_buf(), line, reason };
                if kind == LATER_SCHEMA {
                    left_out.later_schema.get_or_insert_with(|| skipped.clone());
                }
                skip(&mut left_out.skipped, &mut left_out.reasons, kind, skipped);
            }
        });
        std::mem::replace(&mut outcome, Ok(()))?;
    }
    Ok(())
}
