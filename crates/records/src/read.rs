//! Reading record files that may be torn, mixed with foreign lines, or damaged.

pub(crate) mod blocks;
pub(crate) mod scan;

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use crate::claim::ClaimLine;
use crate::error::RecordError;
use crate::gate::GateLine;
use crate::line::{Line, RunHeader};
use crate::read::blocks::Blocks;
use crate::read::scan::{Found, scan};
use crate::row::Row;
use crate::stress::StressLine;

/// Every line of ours begins so. The text cannot occur inside a JSON string (its quotes would be
/// escaped), so it marks a line's start even where a line feed was lost.
pub(crate) const START: &[u8] = br#"{"kind":""#;

/// Bytes that a line may have. A longer one is not held in memory: it is skipped, less whole lines
/// that stand inside it.
pub const LONGEST_LINE: usize = 64 << 20;

/// What was read, and what was not.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Read {
    /// One a run, the last wins.
    pub headers: Vec<RunHeader>,
    /// One for each (run, group, row), the last wins; in the order of the lines that won.
    pub rows: Vec<Row>,
    /// Gates, one for each (run, problem, technique, gate), the last wins.
    pub gates: Vec<GateLine>,
    /// Claims, one for each (run, problem, id), the last wins.
    pub claims: Vec<ClaimLine>,
    /// Stress points, one for each (run, problem, case, technique, variant, form, axis, value),
    /// the last wins.
    pub stress: Vec<StressLine>,
    /// Runs that are complete.
    pub ended: BTreeSet<String>,
    /// Lines that were left out: the first [`MOST_SKIPPED`] of them.
    pub skipped: Vec<Skipped>,
    /// How many lines were left out in all, by the kind of reason.
    pub reasons: BTreeMap<&'static str, usize>,
}

/// Skipped lines that are kept one by one; of a file of noise the rest are only counted.
pub const MOST_SKIPPED: usize = 1000;

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

/// Reads one file, line by line: memory holds what is kept, not the file. Bad lines are skipped
/// and listed.
///
/// # Errors
/// [`RecordError::Io`] only.
pub fn read_file(path: &Path) -> Result<Read, RecordError> {
    let file = File::open(path).map_err(|e| RecordError::io("read", path, e))?;
    read_from(path, file)
}

/// Reads the lines of a stream; `path` is its name in what was skipped.
///
/// # Errors
/// [`RecordError::Io`] only.
pub fn read_from(path: &Path, reader: impl io::Read) -> Result<Read, RecordError> {
    let mut read = Read::default();
    read.add(path, reader).map_err(|e| RecordError::io("read", path, e))?;
    read.last_wins();
    Ok(read)
}

/// Reads every `*.jsonl` file of a directory (not of folders in it), in the order of their names.
/// A file that cannot be read (to its end) is listed in `skipped`.
///
/// # Errors
/// [`RecordError::Io`] if the directory cannot be listed.
pub fn read_dir(dir: &Path) -> Result<Read, RecordError> {
    let mut read = Read::default();
    for path in files(dir)? {
        if let Err(error) = File::open(&path).and_then(|file| read.add(&path, file)) {
            let skipped = Skipped { path, line: 0, reason: error.to_string() };
            skip(&mut read.skipped, &mut read.reasons, UNREADABLE, skipped);
        }
    }
    read.last_wins();
    Ok(read)
}

/// The kind of reason for a whole file.
pub(crate) const UNREADABLE: &str = "files that cannot be read";

/// The newest file (by name) in `dir` whose run has this sweep hash and machine, if that run has
/// no `end` line. None if it is complete, or there is none, or no such directory.
///
/// The sweep hash must cover whatever makes rows of the two runs incomparable, e.g. the revision.
pub fn unfinished(dir: &Path, sweep_hash: &str, machine: &str) -> Option<PathBuf> {
    files(dir).ok()?.into_iter().rev().find_map(|path| {
        let read = read_file(&path).ok()?;
        // Rows are appended to the file's last run.
        let header = read.headers.last()?;
        let same = header.sweep_hash == sweep_hash && header.machine == machine;
        same.then(|| (!read.ended.contains(&header.run)).then_some(path))
    })?
}

