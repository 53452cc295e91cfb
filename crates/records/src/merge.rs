//! Records of several machines or shards as one file.
//!
//! The lines are copied as they are, in an order that depends on nothing but the lines: runs by
//! the time they began, then each run's header, rows, gates, claims, stress points and end. So a
//! merge depends on no order of its inputs, and a merge of a merge is itself, byte for byte.
//! Memory holds a key for each line, not the lines.

use std::collections::{BTreeMap, btree_map::Entry};
use std::fs::{self, File};
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use crate::error::RecordError;
use crate::line::Line;
use crate::row::Row;
use crate::stream::{LeftOut, Placed, lines, record_files};

/// What becomes of the times of rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Times {
    /// Every line is copied as it is.
    Keep,
    /// Rows keep errors and counters: their clock becomes `none`, and samples, passes and ratios
    /// are left out. For a small baseline that is never asked for times.
    Strip,
}

/// What was joined.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Merged {
    /// Files read.
    pub files: usize,
    /// Runs among the lines written.
    pub runs: usize,
    /// Runs of these without an end line: interrupted, or still going on.
    pub unfinished: usize,
    /// Rows written.
    pub rows: usize,
    /// Lines written in all.
    pub lines: usize,
    /// Lines left out because the same line was there already.
    pub duplicates: usize,
    /// Lines left out because a later one with the same key says something else.
    pub replaced: usize,
    /// Damaged and foreign lines.
    pub left_out: LeftOut,
}

/// Where a line stands among all: run, kind, and what tells it from the others of its kind.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    run: String,
    kind: u8,
    names: String,
}

const HEADER: u8 = 0;
const ROW: u8 = 1;
const END: u8 = 5;

/// A line on disk.
struct Kept {
    /// Of lines with one key the later wins; of those at one time the greater hash, so that the
    /// order of the inputs decides nothing.
    time: String,
    hash: [u8; 16],
    file: usize,
    offset: u64,
    length: usize,
}

/// Joins record files (and those of folders) into `output`, which is written beside itself and
/// then renamed: it is there whole, or not at all.
///
/// # Errors
/// - [`RecordError::LaterSchemaIn`] if an input has a line of a later schema: this program cannot
///   know what it would lose.
/// - [`RecordError::Exists`] if `output` is there and not among the inputs.
/// - [`RecordError::Empty`] if no input has a line of ours.
/// - [`RecordError::Changed`] if an input is rewritten meanwhile; [`RecordError::Io`].
///
/// Nothing is written in any of these cases.
pub fn merge(inputs: &[PathBuf], output: &Path, times: Times) -> Result<Merged, RecordError> {
    let files = record_files(inputs)?;
    let replaces = is_among(output, &files);
    if !replaces && output.symlink_metadata().is_ok() {
        return Err(RecordError::Exists(output.to_path_buf()));
    }
    let mut merged = Merged { files: files.len(), ..Merged::default() };
    let kept = collect(&files, &mut merged)?;
    if kept.is_empty() {
        return Err(RecordError::Empty(inputs.to_vec()));
    }

    let mut runs: BTreeMap<&str, (&str, bool)> = BTreeMap::new();
    for (key, line) in &kept {
        let (began, ended) = runs.entry(&key.run).or_default();
        if key.kind == HEADER {
            *began = &line.time;
        }
        *ended |= key.kind == END;
        merged.rows += usize::from(key.kind == ROW);
    }
    merged.runs = runs.len();
    merged.unfinished = runs.values().filter(|(_, ended)| !ended).count();
    merged.lines = kept.len();
    let mut order: Vec<(&str, &str)> =
        runs.iter().map(|(run, (began, _))| (*began, *run)).collect();
    order.sort_unstable();
    let rank: BTreeMap<&str, usize> =
        order.into_iter().enumerate().map(|(i, (_, run))| (run, i)).collect();
    let mut sorted: Vec<(&Key, &Kept)> = kept.iter().collect();
    // Stable: within a run the map's own order stays.
    sorted.sort_by_key(|(key, _)| rank.get(key.run.as_str()).copied());
    write(&files, &sorted, output, replaces, times)?;
    Ok(merged)
}

