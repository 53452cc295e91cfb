//! A bounded index of record files: what fronts and lists need of each row, and where the whole
//! line is. The rows themselves stay on disk.
//!
//! A row takes some 200 bytes: its [`Entry`], and its errors and counters exactly, in as few bytes
//! as they need. Names, keys and settings are held once for all rows that share them, as the rows
//! of a sweep do. Gates, claims and stress points are held whole, the latest of each.

mod brief;
mod files;
mod fronts;
mod load;
mod packed;
mod settle;
mod table;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use crate::claim::ClaimLine;
use crate::error::RecordError;
use crate::front::Key;
use crate::gate::GateLine;
use crate::line::{Line, RunHeader};
use crate::read::scan::Ending;
use crate::read::{Skipped, UNREADABLE, files, skip};
use crate::row::Row;
use crate::stress::StressLine;
use brief::Brief;
use files::{Known, News};
use load::Job;
use table::Table;

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
    /// Timed by the adapter's clock; by the wall clock otherwise (see also [`Index::clock`]).
    pub gpu_clock: bool,
    /// Milliseconds since 1970; 0 where the time cannot be read.
    pub time_ms: i64,
    /// Median time; NaN without samples.
    pub median_ns: f64,
    /// Its spread.
    pub mad_ns: f64,
    /// 99th percentile of frames, to seven digits.
    pub p99_ns: f32,
    /// Memory of the technique's own data.
    pub memory_bytes: u64,
    /// The row's identity, as a number.
    pub identity: u64,
    /// `time_ms` says all of the time's text.
    plain_time: bool,
    file: u32,
    offset: u64,
    length: u32,
    /// The run, by the number of its text.
    of_run: u32,
    /// The group as a number: nearly every row of a run has its own, so that texts kept would
    /// outweigh the entries.
    group: u64,
    /// Clock and names of values.
    shape: u32,
    /// Where its values begin.
    values: u32,
}

/// Where a line begins.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Place {
    file: u32,
    offset: u64,
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
    /// Lines left out: the first of them (see [`crate::read::MOST_SKIPPED`]).
    pub skipped: Vec<Skipped>,
    /// How many lines were left out in all, by the kind of reason, worded to follow a number.
    pub reasons: BTreeMap<&'static str, usize>,
    table: Table,
    /// Names of the values of each shape: errors, then counters.
    names: Vec<Vec<String>>,
    files: Vec<Known>,
    ended_runs: BTreeSet<String>,
    /// Of headers, gates, claims and stress points.
    places: [Vec<Place>; 4],
}

impl Index {
    /// Reads a folder.
    ///
    /// # Errors
    /// [`RecordError::Io`] if it cannot be listed.
    pub fn open(folder: &Path) -> Result<Self, RecordError> {
        let mut index = Self { folder: folder.to_path_buf(), ..Self::default() };
        let mut jobs = Vec::new();
        for path in files(folder)? {
            index.begin(&path, &mut jobs);
        }
        index.take(jobs);
        index.entries.shrink_to_fit();
        index.table.values.shrink_to_fit();
        Ok(index)
    }

    /// Reads what was appended since, and new files. True if anything changed, and then positions
    /// have changed too. A folder whose known files shrank, were replaced or vanished is read
    /// anew; one that vanished itself is empty.
    ///
    /// # Errors
    /// [`RecordError::Io`] if the folder is there and cannot be listed; the index stays as it was.
    pub fn refresh(&mut self) -> Result<bool, RecordError> {
        let paths = match files(&self.folder) {
            Ok(paths) => paths,
            Err(RecordError::Io { source, .. }) if source.kind() == ErrorKind::NotFound => {
                let changed = !self.files.is_empty() || !self.skipped.is_empty();
                *self = Self { folder: std::mem::take(&mut self.folder), ..Self::default() };
                return Ok(changed);
            }
            Err(error) => return Err(error),
        };
        let there: BTreeSet<&PathBuf> = paths.iter().collect();
        let mut appended = Vec::new();
        for (number, known) in self.files.iter().enumerate() {
            match known.news() {
                _ if !there.contains(&known.path) => return self.reopen(),
                Ok(News::None) => {}
                Ok(News::Appended) if known.resume().is_some() => appended.push(number),
                Ok(News::Appended | News::Other) | Err(_) => return self.reopen(),
            }
        }
        let known: BTreeSet<PathBuf> = self.files.iter().map(|k| k.path.clone()).collect();
        let fresh: Vec<&PathBuf> = paths.iter().filter(|path| !known.contains(*path)).collect();
        let mut jobs = Vec::new();
        for number in appended {
            if self.go_on(number, &mut jobs).is_err() {
                return self.reopen();
            }
        }
        for path in fresh {
            self.begin(path, &mut jobs);
        }
        let changed = !jobs.is_empty();
        if changed {
            self.take(jobs);
        }
        Ok(changed)
    }

