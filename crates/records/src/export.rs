//! Rows as comma-separated values.

use std::collections::{BTreeSet, HashMap};
use std::io::{self, Write};
use std::path::PathBuf;

use serde_json::Value;

use crate::error::RecordError;
use crate::line::Line;
use crate::row::Row;
use crate::stream::{LeftOut, lines, record_files};

/// Columns that a row has by itself, and in between, marked by a dot at the end or the beginning of
/// a name, where those of its maps stand.
const ORDER: &[&str] = &[
    "run",
    "row",
    "group",
    "problem",
    "technique",
    "variant",
    "form",
    "knob.",
    "case",
    "scene",
    "scene_hash",
    "view",
    "size",
    "truth",
    "adapter",
    "driver",
    "device",
    "cpu",
    "threads",
    "revision",
    "dirty",
    "shader_hash",
    "machine",
    "time",
    "status",
    "stage",
    "reason",
    "error.",
    "port.",
    "counter.",
    "memory_bytes",
    "clock",
    "median_ns",
    "mad_ns",
    "p99_ns",
    "baseline",
    "ratio",
    "pass.",
    "samples_ns",
];

/// Rows to be written: the files were read once, to learn the columns.
#[derive(Debug)]
pub struct Export {
    files: Vec<PathBuf>,
    problem: Option<String>,
    /// By place, then name.
    columns: BTreeSet<(usize, String)>,
    /// Which of the rows read is the last of its key.
    last: HashMap<[u8; 16], usize>,
    /// Damaged and foreign lines.
    pub left_out: LeftOut,
}

impl Export {
    /// Reads files and folders for the rows of one problem, or of all, and their columns: every
    /// key that any of them has. Memory holds a few bytes a row.
    ///
    /// # Errors
    /// [`RecordError::Io`].
    pub fn open(inputs: &[PathBuf], problem: Option<&str>) -> Result<Self, RecordError> {
        let mut export = Self {
            files: record_files(inputs)?,
            problem: problem.map(Into::into),
            columns: BTreeSet::new(),
            last: HashMap::new(),
            left_out: LeftOut::default(),
        };
        let (mut columns, mut last) = (BTreeSet::new(), HashMap::new());
        let mut left_out = LeftOut::default();
        export.visit(&mut left_out, &mut |index, row| {
            last.insert(key(row), index);
            columns.extend(pairs(row).map(|(key, _)| (place(&key), key)));
            Ok(())
        })?;
        (export.columns, export.last, export.left_out) = (columns, last, left_out);
        Ok(export)
    }

    /// How many rows there are: of those with the same run, group and identity the last counts.
    pub fn rows(&self) -> usize {
        self.last.len()
    }

    /// Writes a header and the rows, in the order of the files. Columns of maps (`knob.`,
    /// `error.`, `port.`, `counter.`, `pass.`) are sorted by name. A value that a row has not, or
    /// that is not finite, is an empty cell; `samples_ns` is JSON. The files are read again; a row
    /// that was appended meanwhile is left out.
    ///
    /// # Errors
    /// [`RecordError::Io`] for a file that cannot be read, [`RecordError::Csv`] for an output that
    /// cannot be written.
    pub fn write(&self, out: impl Write) -> Result<(), RecordError> {
        let place_of: HashMap<&str, usize> =
            self.columns.iter().enumerate().map(|(i, (_, name))| (name.as_str(), i)).collect();
        let mut writer = csv::Writer::from_writer(out);
        writer.write_record(self.columns.iter().map(|(_, name)| name)).map_err(unwritten)?;
        self.visit(&mut LeftOut::default(), &mut |index, row| {
            if self.last.get(&key(row)) != Some(&index) {
                return Ok(());
            }
            let mut cells = vec![String::new(); self.columns.len()];
            for (key, value) in pairs(row) {
                if let Some(&i) = place_of.get(key.as_str()) {
                    cells[i] = cell(value);
                }
            }
            writer.write_record(&cells).map_err(unwritten)
        })?;
        writer.flush().map_err(RecordError::Csv)
    }

