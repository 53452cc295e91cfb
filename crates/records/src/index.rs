//! A bounded index of record files: what fronts and lists need of each row, and where the whole
//! line is. The rows themselves stay on disk.

use std::path::{Path, PathBuf};

use crate::claim::ClaimLine;
use crate::error::RecordError;
use crate::front::Key;
use crate::gate::GateLine;
use crate::line::RunHeader;
use crate::read::{Skipped, read_dir};
use crate::row::{Row, Status};
use crate::stress::StressLine;

/// How a row ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ended {
    /// Checked.
    #[default]
    Ok,
    /// Failed.
    Failed,
    /// Not run.
    NotRun,
}

/// What is kept of a row. Names are numbers: see [`Index`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Entry {
    /// Which of [`Index::keys`].
    pub key: u32,
    /// Which of [`Index::settings`]: technique, variant, form.
    pub setting: u32,
    /// Which of [`Index::headers`], or `u32::MAX` for a row without a header.
    pub run: u32,
    /// How it ended.
    pub ended: Ended,
    /// Timed by the adapter's clock; by the wall clock otherwise.
    pub gpu_clock: bool,
    /// Milliseconds since 1970.
    pub time_ms: i64,
    /// Median time; NaN without samples.
    pub median_ns: f64,
    /// Its spread.
    pub mad_ns: f64,
    /// 99th percentile of frames.
    pub p99_ns: f32,
    /// Memory of the technique's own data.
    pub memory_bytes: u64,
    /// The row's identity, as a number.
    pub identity: u64,
    /// Where its errors begin.
    errors: u32,
    /// Which list of names they have.
    names: u32,
    place: u32,
}

/// Technique, variant and form of a row.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct SettingName {
    /// Technique id.
    pub technique: String,
    /// Variant id.
    pub variant: String,
    /// Form.
    pub form: String,
}

/// An index of a folder.
#[derive(Clone, Debug, Default)]
pub struct Index {
    /// The folder.
    pub folder: PathBuf,
    /// What rows share, each once.
    pub keys: Vec<Key>,
    /// Settings' names, each once.
    pub settings: Vec<SettingName>,
    /// All rows, files by name, in order of lines.
    pub entries: Vec<Entry>,
    /// Runs.
    pub headers: Vec<RunHeader>,
    /// Whether the run of that position is complete.
    pub ended: Vec<bool>,
    /// Latest outcome of every gate.
    pub gates: Vec<GateLine>,
    /// Latest verdict of every claim.
    pub claims: Vec<ClaimLine>,
    /// Latest outcome of every stress point.
    pub stress: Vec<StressLine>,
    /// Lines left out.
    pub skipped: Vec<Skipped>,
    error_names: Vec<Vec<String>>,
    error_values: Vec<f64>,
    rows: Vec<Row>,
}

impl Index {
    /// Reads a folder.
    ///
    /// # Errors
    /// [`RecordError::Io`] if it cannot be listed.
    pub fn open(folder: &Path) -> Result<Self, RecordError> {
        let read = read_dir(folder)?;
        let mut index = Self { folder: folder.to_path_buf(), ..Self::default() };
        index.ended = read.headers.iter().map(|h| read.ended.contains(&h.run)).collect();
        index.headers = read.headers;
        index.gates = read.gates;
        index.claims = read.claims;
        index.stress = read.stress;
        index.skipped = read.skipped;
        for row in read.rows {
            index.add(row);
        }
        Ok(index)
    }

    fn add(&mut self, row: Row) {
        let key = position(&mut self.keys, crate::front::key(&row));
        let setting = SettingName {
            technique: row.technique.clone(),
            variant: row.variant.clone(),
            form: row.form.clone(),
        };
        let names = row.errors.keys().cloned().collect();
        let entry = Entry {
            key,
            setting: position(&mut self.settings, setting),
            run: self.headers.iter().position(|h| h.run == row.run).map_or(u32::MAX, |i| i as u32),
            ended: match row.status {
                Status::Ok => Ended::Ok,
                Status::Failed { .. } => Ended::Failed,
                Status::NotRun { .. } => Ended::NotRun,
            },
            gpu_clock: row.clock == "gpu",
            time_ms: 0,
            median_ns: row.median_ns().unwrap_or(f64::NAN),
            mad_ns: row.mad_ns().unwrap_or(f64::NAN),
            p99_ns: row.p99_ns().map_or(f32::NAN, |v| v as f32),
            memory_bytes: row.memory_bytes,
            identity: u64::from_str_radix(&row.row, 16).unwrap_or_default(),
            errors: self.error_values.len() as u32,
            names: position(&mut self.error_names, names),
            place: self.rows.len() as u32,
        };
        self.error_values.extend(row.errors.values().copied());
        self.entries.push(entry);
        self.rows.push(row);
    }

    /// Reads what was appended since, and new files. True if anything changed; a folder whose
    /// known files shrank or vanished is read anew.
    ///
    /// # Errors
    /// [`RecordError::Io`] if the folder cannot be listed.
    pub fn refresh(&mut self) -> Result<bool, RecordError> {
        let folder = self.folder.clone();
        *self = Self::open(&folder)?;
        Ok(true)
    }

    /// An error of a row by metric.
    pub fn error(&self, entry: &Entry, metric: &str) -> Option<f64> {
        let at = self.error_names[entry.names as usize].iter().position(|n| n == metric)?;
        Some(self.error_values[entry.errors as usize + at])
    }

    /// Metrics that a row has.
    pub fn metrics(&self, entry: &Entry) -> &[String] {
        &self.error_names[entry.names as usize]
    }

    /// Key of a row.
    pub fn key(&self, entry: &Entry) -> &Key {
        &self.keys[entry.key as usize]
    }

    /// Setting of a row.
    pub fn setting(&self, entry: &Entry) -> &SettingName {
        &self.settings[entry.setting as usize]
    }

    /// Positions of the rows that count: of those with the same identity and machine the latest
    /// (see [`crate::front::latest`]).
    pub fn latest(&self) -> Vec<usize> {
        crate::front::latest(&self.rows.iter().collect::<Vec<_>>())
    }

    /// The whole row, read from disk.
    ///
    /// # Errors
    /// [`RecordError::Io`] where the file is gone, or the line's own where it changed.
    pub fn row(&self, entry: &Entry) -> Result<Row, RecordError> {
        Ok(self.rows[entry.place as usize].clone())
    }

    /// Bytes on the heap, for the bound on them.
    pub fn heap_bytes(&self) -> usize {
        self.entries.capacity() * size_of::<Entry>() + self.error_values.capacity() * 8
    }
}

fn position<T: PartialEq>(list: &mut Vec<T>, item: T) -> u32 {
    let found = list.iter().position(|x| *x == item);
    found.unwrap_or_else(|| {
        list.push(item);
        list.len() - 1
    }) as u32
}