    fn reopen(&mut self) -> Result<bool, RecordError> {
        *self = Self::open(&self.folder)?;
        Ok(true)
    }

    /// Notes a file that is to be read whole.
    fn begin(&mut self, path: &Path, jobs: &mut Vec<Job>) {
        let number = self.files.len() as u32;
        let job = Known::open(path).and_then(|(known, file)| {
            let job = Job::new(number, file, (0, 1), known.length)?;
            Ok((known, job))
        });
        match job {
            Ok((known, job)) => {
                self.files.push(known);
                jobs.push(job);
            }
            Err(error) => {
                let skipped =
                    Skipped { path: path.to_path_buf(), line: 0, reason: error.to_string() };
                // It is tried again at every refresh, and listed once.
                if !self.skipped.contains(&skipped) {
                    skip(&mut self.skipped, &mut self.reasons, UNREADABLE, skipped);
                }
            }
        }
    }

    /// Notes a known file that is to be read on. Half a last line is no longer skipped.
    fn go_on(&mut self, number: usize, jobs: &mut Vec<Job>) -> std::io::Result<()> {
        let old = &self.files[number];
        let from = old.resume().unwrap_or_default();
        let (mut known, file) = Known::open(&old.path)?;
        jobs.push(Job::new(number as u32, file, from, known.length)?);
        known.lines = old.lines;
        if let Ending::Torn { line, skipped: Some(kind), .. } = old.ending {
            self.skipped.retain(|s| s.line != line || s.path != old.path);
            if let Some(count) = self.reasons.get_mut(kind) {
                *count = count.saturating_sub(1);
            }
            self.reasons.retain(|_, count| *count > 0);
        }
        self.files[number] = known;
        Ok(())
    }

    fn take(&mut self, jobs: Vec<Job>) {
        let lines = self.load(jobs);
        self.settle(lines);
    }

    /// An error of a row by metric.
    pub fn error(&self, entry: &Entry, metric: &str) -> Option<f64> {
        let (errors, _, cut) = self.split(entry);
        match errors.iter().position(|name| name == metric) {
            Some(at) => self.table.value(entry, at).or_else(|| self.on_disk(entry, metric, false)),
            None if cut => self.on_disk(entry, metric, false),
            None => None,
        }
    }

    /// An error of a row, else a counter of it.
    pub fn value(&self, entry: &Entry, name: &str) -> Option<f64> {
        if let Some(value) = self.error(entry, name) {
            return Some(value);
        }
        let (errors, counters, cut) = self.split(entry);
        match counters.iter().position(|counter| counter == name) {
            Some(at) => {
                let value = self.table.value(entry, errors.len() + at);
                value.or_else(|| self.on_disk(entry, name, true))
            }
            None if cut => self.on_disk(entry, name, true),
            None => None,
        }
    }

    /// Metrics that a row has, by name.
    pub fn metrics(&self, entry: &Entry) -> &[String] {
        self.split(entry).0
    }

    /// Counters that a row has, by name.
    pub fn counters(&self, entry: &Entry) -> &[String] {
        self.split(entry).1
    }

    /// The row's clock: `gpu`, `wall` or `none`.
    pub fn clock(&self, entry: &Entry) -> &str {
        self.table.shape(entry).map_or("", |shape| self.table.text(shape.clock))
    }