fn collect(files: &[PathBuf], merged: &mut Merged) -> Result<BTreeMap<Key, Kept>, RecordError> {
    let mut kept: BTreeMap<Key, Kept> = BTreeMap::new();
    for (file, path) in files.iter().enumerate() {
        let mut source = File::open(path).map_err(|e| RecordError::io("read", path, e))?;
        lines(path, &mut merged.left_out, &mut |Placed { line, offset, length }| {
            let hash = hash(&text(&mut source, path, offset, length)?);
            let (key, time) = key(&line);
            let line = Kept { time, hash, file, offset, length };
            match kept.entry(key) {
                Entry::Vacant(place) => {
                    place.insert(line);
                }
                Entry::Occupied(mut place) => {
                    let there = place.get_mut();
                    match there.hash == line.hash {
                        true => merged.duplicates += 1,
                        false => merged.replaced += 1,
                    }
                    if (&there.time, there.hash) < (&line.time, line.hash) {
                        *there = line;
                    }
                }
            }
            Ok(())
        })?;
        if let Some(later) = merged.left_out.later_schema.take() {
            return Err(RecordError::LaterSchemaIn {
                path: later.path,
                line: later.line,
                reason: later.reason,
            });
        }
    }
    Ok(kept)
}

/// What tells a line from all others, and when it was written.
fn key(line: &Line) -> (Key, String) {
    let (kind, run, time, names) = match line {
        Line::Header(header) => (HEADER, &header.run, &header.time, Vec::new()),
        Line::Row(row) => (ROW, &row.run, &row.time, vec![&row.group, &row.row]),
        Line::Gate(gate) => {
            (2, &gate.run, &gate.time, vec![&gate.problem, &gate.technique, &gate.gate])
        }
        Line::Claim(claim) => (3, &claim.run, &claim.time, vec![&claim.problem, &claim.id]),
        Line::Stress(point) => {
            let setting = [&point.technique, &point.variant, &point.form, &point.axis];
            let case = [&point.problem, &point.case];
            (4, &point.run, &point.time, [&case[..], &setting[..]].concat())
        }
        Line::End(end) => (END, &end.run, &end.time, Vec::new()),
    };
    let mut names: String = names.into_iter().flat_map(|name| [name.as_str(), "\n"]).collect();
    if let Line::Stress(point) = line {
        names += &format!("{:016x}{}", point.value.to_bits(), point.label);
    }
    (Key { run: run.clone(), kind, names }, time.clone())
}

fn hash(text: &[u8]) -> [u8; 16] {
    let mut short = [0; 16];
    short.copy_from_slice(&blake3::hash(text).as_bytes()[..16]);
    short
}

fn text(
    source: &mut File,
    path: &Path,
    offset: u64,
    length: usize,
) -> Result<Vec<u8>, RecordError> {
    let mut text = vec![0; length];
    let read = source.seek(SeekFrom::Start(offset)).and_then(|_| source.read_exact(&mut text));
    match read {
        Ok(()) => Ok(text),
        Err(e) if e.kind() == io::ErrorKind::UnexpectedEof => {
            Err(RecordError::Changed(path.to_path_buf()))
        }
        Err(e) => Err(RecordError::io("read", path, e)),
    }
}

fn stripped(text: &[u8]) -> Result<Vec<u8>, RecordError> {
    let mut row = Row::from_line(&String::from_utf8_lossy(text))?;
    // A row that was not timed to begin with keeps what it says of its clock.
    if !row.samples_ns.is_empty() {
        row.clock = "none".into();
    }
    row.samples_ns.clear();
    row.passes_ns.clear();
    row.ratio = None;
    Ok(row.to_line().into_bytes())
}

/// Whether the output is one of the files, by whatever name.
fn is_among(output: &Path, files: &[PathBuf]) -> bool {
    let Ok(output) = fs::canonicalize(output) else { return false };
    files.iter().any(|file| fs::canonicalize(file).is_ok_and(|file| file == output))
}

