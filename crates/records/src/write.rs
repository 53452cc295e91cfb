//! Appending rows to a run's file.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind, Read as _, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

use crate::error::RecordError;
use crate::line::{Line, RunEnd, RunHeader};
use crate::read::{LONGEST_LINE, read_file};
use crate::row::Row;
use crate::validate::validate;

/// Appends to one run's file. Each line is one `write` in append mode, synced to the disk: a
/// killed process loses no row whose `append` returned. The file is locked for as long as the
/// writer lives (where the file system knows locks), so that two processes never fill one run.
#[derive(Debug)]
pub struct Writer {
    file: File,
    path: PathBuf,
    run: String,
    rows: BTreeSet<String>,
    /// The file ends in half a line.
    torn: bool,
}

impl Writer {
    /// Creates `<UTC time>-<sweep>-<first 8 of run>.jsonl` in `dir` (made if absent) and writes
    /// the header. Never overwrites.
    ///
    /// # Errors
    /// [`RecordError::Io`] names the directory or file.
    pub fn create(dir: &Path, header: &RunHeader) -> Result<Self, RecordError> {
        fs::create_dir_all(dir).map_err(|e| RecordError::io("create directory", dir, e))?;
        let path = dir.join(file_name(header));
        let file = OpenOptions::new()
            .append(true)
            .create_new(true)
            .open(&path)
            .map_err(|e| RecordError::io("create", &path, e))?;
        lock(&file, &path)?;
        let run = header.run.clone();
        let mut writer = Self { file, path, run, rows: BTreeSet::new(), torn: false };
        writer.line(header.to_line())?;
        Ok(writer)
    }

    /// Opens a run's file to go on where it stopped. Half a last line is closed by a line feed;
    /// the reader skips it.
    ///
    /// # Errors
    /// [`RecordError::InUse`] while another writer has the file, [`RecordError::NoHeader`] if no
    /// `run` line is readable, [`RecordError::Io`] otherwise.
    pub fn resume(path: &Path) -> Result<Self, RecordError> {
        let mut file = OpenOptions::new()
            .read(true)
            .append(true)
            .open(path)
            .map_err(|e| RecordError::io("open", path, e))?;
        lock(&file, path)?;
        let read = read_file(path)?;
        let header =
            read.headers.last().ok_or_else(|| RecordError::NoHeader(path.to_path_buf()))?;
        let torn = !ends_in_line_feed(&mut file).map_err(|e| RecordError::io("read", path, e))?;
        let run = header.run.clone();
        let rows = read.rows.iter().filter(|r| r.run == run).map(|r| r.row.clone()).collect();
        let mut writer = Self { file, path: path.to_path_buf(), run, rows, torn };
        if torn {
            writer.line(String::new())?;
        }
        Ok(writer)
    }

    /// Checks and appends a row.
    ///
    /// # Errors
    /// [`RecordError::Invalid`] or [`RecordError::OtherRun`], and nothing is written;
    /// [`RecordError::Io`] on a full disk and the like: earlier rows are safe, and the row may be
    /// appended again.
    pub fn append(&mut self, row: &Row) -> Result<(), RecordError> {
        validate(row)?;
        if row.run != self.run {
            return Err(RecordError::OtherRun {
                row: row.run.clone(),
                file: self.run.clone(),
                path: self.path.clone(),
            });
        }
        let line = row.to_line();
        if line.len() > LONGEST_LINE {
            return Err(RecordError::Invalid {
                problem: row.problem.clone(),
                technique: row.technique.clone(),
                case: row.case.clone(),
                reason: format!(
                    "its line has {} bytes, a reader takes {LONGEST_LINE}: fewer samples fit",
                    line.len()
                ),
            });
        }
        self.line(line)?;
        self.rows.insert(row.row.clone());
        Ok(())
    }

