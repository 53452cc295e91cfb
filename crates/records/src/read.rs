//! Reading record files that may be torn, mixed with foreign lines, or damaged.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use crate::error::RecordError;
use crate::line::{Line, RunHeader};
use crate::row::Row;

/// Every line of ours begins so. The text cannot occur inside a JSON string (its quotes would be
/// escaped), so it marks a line's start even where a line feed was lost.
const START: &[u8] = br#"{"kind":""#;

/// What was read, and what was not.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Read {
    /// One a run, the last wins.
    pub headers: Vec<RunHeader>,
    /// One for each (run, row), the last wins; in the order of the lines that won.
    pub rows: Vec<Row>,
    /// Runs that are complete.
    pub ended: BTreeSet<String>,
    /// Lines that were left out.
    pub skipped: Vec<Skipped>,
}

/// A line (or whole file) that was left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Skipped {
    /// The file.
    pub path: PathBuf,
    /// From 1; 0 if the whole file could not be read.
    pub line: usize,
    /// Why.
    pub reason: String,
}

/// Reads one file. Bad lines are skipped and listed.
///
/// # Errors
/// [`RecordError::Io`] only.
pub fn read_file(path: &Path) -> Result<Read, RecordError> {
    let mut read = Read::default();
    let bytes = fs::read(path).map_err(|e| RecordError::io("read", path, e))?;
    read.add(path, &bytes);
    read.last_wins();
    Ok(read)
}

/// Reads every `*.jsonl` file of a directory (not of folders in it), in the order of their names.
/// A file that cannot be read is listed in `skipped`.
///
/// # Errors
/// [`RecordError::Io`] if the directory cannot be listed.
pub fn read_dir(dir: &Path) -> Result<Read, RecordError> {
    let mut read = Read::default();
    for path in files(dir)? {
        match fs::read(&path) {
            Ok(bytes) => read.add(&path, &bytes),
            Err(e) => read.skipped.push(Skipped { path, line: 0, reason: e.to_string() }),
        }
    }
    read.last_wins();
    Ok(read)
}

/// The newest file (by name) in `dir` that holds a run with this sweep hash and machine and no
/// `end` line. None if there is none, or no such directory.
///
/// The sweep hash must cover whatever makes rows of the two runs incomparable, e.g. the revision.
pub fn unfinished(dir: &Path, sweep_hash: &str, machine: &str) -> Option<PathBuf> {
    files(dir).ok()?.into_iter().rev().find(|path| {
        read_file(path).is_ok_and(|read| {
            // Rows are appended to the file's last run.
            read.headers.last().is_some_and(|header| {
                header.sweep_hash == sweep_hash
                    && header.machine == machine
                    && !read.ended.contains(&header.run)
            })
        })
    })
}

fn files(dir: &Path) -> Result<Vec<PathBuf>, RecordError> {
    let entries = fs::read_dir(dir).map_err(|e| RecordError::io("list", dir, e))?;
    let mut paths = Vec::new();
    for entry in entries {
        let path = entry.map_err(|e| RecordError::io("list", dir, e))?.path();
        if path.extension().is_some_and(|x| x == "jsonl") && path.is_file() {
            paths.push(path);
        }
    }
    paths.sort();
    Ok(paths)
}

impl Read {
    fn add(&mut self, path: &Path, bytes: &[u8]) {
        for (index, line) in bytes.split(|&b| b == b'\n').enumerate() {
            if line.iter().all(u8::is_ascii_whitespace) {
                continue;
            }
            let mut skip = |reason: String| {
                self.skipped.push(Skipped { path: path.to_path_buf(), line: index + 1, reason });
            };
            match Line::parse(line) {
                Ok(line) => self.keep(line),
                Err(error) => {
                    skip(error.to_string());
                    for part in later_starts(line) {
                        if let Ok(line) = Line::parse(part) {
                            self.keep(line);
                        }
                    }
                }
            }
        }
    }

    fn keep(&mut self, line: Line) {
        match line {
            Line::Header(header) => self.headers.push(header),
            Line::Row(row) => self.rows.push(*row),
            Line::End(end) => {
                self.ended.insert(end.run);
            }
        }
    }

    fn last_wins(&mut self) {
        self.headers = last_wins(std::mem::take(&mut self.headers), |h| h.run.clone());
        self.rows = last_wins(std::mem::take(&mut self.rows), |r| (r.run.clone(), r.row.clone()));
    }
}

/// Whole lines behind half a line: what is left after a torn file was concatenated with another.
fn later_starts(line: &[u8]) -> Vec<&[u8]> {
    let starts: Vec<usize> = (0..line.len()).filter(|&i| line[i..].starts_with(START)).collect();
    let ends = starts.iter().skip(1).copied().chain([line.len()]);
    starts.iter().zip(ends).map(|(&start, end)| &line[start..end]).collect()
}

fn last_wins<T, K: Ord>(items: Vec<T>, key: impl Fn(&T) -> K) -> Vec<T> {
    let last: BTreeMap<K, usize> = items.iter().enumerate().map(|(i, x)| (key(x), i)).collect();
    let keep: BTreeSet<usize> = last.into_values().collect();
    items.into_iter().enumerate().filter(|(i, _)| keep.contains(i)).map(|(_, x)| x).collect()
}