    /// Tells of every row of the problem, with how many were before it.
    fn visit(
        &self,
        left_out: &mut LeftOut,
        tell: &mut dyn FnMut(usize, &Row) -> Result<(), RecordError>,
    ) -> Result<(), RecordError> {
        let mut count = 0;
        for path in &self.files {
            lines(path, left_out, &mut |placed| match placed.line {
                Line::Row(row) if self.problem.as_ref().is_none_or(|p| *p == row.problem) => {
                    count += 1;
                    tell(count - 1, &row)
                }
                _ => Ok(()),
            })?;
        }
        Ok(())
    }
}

fn unwritten(error: csv::Error) -> RecordError {
    match error.into_kind() {
        csv::ErrorKind::Io(error) => RecordError::Csv(error),
        other => RecordError::Csv(io::Error::other(format!("{other:?}"))),
    }
}

/// All but what every line has: its kind and schema.
fn pairs(row: &Row) -> impl Iterator<Item = (String, Value)> {
    row.object().into_pairs().into_iter().skip(2)
}

fn key(row: &Row) -> [u8; 16] {
    let mut hash = blake3::Hasher::new();
    for text in [&row.run, &row.group, &row.row] {
        hash.update(&(text.len() as u64).to_le_bytes());
        hash.update(text.as_bytes());
    }
    let mut short = [0; 16];
    short.copy_from_slice(&hash.finalize().as_bytes()[..16]);
    short
}

/// Where a column stands; unknown ones at the end.
fn place(key: &str) -> usize {
    let group = key.split_once('.').map_or(key.len(), |(prefix, _)| prefix.len() + 1);
    ORDER.iter().position(|name| *name == &key[..group]).unwrap_or(ORDER.len())
}

