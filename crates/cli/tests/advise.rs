//! `dapple advise` as a user would run it.

mod common;

use common::{run, said};

/// A problem and case that is measured in a moment.
const SMALL: [&str; 8] = [
    "advise",
    "partition-offsets",
    "--form",
    "cpu",
    "--param",
    "leaves=2000",
    "--param",
    "frames=2",
];

fn with<'a>(more: &[&'a str]) -> Vec<&'a str> {
    SMALL.iter().copied().chain(more.iter().copied()).collect()
}

#[test]
fn goals_and_times_that_make_no_sense_are_refused_by_name_and_limit() {
    let folder = tempfile::tempdir().unwrap();
    for (flags, expected) in [
        (&["--metric", "beauty"][..], "there is: bytes_per_leaf, wrong_frames"),
        (&["--error=-1"], "--error"),
        (&["--error", "NaN"], "a finite number of at least 0"),
        (&["--budget-ms", "0"], "a finite number above 0"),
        (&["--budget-ms", "inf"], "a finite number above 0"),
        (&["--time", "soon"], "from 1s to 168h"),
        (&["--time", "0s"], "from 1s to 168h"),
        (&["--technique", "magic"], "no technique `magic`"),
        (&["--param", "cells=1,2"], "one case"),
    ] {
        let output = run(folder.path(), &with(flags));
        assert_eq!(output.status.code(), Some(2), "{flags:?}: {}", said(&output));
        assert!(said(&output).contains(expected), "{flags:?}: {}", said(&output));
    }
    let reference = run(folder.path(), &["advise", "partition-offsets", "--form", "reference"]);
    assert_eq!(reference.status.code(), Some(2));
}

#[test]
fn a_choice_comes_with_its_command_and_records_and_a_goal_out_of_reach_exits_1() {
    let folder = tempfile::tempdir().unwrap();
    let met = run(folder.path(), &with(&["--error", "1000", "--format", "jsonl"]));
    let text = String::from_utf8_lossy(&met.stdout).into_owned();
    assert_eq!(met.status.code(), Some(0), "{text}{}", said(&met));
    let choice: serde_json::Value = serde_json::from_str(text.lines().next().unwrap()).unwrap();
    assert_eq!((&choice["role"], &choice["met"]), (&"choice".into(), &true.into()));
    assert!(choice["time_ns"].as_f64().unwrap() > 0.0);

    // The command is what it says: it measures that technique again.
    let command = choice["command"].as_str().unwrap();
    let words: Vec<&str> = command.split_whitespace().skip(1).collect();
    let again = run(folder.path(), &words);
    assert_eq!(again.status.code(), Some(0), "{command}: {}", said(&again));
    let front = run(folder.path(), &["front"]);
    assert!(String::from_utf8_lossy(&front.stdout).contains("partition-offsets"));

    let missed = run(folder.path(), &with(&["--error", "0.001"]));
    let text = String::from_utf8_lossy(&missed.stdout).into_owned();
    assert_eq!(missed.status.code(), Some(1), "{text}{}", said(&missed));
    assert!(text.contains("nothing that was measured meets this"), "{text}");
    assert!(text.contains("nearest"), "{text}");
}
