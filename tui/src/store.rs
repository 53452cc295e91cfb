//! The records as screens see them: the index, and the rows of it that count.

use dapple_records::Index;
use std::path::Path;

/// An index with what follows from it.
#[derive(Clone, Debug, Default)]
pub struct Store {
    /// The index.
    pub index: Index,
    /// Positions of the entries that count (see [`Index::latest`]).
    pub latest: Vec<usize>,
    /// Why the folder could not be read, if so.
    pub trouble: Option<String>,
}

impl Store {
    /// Reads a folder; one that is not there is empty, not an error.
    pub fn open(folder: &Path) -> Self {
        if !folder.exists() {
            let mut index = Index::default();
            index.folder = folder.to_path_buf();
            return Self::of(index);
        }
        match Index::open(folder) {
            Ok(index) => Self::of(index),
            Err(error) => Self { trouble: Some(error.to_string()), ..Self::default() },
        }
    }

    /// From an index.
    pub fn of(index: Index) -> Self {
        Self { latest: index.latest(), index, trouble: None }
    }
}
