//! A sweep split over processes and merged is the sweep.

mod common;

use common::{dapple, run, said};
use dapple_records::{Row, Status, read_file};
use std::{collections::BTreeSet, fs, path::Path, process::Stdio};

/// Four cases of all `cpu` settings.
const SWEEP: &str = r#"
about = "a sweep to split"
repeats = 1
[[measure]]
problem = "partition-offsets"
seeds = [1, 2, 3, 4]
forms = ["cpu"]
parameters = { leaves = [2000], frames = [2] }
"#;

/// Key and identity of every row, which must be ok.
fn identities(rows: &[Row]) -> BTreeSet<(String, String)> {
    assert!(rows.iter().all(|row| row.status == Status::Ok));
    let all: BTreeSet<_> = rows.iter().map(|row| (row.group.clone(), row.row.clone())).collect();
    assert_eq!(all.len(), rows.len(), "a row is doubled");
    all
}

fn only_file(folder: &Path) -> std::path::PathBuf {
    let mut files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let file = files.next().expect("a record file");
    assert_eq!(files.next(), None);
    file
}

fn shard(folder: &Path, part: &str, records: &str) -> std::process::Command {
    let mut command = dapple(folder);
    let arguments = ["measure", "--sweep", "sweep.toml", "--shard", part, "--records", records];
    command.args(arguments).stdout(Stdio::null()).stderr(Stdio::piped());
    command
}

#[test]
fn four_parts_as_processes_merge_to_exactly_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("sweep.toml"), SWEEP).unwrap();
    let output = run(at, &["measure", "--sweep", "sweep.toml", "--records", "whole"]);
    assert!(output.status.success(), "{}", said(&output));
    let whole = read_file(&only_file(&at.join("whole"))).unwrap().rows;
    assert!(whole.len() >= 8, "{} rows are too few to split", whole.len());

    let parts: Vec<_> = (0..4).map(|i| (format!("{i}/4"), format!("part{i}"))).collect();
    let children: Vec<_> =
        parts.iter().map(|(part, records)| shard(at, part, records).spawn().unwrap()).collect();
    for child in children {
        let output = child.wait_with_output().unwrap();
        assert!(output.status.success(), "{}", said(&output));
    }
    let mut sum = 0;
    for (part, records) in &parts {
        let read = read_file(&only_file(&at.join(records))).unwrap();
        assert_eq!(read.headers[0].shard, *part);
        assert!(read.headers[0].memory_bytes > 0 || !cfg!(target_os = "linux"));
        assert_eq!(read.ended.len(), 1);
        sum += read.rows.len();
    }
    let merge: Vec<&str> =
        ["merge"].into_iter().chain(parts.iter().map(|p| p.1.as_str())).collect();
    let output = run(at, &[&merge[..], &["-o", "all.jsonl"]].concat());
    assert!(output.status.success(), "{}", said(&output));
    assert!(said(&output).contains(&format!("{sum} rows")), "{}", said(&output));
    let all = read_file(&at.join("all.jsonl")).unwrap();
    assert_eq!((all.headers.len(), all.ended.len()), (4, 4));
    assert_eq!(identities(&all.rows), identities(&whole));
    // Every ratio refers to the same baseline.
    assert!(all.rows.iter().all(|row| row.ratio.is_some()));

    // A part is not resumed by another, and a finished one is not resumed at all.
    let again = shard(at, "1/4", "part0").output().unwrap();
    assert!(again.status.success() && !said(&again).contains("resuming"), "{}", said(&again));
    assert_eq!(fs::read_dir(at.join("part0")).unwrap().count(), 2);

    // Control: without one part rows are missing, and the comparison above would see it.
    let output = run(at, &["merge", "part1", "part2", "part3", "-o", "three.jsonl"]);
    assert!(output.status.success());
    let three = read_file(&at.join("three.jsonl")).unwrap().rows;
    assert_ne!(identities(&three), identities(&whole));
}

#[test]
fn an_interrupted_part_goes_on_where_it_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("sweep.toml"), SWEEP).unwrap();
    assert!(shard(at, "1/3", "part").output().unwrap().status.success());
    let path = only_file(&at.join("part"));
    let whole = read_file(&path).unwrap().rows;
    // What a kill leaves: the end and the last row are missing, the row before it is torn.
    let text = fs::read_to_string(&path).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let kept = lines.len() - 3;
    let torn = format!("{}\n{}", lines[..kept].join("\n"), &lines[kept][..50]);
    fs::write(&path, torn).unwrap();
    // Another part must not take it for its own.
    let other = shard(at, "2/3", "part").output().unwrap();
    assert!(!said(&other).contains("resuming"), "{}", said(&other));
    fs::remove_file(newest(&at.join("part"), &path)).unwrap();
    let output = shard(at, "1/3", "part").output().unwrap();
    assert!(said(&output).contains("resuming"), "{}", said(&output));
    let rows = read_file(&only_file(&at.join("part"))).unwrap().rows;
    assert_eq!(identities(&rows), identities(&whole));
}

