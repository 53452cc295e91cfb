//! `dapple export`: rows for programs that read comma-separated values.

mod common;

use common::{run, said};
use dapple_records::{Row, read_dir};
use std::{collections::BTreeMap, fs};

#[test]
fn every_row_of_a_run_is_exported_with_its_figures() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let measure = "measure partition-offsets --form cpu --param leaves=2000 --param frames=2 \
                   --repeats 2";
    let output = run(at, &measure.split_whitespace().collect::<Vec<_>>());
    assert!(output.status.success(), "{}", said(&output));
    let rows: Vec<Row> = read_dir(&at.join("records")).unwrap().rows;
    assert!(rows.len() >= 2);

    let printed = run(at, &["export", "--csv"]);
    assert!(printed.status.success(), "{}", said(&printed));
    let output = run(at, &["export", "--csv", "-o", "rows.csv"]);
    assert!(output.status.success(), "{}", said(&output));
    assert_eq!(fs::read(at.join("rows.csv")).unwrap(), printed.stdout);

    let mut reader = csv::Reader::from_reader(printed.stdout.as_slice());
    let read: Vec<BTreeMap<String, String>> =
        reader.deserialize().map(|record| record.unwrap()).collect();
    assert_eq!(read.len(), rows.len());
    for (cells, row) in read.iter().zip(&rows) {
        assert_eq!((&cells["row"], &cells["technique"]), (&row.row, &row.technique));
        assert_eq!(cells["median_ns"].parse::<f64>().ok(), row.median_ns());
        for (name, value) in &row.errors {
            assert_eq!(cells[&format!("error.{name}")].parse::<f64>().unwrap(), *value);
        }
        for (name, value) in &row.counters {
            assert_eq!(cells[&format!("counter.{name}")].parse::<u64>().unwrap(), *value);
        }
        assert_eq!(cells["samples_ns"], serde_json::to_string(&row.samples_ns).unwrap());
    }

    let other = run(at, &["export", "--csv", "--problem", "shadow-filtering", "-o", "none.csv"]);
    assert_eq!(other.status.code(), Some(2));
    assert!(said(&other).contains("no rows in records"), "{}", said(&other));
    assert!(!at.join("none.csv").exists());
    let unknown = run(at, &["export", "--csv", "--problem", "nothing"]);
    assert_eq!(unknown.status.code(), Some(2));
}
