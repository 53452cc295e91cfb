//! The records as screens see them: the index, and the rows of it that count.

use dapple_records::Index;
use std::path::Path;

/// Reasons for which lines were left out that are named; the rest are counted.
const REASONS: usize = 2;

/// An index with what follows from it.
#[derive(Clone, Debug, Default)]
pub struct Store {
    /// The index.
    pub index: Index,
    /// Positions of the entries that count (see [`Index::latest`]).
    pub latest: Vec<usize>,
    /// Why the folder could not be read, if so; then the index is as it was before.
    pub trouble: Option<String>,
}

impl Store {
    /// Reads a folder; one that is not there is empty, not an error.
    pub fn open(folder: &Path) -> Self {
        let mut store = Self::of(empty(folder));
        store.refresh();
        store
    }

    /// From an index.
    pub fn of(index: Index) -> Self {
        Self { latest: index.latest(), index, trouble: None }
    }

    /// Reads what is new. Returns whether anything changed.
    pub fn refresh(&mut self) -> bool {
        let before = self.trouble.take();
        match self.index.refresh() {
            Ok(changed) => {
                if changed {
                    self.latest = self.index.latest();
                }
                changed || before.is_some()
            }
            Err(error) => {
                self.trouble = Some(error.to_string());
                self.trouble != before
            }
        }
    }
}

impl Store {
    /// What of the folder could not be read, for people; none if all could.
    pub fn complaint(&self) -> Option<String> {
        if let Some(trouble) = &self.trouble {
            return Some(trouble.clone());
        }
        let reasons = &self.index.reasons;
        let count: usize = reasons.values().sum();
        let first = self.index.skipped.first()?;
        let mut words: Vec<String> =
            reasons.iter().take(REASONS).map(|(reason, n)| format!("{n} {reason}")).collect();
        if reasons.len() > REASONS {
            words.push("...".into());
        }
        let file = first.path.file_name().unwrap_or_default().to_string_lossy();
        let line = if first.line == 0 { String::new() } else { format!(" line {}", first.line) };
        let skipped = crate::widgets::format::plural(count, "line");
        Some(format!("{skipped} skipped: {}; first in {file}{line}", words.join(", ")))
    }
}

fn empty(folder: &Path) -> Index {
    let mut index = Index::default();
    index.folder = folder.to_path_buf();
    index
}
