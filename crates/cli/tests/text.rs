//! What the program prints, word for word where it is stable, and what holds of all of it.

mod common;

use common::{dapple, run, said};
use insta::{assert_snapshot, with_settings};
use serde_json::Value;
use std::{
    path::{Path, PathBuf},
    process::Command,
};
use tempfile::{TempDir, tempdir};

/// Records of a front that is known: times and errors are round, so that dominance is seen.
fn known_front() -> PathBuf {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/records/known-front.jsonl");
    assert!(path.is_file(), "{} is missing", path.display());
    path
}

fn folder() -> TempDir {
    tempdir().unwrap()
}

/// Standard output of a run that must succeed, as on a terminal of 80 columns.
#[track_caller]
fn printed(folder: &Path, arguments: &[&str]) -> String {
    let output = dapple(folder).env("COLUMNS", "80").args(arguments).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", said(&output));
    String::from_utf8(output.stdout).unwrap()
}

/// Lines without the spaces that fill a table's last column.
fn trimmed(text: &str) -> String {
    text.lines().map(|line| format!("{}\n", line.trim_end())).collect()
}

#[test]
fn help() {
    let at = folder();
    assert_snapshot!("help", trimmed(&printed(at.path(), &["--help"])));
    assert_snapshot!("help_measure", trimmed(&printed(at.path(), &["measure", "--help"])));
}

#[test]
fn lists() {
    let at = folder();
    assert_snapshot!("list", trimmed(&printed(at.path(), &["list"])));
    let techniques = printed(at.path(), &["list", "shadow-filtering"]);
    assert_snapshot!("list_shadow_filtering", trimmed(&techniques));
}

#[test]
fn a_scene_inspected() {
    let at = folder();
    let text = trimmed(&printed(at.path(), &["scene", "inspect", "cube"]));
    with_settings!({ filters => vec![(r"hash [0-9a-f]{16}", "hash [hash]")] }, {
        assert_snapshot!("scene_inspect_cube", text);
    });
}

#[test]
fn a_report_for_build_servers() {
    let at = folder();
    let arguments = ["verify", "--technique", "cpu-thread", "--format", "junit", "--cases", "8"];
    assert_snapshot!("verify_junit", printed(at.path(), &arguments));
}

/// Measures one technique on a small crown and returns the folder.
fn measured(format: &str) -> (TempDir, String) {
    let at = folder();
    let arguments = [
        "measure",
        "partition-offsets",
        "--form",
        "cpu",
        "--technique",
        "cpu-thread",
        "--param",
        "leaves=1000",
        "--param",
        "cells=64",
        "--param",
        "frames=4",
        "--repeats",
        "3",
        "--format",
        format,
    ];
    let text = printed(at.path(), &arguments);
    (at, text)
}