    /// Names of errors and of counters, and whether the row has more.
    fn split(&self, entry: &Entry) -> (&[String], &[String], bool) {
        let names = self.names.get(entry.shape as usize).map_or(&[][..], Vec::as_slice);
        let shape = self.table.shape(entry);
        let errors = shape.map_or(0, |shape| shape.errors as usize).min(names.len());
        let (errors, counters) = names.split_at(errors);
        (errors, counters, shape.is_some_and(|shape| shape.cut))
    }

    fn on_disk(&self, entry: &Entry, name: &str, counter: bool) -> Option<f64> {
        let row = self.row(entry).ok()?;
        if counter {
            row.counters.get(name).map(|&count| count as f64)
        } else {
            row.errors.get(name).copied()
        }
    }

    /// Key of a row.
    pub fn key(&self, entry: &Entry) -> &Key {
        &self.keys[entry.key as usize]
    }

    /// Setting of a row.
    pub fn setting(&self, entry: &Entry) -> &SettingName {
        &self.settings[entry.setting as usize]
    }

    /// The whole row, read from disk.
    ///
    /// # Errors
    /// [`RecordError::Io`] where the file is gone or too short, [`RecordError::Moved`] where
    /// another line stands in the row's place.
    pub fn row(&self, entry: &Entry) -> Result<Row, RecordError> {
        let path =
            self.files.get(entry.file as usize).map_or(self.folder.as_path(), |k| k.path.as_path());
        let mut bytes = vec![0; entry.length as usize];
        File::open(path)
            .and_then(|mut file| {
                file.seek(SeekFrom::Start(entry.offset))?;
                file.read_exact(&mut bytes)
            })
            .map_err(|e| RecordError::io("read a row of", path, e))?;
        match Line::parse(&bytes) {
            Ok(Line::Row(row)) if self.is_of(entry, &Brief::of(&row)) => Ok(*row),
            _ => Err(RecordError::Moved(path.to_path_buf())),
        }
    }

    /// Whether a row is the one that the entry was made of.
    fn is_of(&self, entry: &Entry, row: &Brief<'_>) -> bool {
        let table = &self.table;
        let texts = |numbers: &[u32], texts: &[&str]| {
            numbers.iter().map(|&number| table.text(number)).eq(texts.iter().copied())
        };
        let key = table.keys.items.get(entry.key as usize);
        let setting = table.settings.items.get(entry.setting as usize);
        let bits = |value: Option<f64>| value.unwrap_or(f64::NAN).to_bits();
        key.is_some_and(|key| texts(key, &row.key.each_ref().map(|t| &**t)))
            && setting.is_some_and(|s| texts(s, &[&row.technique, &row.variant, &row.form]))
            && table.text(entry.of_run) == row.run
            && table::group(&row.group) == entry.group
            && table::identity(&row.row) == entry.identity
            && table.time(entry) == row.time
            && self.clock(entry) == row.clock
            && (entry.ended, entry.memory_bytes) == (row.status, row.memory_bytes)
            && entry.median_ns.to_bits() == bits(row.median_ns)
            && entry.mad_ns.to_bits() == bits(row.mad_ns)
    }

    /// Bytes on the heap, about: what grows with the rows exactly, what they share by estimate.
    pub fn heap_bytes(&self) -> usize {
        let names: usize = self.names.iter().flatten().map(|name| name.capacity() + 40).sum();
        let keys = self.keys.len() * (size_of::<Key>() + 9 * 24);
        let settings = self.settings.len() * (size_of::<SettingName>() + 3 * 24);
        let lines = self.headers.len() * (size_of::<RunHeader>() + 400)
            + self.gates.len() * (size_of::<GateLine>() + 400)
            + self.claims.len() * (size_of::<ClaimLine>() + 800)
            + self.stress.len() * (size_of::<StressLine>() + 500)
            + self.skipped.len() * (size_of::<Skipped>() + 200);
        self.entries.capacity() * size_of::<Entry>()
            + self.table.heap_bytes()
            + names
            + keys
            + settings
            + lines
    }
}
