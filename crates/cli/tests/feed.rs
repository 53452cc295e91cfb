//! `measure --feed`: what a dashboard hears of a job.

mod common;

use common::{dapple, run, said};
use dapple_records::{Feed, FeedLine, Line, read_dir};

const MEASURE: &[&str] = &[
    "measure",
    "partition-offsets",
    "--form",
    "cpu",
    "--param",
    "leaves=2000",
    "--param",
    "frames=2",
    "--repeats",
    "1",
    "--feed",
];

fn heard(stdout: &[u8]) -> Vec<FeedLine> {
    let text = String::from_utf8(stdout.to_vec()).unwrap();
    let parse = |line: &str| {
        let parsed = FeedLine::parse(line).unwrap();
        parsed.unwrap_or_else(|| panic!("neither event nor record: {line}"))
    };
    text.lines().map(parse).collect()
}

#[test]
fn a_job_tells_its_start_every_row_and_its_end_and_prints_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let output = run(folder.path(), MEASURE);
    assert!(output.status.success(), "{}", said(&output));
    let lines = heard(&output.stdout);
    let rows = read_dir(&folder.path().join("records")).unwrap().rows;
    assert!(rows.len() >= 2);

    let Some(FeedLine::Event(Feed::Started { path, total, resumed })) = lines.first() else {
        panic!("{:?}", lines.first());
    };
    assert_eq!((*total, *resumed), (rows.len(), 0));
    assert!(folder.path().join(path).is_file(), "{path}");
    assert_eq!(lines.last(), Some(&FeedLine::Event(Feed::Done { code: 0 })));
    let told: Vec<_> = lines
        .iter()
        .filter_map(|line| match line {
            FeedLine::Record(Line::Row(row)) => Some((**row).clone()),
            _ => None,
        })
        .collect();
    assert_eq!(told, rows, "the rows told are not the rows on disk");
    let events = |test: &dyn Fn(&Feed) -> bool| {
        lines.iter().filter(|line| matches!(line, FeedLine::Event(event) if test(event))).count()
    };
    let progress = events(&|event| matches!(event, Feed::Progress { .. }));
    assert_eq!(progress, rows.len());
    let last = Feed::Progress { done: rows.len() };
    assert!(lines.contains(&FeedLine::Event(last)));
    let timed = events(&|event| matches!(event, Feed::Stage { stage, .. } if stage == "time"));
    assert!(timed >= rows.len(), "{timed} stages");
}

#[test]
fn a_job_that_fails_says_why_and_with_which_code() {
    let folder = tempfile::tempdir().unwrap();
    let output = run(folder.path(), &["measure", "nothing", "--feed"]);
    assert_eq!(output.status.code(), Some(2));
    let lines = heard(&output.stdout);
    assert!(
        matches!(&lines[0], FeedLine::Event(Feed::Failed { request: 0, reason })
            if reason.contains("no problem `nothing`")),
        "{lines:?}"
    );
    assert_eq!(lines[1..], [FeedLine::Event(Feed::Done { code: 2 })]);

    // A row that failed is a result: told as a row, and by the code.
    let crashed = dapple(folder.path())
        .args(MEASURE)
        .args(["--fault", "crash:cpu-threads"])
        .output()
        .unwrap();
    assert_eq!(crashed.status.code(), Some(1), "{}", said(&crashed));
    let lines = heard(&crashed.stdout);
    assert_eq!(lines.last(), Some(&FeedLine::Event(Feed::Done { code: 1 })));
}

/// A dashboard that goes away ends the run, and what was measured is kept.
#[cfg(unix)]
#[test]
fn a_listener_that_goes_away_ends_the_run_and_it_can_be_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let seeds = "--seed 1".split_whitespace();
    let mut child = dapple(folder.path())
        .args(MEASURE)
        .args(seeds)
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(3), "{}", said(&output));
    assert!(said(&output).contains("interrupted"), "{}", said(&output));
    let again = dapple(folder.path()).args(MEASURE).args(["--seed", "1"]).output().unwrap();
    assert!(again.status.success(), "{}", said(&again));
    let records = folder.path().join("records");
    assert_eq!(std::fs::read_dir(records).unwrap().count(), 1, "the same run goes on");
}