#[test]
fn a_row_of_a_record() {
    let (at, _) = measured("table");
    let files: Vec<_> = std::fs::read_dir(at.path().join("records")).unwrap().flatten().collect();
    assert_eq!(files.len(), 1);
    let text = std::fs::read_to_string(files[0].path()).unwrap();
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let kinds: Vec<_> = lines.iter().map(|line| line["kind"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["run", "row", "end"]);

    let row = &lines[1];
    let samples = row["samples_ns"].as_array().unwrap();
    assert_eq!(samples.len(), 3);
    for repeat in samples {
        let frames = repeat.as_array().unwrap();
        assert!(frames.len() == 4 && frames.iter().all(|ns| ns.as_u64().is_some()), "{repeat}");
    }
    let number = |key: &str| row[key].as_f64().unwrap_or_else(|| panic!("{key}"));
    assert!(number("median_ns") > 0.0 && number("p99_ns") >= number("median_ns"));
    assert!(number("mad_ns") >= 0.0 && number("threads") >= 1.0);
    // What a kept leaf costs, by the row's own counters.
    let bytes = number("counter.bytes_read") + number("counter.bytes_written");
    let per_leaf = bytes / number("counter.leaves_kept");
    assert!((per_leaf - number("error.bytes_per_leaf")).abs() < 1e-9, "{per_leaf}");

    let times = r#""(median_ns|mad_ns|p99_ns|threads)": [0-9.]+"#;
    let texts = r#""(cpu|machine|revision|row|run|scene_hash|shader_hash|time)": "[^"]+""#;
    with_settings!({ filters => vec![
        (times, r#""$1": "[$1]""#),
        (texts, r#""$1": "[$1]""#),
        (r#""dirty": (true|false)"#, r#""dirty": "[dirty]""#),
        (r#""samples_ns": \[[\[\]\s0-9,]*\]"#, r#""samples_ns": "[samples_ns]""#),
    ] }, {
        assert_snapshot!("record_row", serde_json::to_string_pretty(row).unwrap());
    });
}

#[test]
fn a_known_front() {
    let at = folder();
    let records = known_front();
    let records = records.to_str().unwrap();
    let output = run(at.path(), &["front", "--records", records]);
    assert!(output.status.success(), "{}", said(&output));
    assert_snapshot!("front", trimmed(&String::from_utf8(output.stdout.clone()).unwrap()));
    assert_snapshot!("front_not_ranked", said(&output));
    let all = run(at.path(), &["front", "shadow-filtering", "--all", "--records", records]);
    assert_snapshot!("front_all", trimmed(&String::from_utf8(all.stdout).unwrap()));

    // By hand. On each device, from the fastest to the slowest, a setting is on the front if no
    // faster one is as accurate. The later of two rows for `vsm` on the hardware counts (100 µs,
    // 0.05, not 50 µs, 0.001); two equal settings are both on the front; `power-cdf` has no
    // error, `esm` failed, two were not run, and `cpu-threads` breaks its constraint.
    let expected = [
        ("gaussian-cdf", "hardware", true),     // 90 µs, 0.08
        ("vsm", "hardware", true),              // 100 µs, 0.05
        ("hard", "hardware", false),            // 150 µs, 0.06: vsm is better in both
        ("msm", "hardware", true),              // 200 µs, 0.02
        ("layered-gaussian", "hardware", true), // 200 µs, 0.02
        ("pcf", "hardware", false),             // 400 µs, 0.02: as accurate as msm, slower
        ("msm", "software", true),              // 9 ms, 0.02
        ("vsm", "software", false),             // 10 ms, 0.05
        ("vsm", "cpu", true),                   // 5 ms, 0.05
        ("hard", "cpu", false),                 // 6 ms, 0.07
        ("pcf", "cpu", true),                   // 9 ms, 0.01
    ];
    let arguments =
        ["front", "shadow-filtering", "--all", "--format", "jsonl", "--records", records];
    let rows = json_lines(&printed(at.path(), &arguments));
    let word = |row: &Value, key: &str| row[key].as_str().unwrap().to_string();
    let found: Vec<_> = rows
        .iter()
        .map(|row| {
            (word(row, "technique"), word(row, "device"), row["on_front"].as_bool().unwrap())
        })
        .collect();
    let expected: Vec<_> =
        expected.iter().map(|(a, b, c)| (a.to_string(), b.to_string(), *c)).collect();
    assert_eq!(found, expected);
    let rows = json_lines(&printed(
        at.path(),
        &["front", "partition-offsets", "--all", "--format", "jsonl", "--records", records],
    ));
    assert_eq!(rows.len(), 1, "only the setting that keeps its constraint");
    assert_eq!(rows[0]["technique"], "cpu-thread");
}

/// Every line as a JSON object; at least one.
#[track_caller]
fn json_lines(text: &str) -> Vec<Value> {
    let rows: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert!(!rows.is_empty() && rows.iter().all(Value::is_object), "{text}");
    rows
}

#[test]
fn programs_can_read_what_programs_are_given() {
    let at = folder();
    let records = known_front();
    let records = records.to_str().unwrap();
    let cases: [(&[&str], &[&str], usize); 4] = [
        (&["list"], &["kind", "name", "what"], 14),
        (
            &["list", "shadow-filtering"],
            &["technique", "kind", "name", "default", "values", "what"],
            60,
        ),
        (&["scene", "inspect", "cube"], &["option", "needed", "because"], 8),
        (
            &["front", "shadow-filtering", "--records", records],
            &[
                "problem",
                "case",
                "view",
                "size",
                "scene_hash",
                "technique",
                "variant",
                "form",
                "knobs",
                "machine",
                "adapter",
                "device",
                "clock",
                "time_ns",
                "mad_ns",
                "ratio",
                "metric",
                "error",
                "memory_bytes",
                "on_front",
            ],
            7,
        ),
    ];
    for (arguments, columns, least) in cases {
        let with = |format| [arguments, &["--format", format]].concat();
        let csv = printed(at.path(), &with("csv"));
        // The reader refuses rows of another length than the header's.
        let mut reader = csv::Reader::from_reader(csv.as_bytes());
        assert_eq!(reader.headers().unwrap().iter().collect::<Vec<_>>(), columns, "{arguments:?}");
        let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        assert!(rows.len() >= least, "{arguments:?}: {} rows", rows.len());

        let json = json_lines(&printed(at.path(), &with("jsonl")));
        assert_eq!(json.len(), rows.len(), "{arguments:?}");
        for (object, row) in json.iter().zip(&rows) {
            assert_eq!(object.as_object().unwrap().len(), columns.len());
            for (column, cell) in columns.iter().zip(row) {
                let value = match &object[*column] {
                    Value::String(text) => text.clone(),
                    Value::Null => String::new(),
                    other => other.to_string(),
                };
                assert_eq!(value, cell, "{arguments:?}, column {column}");
            }
        }
    }
    json_lines(&measured("jsonl").1);
    let (_, csv) = measured("csv");
    assert_eq!(csv::Reader::from_reader(csv.as_bytes()).records().map(Result::unwrap).count(), 1);
    let verify = ["verify", "--technique", "cpu-thread", "--format", "jsonl", "--cases", "8"];
    for gate in json_lines(&printed(at.path(), &verify)) {
        assert_eq!(gate["outcome"], "passed");
        assert!(gate["checked"].as_u64() > Some(0) && gate["control_failed"].as_u64() > Some(0));
    }
}

#[test]
fn exit_codes() {
    let at = folder();
    for (arguments, code) in [
        (&["--help"][..], 0),
        (&["--version"], 0),
        (&["measure", "--help"], 0),
        (&["list"], 0),
        (&[], 0),
        (&["verify", "--technique", "cpu-thread", "--cases", "1"], 0),
        (
            &[
                "measure",
                "partition-offsets",
                "--form",
                "cpu",
                "--param",
                "leaves=100",
                "--param",
                "frames=2",
                "--fault",
                "crash:cpu-thread",
            ],
            1,
        ),
        (&["list", "nothing"], 2),
        (&["list", "--format", "xml"], 2),
        (&["--frobnicate"], 2),
        (&["scene"], 2),
        (&["front", "--records", "absent"], 3),
    ] {
        let output = run(at.path(), arguments);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", said(&output));
        assert!(!said(&output).contains("panicked"), "{arguments:?}");
        // Help is an answer and goes to standard output; a complaint does not.
        assert_eq!(output.stdout.is_empty(), code >= 2, "{arguments:?}");
        assert!(code == 0 || !output.stderr.is_empty(), "{arguments:?}: no reason is given");
    }
}

#[cfg(unix)]
#[test]
fn a_reader_that_leaves_early_causes_no_panic() {
    let program = env!("CARGO_BIN_EXE_dapple");
    let at = folder();
    for arguments in ["list", "list shadow-filtering", "--help", "list --format jsonl"] {
        // `head` as a user would; then a reader that is gone before the first byte.
        for script in [
            format!("set -o pipefail; {program} {arguments} | head -1"),
            format!("(sleep 0.2; exec {program} {arguments}) | true; exit ${{PIPESTATUS[0]}}"),
        ] {
            let output =
                Command::new("bash").args(["-c", &script]).current_dir(at.path()).output().unwrap();
            assert!(output.stderr.is_empty(), "{script}: {}", said(&output));
            // 141: ended by the closed pipe.
            assert!(matches!(output.status.code(), Some(0 | 141)), "{script}: {}", output.status);
        }
    }
}

#[test]
fn no_color_means_no_escape_codes() {
    let at = folder();
    let records = known_front();
    let records = records.to_str().unwrap();
    for arguments in [
        &["--help"][..],
        &["list"],
        &["list", "nothing"],
        &["--frobnicate"],
        &["front", "--records", records],
        &["scene", "inspect", "cube"],
    ] {
        let output = dapple(at.path())
            .env("CLICOLOR_FORCE", "1")
            .env("TERM", "xterm-256color")
            .args(arguments)
            .output()
            .unwrap();
        for stream in [&output.stdout, &output.stderr] {
            assert!(!stream.contains(&0x1b), "{arguments:?} prints escape codes");
        }
    }
}
