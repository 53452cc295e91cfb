//! A run survives kills, crashes and hangs: no finished row is lost or doubled.

mod common;

use common::{dapple, run, said};
use dapple_records::{Row, Status};
use std::{
    collections::BTreeSet,
    fs,
    path::Path,
    process::{Command, Stdio},
    thread,
    time::{Duration, Instant},
};

/// Twelve cases of two settings: long enough to be caught in the middle.
const SWEEP: &str = r#"
about = "a sweep to interrupt"
repeats = 3
[[measure]]
problem = "partition-offsets"
seeds = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]
forms = ["cpu"]
parameters = { leaves = [200000], cells = [512], frames = [24] }
"#;

fn rows(records: &Path) -> Vec<Row> {
    if !records.is_dir() {
        return Vec::new();
    }
    // Not through the reader's own de-duplication: a doubled line must show here.
    let mut rows = Vec::new();
    for entry in fs::read_dir(records).unwrap() {
        let text = fs::read(entry.unwrap().path()).unwrap();
        for line in String::from_utf8_lossy(&text).lines() {
            if line.contains("\"kind\":\"row\"") {
                rows.extend(Row::from_line(line).ok());
            }
        }
    }
    rows
}

fn measure(folder: &Path) -> Command {
    let mut command = dapple(folder);
    command.args(["measure", "--sweep", "sweep.toml"]).stdout(Stdio::null());
    command
}

#[test]
fn a_killed_sweep_resumes_without_losing_or_doubling_a_row() {
    let folder = tempfile::tempdir().unwrap();
    let records = folder.path().join("records");
    fs::write(folder.path().join("sweep.toml"), SWEEP).unwrap();
    let mut kills = 0;
    // Killed at different moments, each time after at least one more row.
    for more in [1, 5, 9] {
        let before = rows(&records).len();
        let mut child = measure(folder.path()).stderr(Stdio::null()).spawn().unwrap();
        let deadline = Instant::now() + Duration::from_secs(120);
        while rows(&records).len() < before + more && child.try_wait().unwrap().is_none() {
            assert!(Instant::now() < deadline, "no row in two minutes");
            thread::sleep(Duration::from_millis(2));
        }
        kills += usize::from(child.try_wait().unwrap().is_none());
        child.kill().unwrap();
        child.wait().unwrap();
    }
    assert!(kills >= 1, "the sweep was too short to be killed");
    let kept = rows(&records);
    let output = measure(folder.path()).output().unwrap();
    assert!(output.status.success(), "{}", said(&output));
    assert!(said(&output).contains("resuming"), "{}", said(&output));

    let finished = rows(&records);
    let keys: BTreeSet<_> = finished.iter().map(|r| r.group.clone()).collect();
    assert_eq!(keys.len(), finished.len(), "a row is doubled");
    assert!(kept.iter().all(|row| finished.contains(row)), "a finished row was lost or changed");
    assert!(finished.iter().all(|row| row.status == Status::Ok));
    let seeds: BTreeSet<_> = finished.iter().map(|r| r.case.clone()).collect();
    assert_eq!(seeds.len(), 12, "{seeds:?}");
    assert_eq!(finished.len() % 12, 0);
    assert_eq!(fs::read_dir(&records).unwrap().count(), 1, "resuming continues the same file");

    // A finished run is not resumed: the same command begins another.
    let output = measure(folder.path()).output().unwrap();
    assert!(output.status.success());
    assert_eq!(fs::read_dir(&records).unwrap().count(), 2);
}

#[test]
fn a_crash_or_a_hang_is_a_row_for_its_culprit_and_the_rest_goes_on() {
    for fault in ["crash", "hang"] {
        let folder = tempfile::tempdir().unwrap();
        let sweep = SWEEP.replace("[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]", "[1]");
        let sweep = sweep.replace("repeats = 3", "repeats = 1\nlimit_s = 5");
        fs::write(folder.path().join("sweep.toml"), sweep).unwrap();
        let listed = run(folder.path(), &["list", "partition-offsets", "--format", "jsonl"]);
        assert!(listed.status.success());
        let culprit = "cpu-threads";
        let output = measure(folder.path())
            .args(["--fault", &format!("{fault}:{culprit}")])
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(1), "{}", said(&output));
        let rows = rows(&folder.path().join("records"));
        let (failed, fine): (Vec<_>, Vec<_>) = rows.iter().partition(|r| r.status != Status::Ok);
        assert_eq!(failed.len(), 1, "{fault}");
        assert_eq!(failed[0].technique, culprit);
        assert!(!fine.is_empty(), "{fault}: the others were not measured");
        assert!(said(&output).contains(culprit));
    }
}

#[cfg(unix)]
#[test]
fn an_interrupt_keeps_finished_rows_and_says_how_to_go_on() {
    let folder = tempfile::tempdir().unwrap();
    let records = folder.path().join("records");
    fs::write(folder.path().join("sweep.toml"), SWEEP).unwrap();
    let child = measure(folder.path()).stderr(Stdio::piped()).spawn().unwrap();
    let deadline = Instant::now() + Duration::from_secs(120);
    while rows(&records).is_empty() {
        assert!(Instant::now() < deadline, "no row in two minutes");
        thread::sleep(Duration::from_millis(2));
    }
    let pid = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(3), "{}", said(&output));
    assert!(said(&output).contains("interrupted"), "{}", said(&output));
    assert!(!rows(&records).is_empty());
}