fn newest(folder: &Path, not: &Path) -> std::path::PathBuf {
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    files.filter(|path| path != not).max().expect("another file")
}

#[test]
fn parts_and_merges_that_cannot_be_are_refused_with_the_limit() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("sweep.toml"), SWEEP).unwrap();
    for part in ["4/4", "a/b", "0/0", "1"] {
        let output = shard(at, part, "none").output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{part}");
        let said = said(&output);
        assert!(said.contains(part) && said.contains("I/N with I below N"), "{said}");
    }
    assert!(!at.join("none").exists());
    // More parts than rows: some are empty, and say so by having no row.
    let output = shard(at, "999/1000", "none").output().unwrap();
    assert!(output.status.success(), "{}", said(&output));

    let row = r#"{"kind":"row","schema":1,"run":"r","row":"i","problem":"p","technique":"t","form":"cpu","case":"c","status":"ok"}"#;
    fs::write(at.join("a.jsonl"), row).unwrap();
    fs::write(at.join("later.jsonl"), row.replace(r#""schema":1"#, r#""schema":9"#)).unwrap();
    fs::write(at.join("there"), "mine").unwrap();
    for (inputs, output, expect) in [
        (vec!["a.jsonl", "later.jsonl"], "out", "later.jsonl line 1: schema 9 is later than 1"),
        (vec!["a.jsonl"], "there", "there is there already"),
        (vec!["there"], "out", "no record in there"),
    ] {
        let output = run(at, &[&["merge"], &inputs[..], &["-o", output]].concat());
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        assert!(said(&output).contains(expect), "{}", said(&output));
        assert!(!at.join("out").exists());
    }
    assert_eq!(fs::read_to_string(at.join("there")).unwrap(), "mine");
    let output = run(at, &["merge", "missing", "-o", "out"]);
    assert_eq!(output.status.code(), Some(3), "{}", said(&output));
}

/// The page's parts, as its command lines name them.
const PARTS: usize = 8;

/// Command lines of the program in the code blocks of a page: from the program's name to the end
/// of the line or of the quotes around it.
fn commands(page: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut fenced = false;
    for line in page.lines() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
        } else if let Some(at) = line.find("dapple ").filter(|_| fenced) {
            found.push(line[at..].trim_end().to_string());
        }
    }
    found
}

/// Runs a line as a shell would, the program found by its name, the sweep a small one.
#[cfg(unix)]
fn as_typed(folder: &Path, line: &str, part: usize) -> std::process::Output {
    let line = line.replace("${{ matrix.part }}", &part.to_string());
    let line = line.replace("--sweep curated", "--sweep sweep.toml");
    let program = Path::new(env!("CARGO_BIN_EXE_dapple"));
    let path = std::env::var("PATH").unwrap_or_default();
    std::process::Command::new("sh")
        .args(["-c", &line])
        .current_dir(folder)
        .env("PATH", format!("{}:{path}", program.parent().unwrap().display()))
        .env("DAPPLE_CACHE", "off")
        .env("SLURM_ARRAY_TASK_ID", part.to_string())
        .env("JOB_COMPLETION_INDEX", part.to_string())
        .output()
        .unwrap()
}

#[cfg(unix)]
#[test]
fn every_command_line_of_the_page_on_scaling_out_runs_as_typed() {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/scale-out.md");
    let all = commands(&fs::read_to_string(page).unwrap());
    let count = |verb: &str| all.iter().filter(|line| line.starts_with(verb)).count();
    // One a scheduler.
    assert_eq!(count("dapple measure "), 3, "{all:?}");
    assert_eq!((count("dapple merge "), count("dapple front ")), (3, 3), "{all:?}");
    let mut folder = tempfile::tempdir().unwrap();
    let sweep = SWEEP.replace("[1, 2, 3, 4]", "[1]");
    for line in &all {
        let parts = if line.starts_with("dapple measure ") {
            folder = tempfile::tempdir().unwrap();
            fs::write(folder.path().join("sweep.toml"), &sweep).unwrap();
            0..PARTS
        } else {
            0..1
        };
        for part in parts {
            let output = as_typed(folder.path(), line, part);
            assert!(output.status.success(), "{line}: {}", said(&output));
        }
        if line.starts_with("dapple merge ") {
            let read = read_file(&folder.path().join("all.jsonl")).unwrap();
            assert_eq!(read.headers.len(), PARTS, "{line}");
            assert!(!identities(&read.rows).is_empty());
        }
    }
    // Control: a flag that does not exist is noticed.
    let wrong = all[0].replace("--shard", "--shart");
    assert!(!as_typed(folder.path(), &wrong, 0).status.success());
}