pub(crate) fn files(dir: &Path) -> Result<Vec<PathBuf>, RecordError> {
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
    /// How many lines (or whole files) were left out.
    pub fn skipped_count(&self) -> usize {
        self.reasons.values().sum()
    }

    /// How many lines (or whole files) were left out by the kind of reason, worded to follow a
    /// number, e.g. `of a later schema`.
    pub fn skipped_by_reason(&self) -> &BTreeMap<&'static str, usize> {
        &self.reasons
    }

    fn add(&mut self, path: &Path, reader: impl io::Read) -> io::Result<()> {
        self.add_blocks(path, Blocks::new(reader, 0, 1))
    }

    fn add_blocks<R: io::Read>(&mut self, path: &Path, mut blocks: Blocks<R>) -> io::Result<()> {
        while let Some(block) = blocks.next()? {
            scan(&block, Line::parse, &mut |found| match found {
                Found::Line { item, .. } => self.keep(item),
                Found::Skipped { line, kind, reason } => {
                    let path = path.to_path_buf();
                    skip(&mut self.skipped, &mut self.reasons, kind, Skipped { path, line, reason })
                }
            });
        }
        Ok(())
    }

    fn keep(&mut self, line: Line) {
        match line {
            Line::Header(header) => self.headers.push(*header),
            Line::Row(row) => self.rows.push(*row),
            Line::Gate(gate) => self.gates.push(*gate),
            Line::Claim(claim) => self.claims.push(*claim),
            Line::Stress(point) => self.stress.push(*point),
            Line::End(end) => {
                self.ended.insert(end.run);
            }
        }
    }

    fn last_wins(&mut self) {
        self.headers = last_wins(std::mem::take(&mut self.headers), |h| h.run.clone());
        self.rows = last_wins(std::mem::take(&mut self.rows), |r| {
            (r.run.clone(), r.group.clone(), r.row.clone())
        });
        self.gates = last_wins(std::mem::take(&mut self.gates), |g| {
            [&g.run, &g.problem, &g.technique, &g.gate].map(Clone::clone)
        });
        self.claims = last_wins(std::mem::take(&mut self.claims), |c| {
            [&c.run, &c.problem, &c.id].map(Clone::clone)
        });
        self.stress = last_wins(std::mem::take(&mut self.stress), |s| {
            let names = [&s.run, &s.problem, &s.case, &s.technique, &s.variant, &s.form, &s.axis];
            (names.map(Clone::clone), s.value.to_bits())
        });
    }
}

/// Lists what was skipped, as far as the list goes, and counts it.
pub(crate) fn skip(
    list: &mut Vec<Skipped>,
    reasons: &mut BTreeMap<&'static str, usize>,
    kind: &'static str,
    skipped: Skipped,
) {
    *reasons.entry(kind).or_default() += 1;
    if list.len() < MOST_SKIPPED {
        list.push(skipped);
    }
}