    /// Appends a gate, a claim or a stress point.
    ///
    /// # Errors
    /// [`RecordError::Kind`] for a line that is none of these; [`RecordError::Io`].
    pub fn append_line(&mut self, line: &Line) -> Result<(), RecordError> {
        match line {
            Line::Gate(_) | Line::Claim(_) | Line::Stress(_) => self.line(line.to_line()),
            Line::Row(_) => Err(RecordError::Kind("row".to_owned())),
            Line::Header(_) => Err(RecordError::Kind("run".to_owned())),
            Line::End(_) => Err(RecordError::Kind("end".to_owned())),
        }
    }

    /// Marks the run as complete; an interrupted run is left without this line, to be resumed.
    ///
    /// # Errors
    /// [`RecordError::Io`].
    pub fn end(&mut self) -> Result<(), RecordError> {
        let end = RunEnd {
            run: self.run.clone(),
            time: crate::time::now(),
            rows: self.rows.len() as u64,
        };
        self.line(end.to_line())
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The run's id.
    pub fn run(&self) -> &str {
        &self.run
    }

    /// Identities of the rows in the file.
    pub fn rows(&self) -> &BTreeSet<String> {
        &self.rows
    }

    fn line(&mut self, mut line: String) -> Result<(), RecordError> {
        if self.torn {
            line.insert(0, '\n');
        }
        if !line.ends_with('\n') {
            line.push('\n');
        }
        // Until the whole line is out, assume that it is not.
        self.torn = true;
        self.file
            .write_all(line.as_bytes())
            .map_err(|e| RecordError::io("append to", &self.path, e))?;
        self.torn = false;
        match self.file.sync_data() {
            Ok(()) => Ok(()),
            // Pipes and some file systems cannot sync; the write itself went through.
            Err(e) if matches!(e.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => {
                Ok(())
            }
            Err(e) => Err(RecordError::io("sync", &self.path, e)),
        }
    }
}

/// Released when the file is closed, also by a crash.
fn lock(file: &File, path: &Path) -> Result<(), RecordError> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(RecordError::InUse(path.to_path_buf())),
        // Some network file systems know no locks: then nothing guards, and nothing fails.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(()),
    }
}

fn ends_in_line_feed(file: &mut File) -> io::Result<bool> {
    if file.seek(SeekFrom::End(0))? == 0 {
        return Ok(true);
    }
    file.seek(SeekFrom::End(-1))?;
    let mut last = [0];
    file.read_exact(&mut last)?;
    Ok(last == *b"\n")
}

/// `20261122T043722Z-quick-0123abcd.jsonl`; characters unfit for file names become `-`.
fn file_name(header: &RunHeader) -> String {
    let time = if header.time.is_empty() { crate::time::now() } else { header.time.clone() };
    let seconds = time.split('.').next().unwrap_or_default();
    let stamp: String = seconds.chars().filter(char::is_ascii_alphanumeric).take(15).collect();
    let safe = |text: &str, most: usize| -> String {
        let fit = |c: char| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' };
        text.chars().take(most).map(fit).collect()
    };
    format!("{stamp}Z-{}-{}.jsonl", safe(&header.sweep, 60), safe(&header.run, 8))
}