fn cell(value: Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text,
        // JSON writes a float with as many digits as bring it back.
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use std::collections::BTreeMap;
    use std::fs;

    use super::*;
    use crate::Status;
    use crate::fixtures::{config, header, row};

    fn written(export: &Export) -> Vec<u8> {
        let mut out = Vec::new();
        export.write(&mut out).unwrap();
        out
    }

    fn export(rows: &[Row]) -> (usize, Vec<BTreeMap<String, String>>) {
        let folder = tempfile::tempdir().unwrap();
        let mut text = vec![header("r").to_line()];
        text.extend(rows.iter().map(Row::to_line));
        fs::write(folder.path().join("a.jsonl"), text.join("\n")).unwrap();
        let export = Export::open(&[folder.path().to_path_buf()], None).unwrap();
        let out = written(&export);
        let mut reader = csv::Reader::from_reader(out.as_slice());
        let names = reader.headers().unwrap().clone();
        let read = reader.records().map(|record| {
            let record = record.unwrap();
            names.iter().map(String::from).zip(record.iter().map(String::from)).collect()
        });
        (export.rows(), read.collect())
    }

    /// A row's line, built again from its cells: what a reader of the file can know.
    fn line(cells: &BTreeMap<String, String>) -> String {
        let texts: BTreeSet<&str> = [
            "run",
            "row",
            "group",
            "problem",
            "technique",
            "variant",
            "form",
            "case",
            "scene",
            "scene_hash",
            "view",
            "size",
            "truth",
            "adapter",
            "driver",
            "device",
            "cpu",
            "revision",
            "shader_hash",
            "machine",
            "time",
            "status",
            "stage",
            "reason",
            "clock",
            "baseline",
        ]
        .into();
        let mut object = serde_json::Map::new();
        object.insert("kind".into(), "row".into());
        object.insert("schema".into(), 1.into());
        for (key, cell) in cells {
            let value = match () {
                () if texts.contains(key.as_str()) => Value::from(cell.as_str()),
                () if cell.is_empty() && !key.starts_with("knob.") => continue,
                // A knob's word stands bare.
                () => serde_json::from_str(cell).unwrap_or_else(|_| Value::from(cell.as_str())),
            };
            object.insert(key.clone(), value);
        }
        Value::Object(object).to_string()
    }

    proptest! {
        #![proptest_config(config())]

        #[test]
        fn what_was_written_reads_back_whole(
            texts in prop::collection::vec("[a-z,;\"\n\r\t \u{e9}]{0,12}", 5),
            error in prop::num::f64::NORMAL,
            ns in any::<u64>(),
        ) {
            let mut odd = row(3);
            odd.driver = texts[0].clone();
            odd.scene = texts[1].clone();
            odd.knobs.insert("format".into(), "f16".into());
            odd.errors.insert("rmse".into(), error);
            odd.samples_ns = vec![vec![ns, 1], vec![2]];
            let failed = Row {
                status: Status::Failed { stage: texts[2].clone(), reason: texts[3].clone() },
                ..row(4)
            };
            let (exported, read) = export(&[odd.clone(), failed.clone()]);
            prop_assert_eq!(exported, 2);
            // The first has a knob that the second has not: its cell is empty.
            let mut second = read[1].clone();
            prop_assert_eq!(second.remove("knob.format"), Some(String::new()));
            prop_assert_eq!(Row::from_line(&line(&read[0])).unwrap(), odd);
            prop_assert_eq!(Row::from_line(&line(&second)).unwrap(), failed);
        }
    }

    #[test]
    fn columns_are_the_union_in_a_fixed_order_and_what_is_not_finite_is_empty() {
        let mut a = row(0);
        a.errors.insert("zeta".into(), f64::NAN);
        let mut b = row(1);
        b.counters.insert("alpha".into(), 7);
        b.passes_ns.insert("a-pass".into(), 9);
        let (_, read) = export(&[a, b]);
        assert_eq!(read[0]["error.zeta"], "");
        assert_eq!(
            (read[0]["counter.alpha"].as_str(), read[1]["counter.alpha"].as_str()),
            ("", "7")
        );
        assert_eq!(read[1]["pass.a-pass_ns"], "9");
        assert_eq!(read[0]["samples_ns"], "[[100,200],[300]]");

        let folder = tempfile::tempdir().unwrap();
        let full =
            Row { status: Status::Failed { stage: "s".into(), reason: "r".into() }, ..row(0) };
        fs::write(folder.path().join("a.jsonl"), full.to_line()).unwrap();
        let out = written(&Export::open(&[folder.path().to_path_buf()], None).unwrap());
        let header = String::from_utf8(out).unwrap();
        let names: Vec<&str> = header.lines().next().unwrap().split(',').collect();
        let places: Vec<usize> = names.iter().map(|name| place(name)).collect();
        assert!(places.is_sorted() && places.len() >= ORDER.len(), "{names:?}");
        // A key that is new in rows needs its place in the order.
        assert!(places.iter().all(|place| *place < ORDER.len()), "{names:?}");
    }

    #[test]
    fn only_the_last_of_a_row_is_written_and_only_what_is_wanted() {
        let newer = Row { memory_bytes: 5, ..row(0) };
        let (exported, read) = export(&[row(0), row(1), newer]);
        assert_eq!(exported, 2);
        let memory: Vec<&str> = read.iter().map(|cells| cells["memory_bytes"].as_str()).collect();
        assert_eq!(memory, [(1_u64 << 40).to_string().as_str(), "5"]);

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jsonl");
        fs::write(&path, row(0).to_line() + "\nnoise\n").unwrap();
        for (problem, rows) in [(None, 1), (Some("shadow-filtering"), 1), (Some("other"), 0)] {
            let export = Export::open(std::slice::from_ref(&path), problem).unwrap();
            assert_eq!((export.rows(), export.left_out.skipped.len()), (rows, 1));
            let lines = String::from_utf8(written(&export)).unwrap().lines().count();
            assert_eq!(lines, rows + 1);
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jsonl");
        fs::write(&path, row(0).to_line()).unwrap();
        let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let export = Export::open(&[path], None).unwrap();
        assert!(matches!(export.write(full), Err(RecordError::Csv(_))));
    }
}