fn write(
    files: &[PathBuf],
    sorted: &[(&Key, &Kept)],
    output: &Path,
    replaces: bool,
    times: Times,
) -> Result<(), RecordError> {
    let failed = |e| RecordError::io("write", output, e);
    let folder = output.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".merge-").suffix(".tmp");
    // As any new file's, less the user's mask; a temporary file's own would be for its owner alone.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let temporary = builder.tempfile_in(folder).map_err(failed)?;
    let mut sources: BTreeMap<usize, File> = BTreeMap::new();
    let mut out = BufWriter::new(temporary.as_file());
    for (key, line) in sorted {
        let path = &files[line.file];
        let source = match sources.entry(line.file) {
            Entry::Occupied(there) => there.into_mut(),
            Entry::Vacant(place) => {
                place.insert(File::open(path).map_err(|e| RecordError::io("read", path, e))?)
            }
        };
        let text = text(source, path, line.offset, line.length)?;
        if hash(&text) != line.hash {
            return Err(RecordError::Changed(path.clone()));
        }
        let text = match times {
            Times::Strip if key.kind == ROW => stripped(&text)?,
            Times::Keep | Times::Strip => text,
        };
        out.write_all(&text).and_then(|()| out.write_all(b"\n")).map_err(failed)?;
    }
    out.flush().and_then(|()| temporary.as_file().sync_all()).map_err(failed)?;
    drop(out);
    let moved = match replaces {
        true => temporary.persist(output),
        false => temporary.persist_noclobber(output),
    };
    match moved {
        Ok(_) => Ok(()),
        Err(e) if e.error.kind() == io::ErrorKind::AlreadyExists => {
            Err(RecordError::Exists(output.to_path_buf()))
        }
        Err(e) => Err(failed(e.error)),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::fixtures::{config, header, row};
    use crate::line::RunEnd;
    use crate::{ClaimLine, GateLine, StressLine, read_file};

    fn end(run: &str, rows: u64) -> String {
        RunEnd { run: run.into(), time: "2026-01-02T03:04:06.000Z".into(), rows }.to_line()
    }

    /// Every kind of line, of two runs; `n` rows each.
    fn lines_of_two_runs(n: u64) -> Vec<String> {
        let mut all = Vec::new();
        for run in ["b", "a"] {
            all.push(header(run).to_line());
            all.extend(
                (0..n).map(|i| Row { run: run.into(), group: format!("g{i}"), ..row(i) }.to_line()),
            );
            let (run, problem) = (String::from(run), String::from("p"));
            let gate = "\u{e9}".to_owned();
            let technique = "t".to_owned();
            all.push(
                GateLine {
                    run: run.clone(),
                    problem: problem.clone(),
                    technique: technique.clone(),
                    gate,
                    outcome: "passed".into(),
                    ..GateLine::default()
                }
                .to_line(),
            );
            all.push(
                ClaimLine {
                    run: run.clone(),
                    problem: problem.clone(),
                    id: "c".into(),
                    verdict: "open".into(),
                    ..ClaimLine::default()
                }
                .to_line(),
            );
            all.extend([1.0, 2.0].map(|value| {
                StressLine {
                    run: run.clone(),
                    problem: problem.clone(),
                    case: "case".into(),
                    technique: technique.clone(),
                    form: "cpu".into(),
                    axis: "scale".into(),
                    verdict: "safe".into(),
                    value,
                    ..StressLine::default()
                }
                .to_line()
            }));
            all.push(end(&run, n));
        }
        all
    }

    fn write_files(folder: &Path, files: &[Vec<String>]) -> Vec<PathBuf> {
        let write = |(i, lines): (usize, &Vec<String>)| {
            let path = folder.join(format!("{i}.jsonl"));
            fs::write(&path, lines.join("\n")).unwrap();
            path
        };
        files.iter().enumerate().map(write).collect()
    }

    proptest! {
        #![proptest_config(config())]

        #[test]
        fn a_merge_depends_on_no_order_and_a_merge_of_it_is_itself(
            places in prop::collection::vec((0_usize..4, 0_usize..4), 22),
            swap in any::<bool>(),
        ) {
            let lines = lines_of_two_runs(5);
            prop_assert_eq!(lines.len(), places.len());
            let folder = tempfile::tempdir().unwrap();
            // Every line stands in one or two of four files.
            let mut files = vec![Vec::new(); 4];
            for (line, (a, b)) in lines.iter().zip(&places) {
                files[*a].push(line.clone());
                if a != b {
                    files[*b].push(line.clone());
                }
            }
            let mut paths = write_files(folder.path(), &files);
            let doubled = places.iter().filter(|(a, b)| a != b).count();
            let first = folder.path().join("first");
            let merged = merge(&paths, &first, Times::Keep).unwrap();
            prop_assert_eq!((merged.lines, merged.duplicates, merged.replaced), (22, doubled, 0));
            prop_assert_eq!((merged.runs, merged.rows, merged.unfinished), (2, 10, 0));

            paths.reverse();
            if swap {
                paths.swap(0, 2);
            }
            let second = folder.path().join("second");
            merge(&paths, &second, Times::Keep).unwrap();
            let bytes = fs::read(&first).unwrap();
            prop_assert!(bytes == fs::read(&second).unwrap(), "the order of the inputs shows");

            let third = folder.path().join("third");
            merge(&[first.clone(), second, paths[0].clone()], &third, Times::Keep).unwrap();
            prop_assert!(bytes == fs::read(&third).unwrap(), "a merge of merges is another");
            merge(std::slice::from_ref(&first), &first, Times::Keep).unwrap();
            prop_assert!(bytes == fs::read(&first).unwrap(), "in place it is another");

            let read = read_file(&first).unwrap();
            let ours = (read.headers.len(), read.rows.len(), read.gates.len(), read.claims.len());
            prop_assert_eq!(ours, (2, 10, 2, 2));
            prop_assert_eq!((read.stress.len(), read.ended.len(), read.skipped_count()), (4, 2, 0));
        }
    }

    /// Control: without a canonical order, a plain concatenation shows the order of its inputs.
    #[test]
    fn a_concatenation_would_fail_the_property() {
        let lines = lines_of_two_runs(2);
        let (a, b) = lines.split_at(3);
        assert_ne!([a, b].concat(), [b, a].concat());
        let folder = tempfile::tempdir().unwrap();
        let paths = write_files(folder.path(), &[a.to_vec(), b.to_vec()]);
        let out = folder.path().join("out");
        merge(&paths, &out, Times::Keep).unwrap();
        let text = fs::read_to_string(&out).unwrap();
        assert_ne!(text.trim_end(), lines.join("\n"), "the order of the runs was not decided");
    }

    #[test]
    fn the_later_of_two_rows_with_one_key_wins_in_any_order_and_is_counted() {
        let old = Row { memory_bytes: 1, ..row(0) };
        let new = Row { memory_bytes: 2, time: "2026-01-02T03:04:05.679Z".into(), ..row(0) };
        let folder = tempfile::tempdir().unwrap();
        for (i, order) in [[&old, &new], [&new, &old]].iter().enumerate() {
            let files = order.map(|row| vec![row.to_line()]);
            let paths = write_files(folder.path(), &files);
            let out = folder.path().join(format!("out{i}"));
            let merged = merge(&paths, &out, Times::Keep).unwrap();
            assert_eq!((merged.replaced, merged.duplicates, merged.unfinished), (1, 0, 1));
            assert_eq!(read_file(&out).unwrap().rows, std::slice::from_ref(&new));
        }
        // At one time the content decides, not the order.
        let twin = Row { memory_bytes: 3, ..row(0) };
        let outs = [[&old, &twin], [&twin, &old]].map(|order| {
            let paths = write_files(folder.path(), &order.map(|row| vec![row.to_line()]));
            let out = folder.path().join("twins");
            merge(&paths, &out, Times::Keep).unwrap();
            let text = fs::read_to_string(&out).unwrap();
            fs::remove_file(&out).unwrap();
            text
        });
        assert_eq!(outs[0], outs[1]);
    }

    #[test]
    fn unknown_keys_survive_and_damage_is_counted() {
        let folder = tempfile::tempdir().unwrap();
        let future = row(0).to_line().replacen('{', r#"{"kind":"row","colour":"new","#, 1);
        let text = format!("noise\n{future}\n{}", &row(1).to_line()[..40]);
        let input = folder.path().join("in.jsonl");
        fs::write(&input, text).unwrap();
        let out = folder.path().join("out.jsonl");
        let merged = merge(&[input], &out, Times::Keep).unwrap();
        assert_eq!((merged.lines, merged.left_out.reasons.values().sum::<usize>()), (1, 2));
        assert_eq!(fs::read_to_string(&out).unwrap(), future + "\n");
    }

    #[test]
    fn a_later_schema_refuses_the_whole_and_names_its_line() {
        let folder = tempfile::tempdir().unwrap();
        let later = row(1).to_line().replace(r#""schema":1"#, r#""schema":2"#);
        let paths =
            write_files(folder.path(), &[vec![row(0).to_line()], vec![row(2).to_line(), later]]);
        let out = folder.path().join("out");
        let error = merge(&paths, &out, Times::Keep).unwrap_err().to_string();
        assert!(error.contains("1.jsonl line 2: schema 2 is later than 1"), "{error}");
        let left: Vec<_> = fs::read_dir(folder.path()).unwrap().collect();
        assert_eq!(left.len(), 2, "nothing may be written: {left:?}");
    }

    #[test]
    fn a_baseline_keeps_errors_and_counters_and_no_time() {
        let folder = tempfile::tempdir().unwrap();
        let paths = write_files(folder.path(), &[lines_of_two_runs(3)]);
        let outs = ["once", "twice", "whole"].map(|name| folder.path().join(name));
        merge(&paths, &outs[0], Times::Strip).unwrap();
        merge(&outs[..1], &outs[1], Times::Strip).unwrap();
        merge(&paths, &outs[2], Times::Keep).unwrap();
        assert_eq!(fs::read(&outs[0]).unwrap(), fs::read(&outs[1]).unwrap());
        let (stripped, whole) = (read_file(&outs[0]).unwrap(), read_file(&outs[2]).unwrap());
        assert_eq!(stripped.rows.len(), 6);
        for (row, whole) in stripped.rows.iter().zip(&whole.rows) {
            crate::validate(row).unwrap();
            assert_eq!((&row.errors, &row.counters), (&whole.errors, &whole.counters));
            assert!(row.samples_ns.is_empty() && row.passes_ns.is_empty() && row.ratio.is_none());
            assert!(!whole.samples_ns.is_empty());
        }
        assert_eq!(stripped.gates, whole.gates);
    }

    #[test]
    fn no_file_is_overwritten_that_is_not_an_input_and_an_empty_merge_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let paths = write_files(folder.path(), &[vec![row(0).to_line()]]);
        let out = folder.path().join("precious");
        fs::write(&out, "mine").unwrap();
        let error = merge(&paths, &out, Times::Keep).unwrap_err();
        assert!(matches!(error, RecordError::Exists(path) if path == out));
        assert_eq!(fs::read_to_string(&out).unwrap(), "mine");
        // In a folder that is an input, the output of an earlier merge is an input too.
        let again = folder.path().join("all.jsonl");
        for _ in 0..2 {
            merge(&[folder.path().to_path_buf()], &again, Times::Keep).unwrap();
        }
        let empty = folder.path().join("empty.jsonl");
        fs::write(&empty, "\n").unwrap();
        let error = merge(&[empty], &folder.path().join("none"), Times::Keep).unwrap_err();
        assert!(error.to_string().contains("empty.jsonl"), "{error}");
        assert!(!folder.path().join("none").exists());
        let missing =
            merge(&[folder.path().join("missing")], &folder.path().join("none"), Times::Keep);
        assert!(matches!(missing, Err(RecordError::Io { .. })));
    }
}