/// A run id of 16 hexadecimal digits, from the clock, the process id and a counter.
pub fn new_run_id() -> String {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let nanoseconds = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_nanos();
    let mut hash = blake3::Hasher::new();
    hash.update(&nanoseconds.to_le_bytes());
    hash.update(&std::process::id().to_le_bytes());
    hash.update(&COUNT.fetch_add(1, Ordering::Relaxed).to_le_bytes());
    hash.finalize().to_hex().as_str().chars().take(16).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::{header, row};
    use crate::{read_dir, unfinished};

    const RUN: &str = "0123456789abcdef";

    #[test]
    fn a_row_too_long_to_be_read_again_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let mut writer = Writer::create(dir.path(), &header(RUN)).unwrap();
        let long = Row { truth: "x".repeat(LONGEST_LINE), ..row(0) }.identified();
        let error = writer.append(&Row { run: RUN.into(), ..long }).unwrap_err().to_string();
        assert!(error.contains("a reader takes 67108864"), "{error}");
        writer.append(&Row { run: RUN.into(), ..row(0) }).unwrap();
        assert_eq!(read_file(writer.path()).unwrap().rows.len(), 1);
    }

    #[test]
    fn files_are_named_by_time_sweep_and_run_and_never_overwritten() {
        let dir = tempfile::tempdir().unwrap();
        let records = dir.path().join("a/b");
        let mut writer = Writer::create(&records, &header(RUN)).unwrap();
        let path = records.join("20260102T030405Z-quick-01234567.jsonl");
        assert_eq!(writer.path(), path);
        writer.append(&row(0)).unwrap();
        let error = Writer::create(&records, &header(RUN)).unwrap_err().to_string();
        assert!(error.contains("20260102T030405Z-quick-01234567.jsonl"), "{error}");
        assert_eq!(read_file(&path).unwrap().rows, [row(0)]);

        let odd = RunHeader { sweep: "../\u{e9} x".into(), ..header("r/1") };
        let writer = Writer::create(&records, &odd).unwrap();
        assert_eq!(writer.path(), records.join("20260102T030405Z------x-r-1.jsonl"));
    }

    #[test]
    fn rows_are_on_disk_when_append_returns_and_the_end_is_marked() {
        let dir = tempfile::tempdir().unwrap();
        let mut writer = Writer::create(dir.path(), &header(RUN)).unwrap();
        for n in 0..3 {
            writer.append(&row(n)).unwrap();
            assert_eq!(read_dir(dir.path()).unwrap().rows.len() as u64, n + 1);
        }
        assert_eq!(unfinished(dir.path(), "5eed", "machine").as_deref(), Some(writer.path()));
        assert_eq!(unfinished(dir.path(), "other", "machine"), None);
        assert_eq!(unfinished(dir.path(), "5eed", "other"), None);
        writer.end().unwrap();
        assert_eq!(unfinished(dir.path(), "5eed", "machine"), None);
        let read = read_dir(dir.path()).unwrap();
        assert!(read.ended.contains(RUN) && read.skipped.is_empty());
        // Older unfinished work is of no use once a later run has done it all.
        let old = RunHeader { time: "2025-01-01T00:00:00.000Z".into(), ..header("old") };
        let old = Writer::create(dir.path(), &old).unwrap();
        assert_eq!(unfinished(dir.path(), "5eed", "machine"), None);
        let new = RunHeader { time: "2027-01-01T00:00:00.000Z".into(), ..header("new") };
        let new = Writer::create(dir.path(), &new).unwrap();
        assert_eq!(unfinished(dir.path(), "5eed", "machine").as_deref(), Some(new.path()));
        assert!(old.path() < new.path());
        assert_eq!(unfinished(&dir.path().join("missing"), "5eed", "machine"), None);
    }

    #[test]
    fn a_run_killed_anywhere_resumes_without_losing_or_doubling_a_row() {
        let dir = tempfile::tempdir().unwrap();
        let mut writer = Writer::create(dir.path(), &header(RUN)).unwrap();
        writer.append(&row(0)).unwrap();
        let kept = fs::metadata(writer.path()).unwrap().len();
        writer.append(&row(1)).unwrap();
        let path = writer.path().to_path_buf();
        drop(writer);
        let whole = fs::read(&path).unwrap();
        for cut in (kept as usize..=whole.len()).step_by(7).chain([whole.len() - 1, whole.len()]) {
            fs::write(&path, &whole[..cut]).unwrap();
            let mut writer = Writer::resume(&path).unwrap();
            assert_eq!(writer.run(), RUN);
            assert!(writer.rows().contains(&row(0).row));
            for n in 0..3 {
                if !writer.rows().contains(&row(n).row) {
                    writer.append(&row(n)).unwrap();
                }
            }
            writer.end().unwrap();
            let read = read_file(&path).unwrap();
            assert_eq!(read.rows, [row(0), row(1), row(2)], "cut at {cut}");
            assert!(read.skipped.len() <= 1 && read.ended.contains(RUN));
        }
    }

    #[test]
    fn a_file_without_its_header_cannot_be_resumed() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("torn.jsonl");
        fs::write(&path, "{\"kind\":\"run\",\"sch").unwrap();
        assert!(matches!(Writer::resume(&path), Err(RecordError::NoHeader(p)) if p == path));
        let missing = Writer::resume(&dir.path().join("missing.jsonl"));
        assert!(matches!(missing, Err(RecordError::Io { .. })));
    }

    #[test]
    fn bad_rows_are_refused_and_write_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let mut writer = Writer::create(dir.path(), &header(RUN)).unwrap();
        let before = fs::read(writer.path()).unwrap();
        let mut bad = row(0);
        bad.errors.clear();
        assert!(matches!(writer.append(&bad), Err(RecordError::Invalid { .. })));
        let foreign = Row { run: "other".into(), ..row(0) };
        assert!(matches!(writer.append(&foreign), Err(RecordError::OtherRun { .. })));
        assert_eq!(fs::read(writer.path()).unwrap(), before);
    }

    #[test]
    fn an_unusable_directory_is_named() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("file");
        fs::write(&file, "").unwrap();
        for path in [file.clone(), file.join("below")] {
            let error = Writer::create(&path, &header(RUN)).unwrap_err();
            assert!(matches!(&error, RecordError::Io { path: p, .. } if *p == path), "{error}");
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_an_error_and_the_next_row_starts_a_line_of_its_own() {
        let dir = tempfile::tempdir().unwrap();
        let mut writer = Writer::create(dir.path(), &header(RUN)).unwrap();
        writer.append(&row(0)).unwrap();
        let full = OpenOptions::new().append(true).open("/dev/full").unwrap();
        let disk = std::mem::replace(&mut writer.file, full);
        let error = writer.append(&row(1)).unwrap_err();
        assert!(
            matches!(&error, RecordError::Io { path, source, .. }
                if path == writer.path() && source.kind() == ErrorKind::StorageFull),
            "{error}"
        );
        assert!(!writer.rows().contains(&row(1).row));
        // Space is back; half a line was left behind.
        writer.file = disk;
        writer.file.write_all(b"{\"kind\":\"row\",\"sche").unwrap();
        writer.append(&row(1)).unwrap();
        let read = read_file(writer.path()).unwrap();
        assert_eq!(read.rows, [row(0), row(1)]);
        assert_eq!(read.skipped.len(), 1);
        assert_eq!(read.skipped[0].line, 3);
    }

    #[test]
    fn a_file_has_one_writer_at_a_time_and_any_number_of_readers() {
        let dir = tempfile::tempdir().unwrap();
        let mut first = Writer::create(dir.path(), &header(RUN)).unwrap();
        let path = first.path().to_path_buf();
        let refused = |path: &Path| {
            assert!(matches!(Writer::resume(path), Err(RecordError::InUse(p)) if p == path));
        };
        refused(&path);
        first.append(&row(0)).unwrap();
        assert_eq!(read_file(&path).unwrap().rows, [row(0)]);
        drop(first);
        let mut second = Writer::resume(&path).unwrap();
        refused(&path);
        second.append(&row(1)).unwrap();
        assert_eq!(read_file(&path).unwrap().rows, [row(0), row(1)]);
    }

    #[test]
    fn run_ids_differ() {
        let ids: BTreeSet<String> = (0..1000).map(|_| new_run_id()).collect();
        assert_eq!(ids.len(), 1000);
        assert!(ids.iter().all(|id| id.len() == 16));
    }
}