fn last_wins<T, K: Ord>(items: Vec<T>, key: impl Fn(&T) -> K) -> Vec<T> {
    let last: BTreeMap<K, usize> = items.iter().enumerate().map(|(i, x)| (key(x), i)).collect();
    let keep: BTreeSet<usize> = last.into_values().collect();
    items.into_iter().enumerate().filter(|(i, _)| keep.contains(i)).map(|(_, x)| x).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::fixtures::{config, header, row};

    const ROWS: usize = 6;

    fn parse(bytes: &[u8]) -> Read {
        read_from(Path::new("test.jsonl"), bytes).unwrap()
    }

    fn rows(run: &str) -> Vec<Row> {
        (0..ROWS).map(|i| Row { run: run.to_owned(), ..row(i as u64) }).collect()
    }

    fn file(run: &str) -> Vec<u8> {
        let mut lines = vec![header(run).to_line()];
        lines.extend(rows(run).iter().map(Row::to_line));
        (lines.join("\n") + "\n").into_bytes()
    }

    #[test]
    fn a_whole_file_is_read_whole() {
        let read = parse(&file("a"));
        assert_eq!(read.headers, [header("a")]);
        assert_eq!(read.rows, rows("a"));
        assert!(read.skipped.is_empty() && read.ended.is_empty());
    }

    #[test]
    fn bad_lines_are_skipped_with_their_place_and_reason() {
        let good = row(0).to_line();
        let later = good.replace(r#""schema":1"#, r#""schema":2"#);
        let typed = good.replace(r#""threads":2"#, r#""threads":"two""#);
        let named = good.replace(r#""technique":"#, r#""technik":"#);
        let kind = good.replace(r#"{"kind":"row""#, r#"{"kind":"rows""#);
        assert!([&later, &typed, &named, &kind].iter().all(|line| **line != good));
        let cases: [(&[u8], &str); 9] = [
            (later.as_bytes(), "schema 2 is later than 1"),
            (typed.as_bytes(), "\"threads\" is not a count"),
            (named.as_bytes(), "\"technique\" is missing"),
            (kind.as_bytes(), "unknown kind of line \"rows\""),
            (br#"{"a":1}"#, "\"kind\" is missing"),
            (br#"{"kind":"row"}"#, "\"schema\" is missing"),
            (b"warning: something", "not a JSON object"),
            (b"[1, 2]", "found a list"),
            (b"\xff\xfe\x00", "not a JSON object"),
        ];
        for (bad, reason) in cases {
            let text = [bad, b"\n\n", good.as_bytes()].concat();
            let read = parse(&text);
            assert_eq!(read.rows, [row(0)], "{reason}");
            assert_eq!(read.skipped.len(), 1, "{reason}");
            assert_eq!(read.skipped[0].line, 1);
            assert!(read.skipped[0].reason.contains(reason), "{}", read.skipped[0].reason);
        }
    }

    #[test]
    fn unknown_keys_are_ignored_and_optional_keys_may_be_absent() {
        let line = row(0).to_line().replacen('{', r#"{"kind":"row","colour":["new"],"#, 1);
        assert_eq!(Row::from_line(&line).unwrap(), row(0));
        let least = concat!(
            r#"{"kind":"row","schema":1,"run":"r","row":"i","problem":"p","technique":"t","#,
            r#""form":"cpu","case":"c","status":"ok"}"#
        );
        assert_eq!(Row::from_line(least).unwrap().memory_bytes, 0);
    }

    #[test]
    fn the_last_of_equal_rows_wins_within_its_run_only() {
        let first = Row { memory_bytes: 1, ..row(0) };
        let second = Row { memory_bytes: 2, ..row(0) };
        let other = Row { run: "other".into(), memory_bytes: 3, ..row(0) };
        let text = [&first, &row(1), &other, &second].map(Row::to_line).join("\n");
        assert_eq!(parse(text.as_bytes()).rows, [row(1), other, second]);
    }

    #[test]
    fn a_lost_line_feed_loses_nothing() {
        let text = row(0).to_line() + &row(1).to_line() + "\r\n";
        let read = parse(text.as_bytes());
        assert_eq!(read.rows, [row(0), row(1)]);
        assert!(read.skipped[0].reason.ends_with("; kept 2 whole inside it"));
    }

    #[test]
    fn zeros_left_by_a_power_cut_lose_only_their_line() {
        let text = [&[0; 4096], row(0).to_line().as_bytes(), b"\n"].concat();
        assert_eq!(parse(&text).rows, [row(0)]);
    }

    #[test]
    fn directories_are_read_in_order_and_other_files_left_alone() {
        let dir = tempfile::tempdir().unwrap();
        let newer = Row { memory_bytes: 9, ..row(0) };
        fs::write(dir.path().join("2.jsonl"), newer.to_line()).unwrap();
        fs::write(dir.path().join("1.jsonl"), row(0).to_line() + "\nnoise").unwrap();
        fs::write(dir.path().join("3.json"), row(1).to_line()).unwrap();
        fs::create_dir(dir.path().join("4.jsonl")).unwrap();
        let read = read_dir(dir.path()).unwrap();
        assert_eq!(read.rows, [newer]);
        assert_eq!(read.skipped.len(), 1);
        assert_eq!(
            (read.skipped[0].path.as_path(), read.skipped[0].line),
            (dir.path().join("1.jsonl").as_path(), 2)
        );
        let missing = dir.path().join("missing");
        let error = read_dir(&missing).unwrap_err().to_string();
        assert!(error.contains(&missing.display().to_string()), "{error}");
    }

    proptest! {
        #![proptest_config(config())]

        #[test]
        fn corruption_loses_at_most_the_touched_lines(
            hits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..12),
        ) {
            let clean = file("a");
            let line_of = |at: usize| clean[..at].iter().filter(|&&b| b == b'\n').count();
            let mut damaged = clean.clone();
            let mut touched = BTreeSet::new();
            for (index, byte) in hits {
                let at = index.index(clean.len());
                damaged[at] = byte;
                touched.insert(line_of(at));
                if clean[at] == b'\n' {
                    touched.insert(line_of(at) + 1);
                }
            }
            let read = parse(&damaged);
            // Line 0 is the header, line i + 1 row i.
            for (i, row) in rows("a").iter().enumerate() {
                prop_assert!(touched.contains(&(i + 1)) || read.rows.contains(row), "row {}", i);
            }
            prop_assert!(touched.contains(&0) || read.headers == [header("a")]);
        }

        #[test]
        fn a_torn_file_keeps_every_whole_line_also_with_another_behind_it(
            cut in any::<prop::sample::Index>(),
        ) {
            let clean = file("a");
            let cut = cut.index(clean.len());
            let whole = clean[..cut].iter().filter(|&&b| b == b'\n').count();
            let torn = parse(&clean[..cut]);
            prop_assert!(torn.rows.len() >= whole.saturating_sub(1) && torn.skipped.len() <= 1);
            prop_assert_eq!(&torn.rows[..], &rows("a")[..torn.rows.len()]);

            let both = parse(&[&clean[..cut], &file("b")[..]].concat());
            let mut expected = torn.rows;
            expected.extend(rows("b"));
            prop_assert_eq!(both.rows, expected);
            prop_assert_eq!(both.headers.last(), Some(&header("b")));
        }

        #[test]
        fn foreign_lines_between_ours_lose_nothing(
            noise in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..40), ROWS),
        ) {
            let mut text = Vec::new();
            for (row, noise) in rows("a").iter().zip(&noise) {
                text.extend(noise.iter().filter(|&&b| b != b'\n'));
                text.push(b'\n');
                text.extend(row.to_line().into_bytes());
                text.push(b'\n');
            }
            let read = parse(&text);
            prop_assert_eq!(read.rows, rows("a"));
            prop_assert!(read.skipped.len() <= ROWS);
        }

        #[test]
        fn no_bytes_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
            prop_assert!(parse(&bytes).rows.is_empty());
        }
    }
}
