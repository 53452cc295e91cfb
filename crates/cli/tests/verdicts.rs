//! What `verify`, `claims` and `catalogue` leave behind and tell a dashboard.

mod common;

use common::{dapple, run, said};
use dapple_records::{Feed, FeedLine, Line, read_dir};
use std::{fs, path::Path, time::Instant};
use tempfile::tempdir;

const GATES: [&str; 5] = ["verify", "--technique", "cpu-thread", "--cases", "8"];
/// Small enough for a test.
const CLAIM: [&str; 3] = ["claims", "partition-offsets", "--id"];

fn told(folder: &Path, arguments: &[&str]) -> Vec<FeedLine> {
    let output = run(folder, &[arguments, &["--feed"]].concat());
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    let line = |line| FeedLine::parse(line).unwrap().unwrap_or_else(|| panic!("not ours: {line}"));
    assert!(!text.is_empty(), "{}", said(&output));
    text.lines().map(line).collect()
}

#[test]
fn gates_are_recorded_as_they_are_told() {
    let at = tempdir().unwrap();
    let lines = told(at.path(), &GATES);
    let [FeedLine::Event(Feed::Started { total, resumed: 0, path }), .., last] = &lines[..] else {
        panic!("{lines:?}")
    };
    assert_eq!(last, &FeedLine::Event(Feed::Done { code: 0 }));
    let gates: Vec<_> = lines
        .iter()
        .filter_map(|line| match line {
            FeedLine::Record(Line::Gate(gate)) => Some((**gate).clone()),
            _ => None,
        })
        .collect();
    assert!(gates.len() == *total && *total > 0);
    assert!(gates.iter().all(|g| g.outcome == "passed" && g.checked > 0 && !g.run.is_empty()));
    let progress = lines.iter().filter(|l| matches!(l, FeedLine::Event(Feed::Progress { .. })));
    assert_eq!(progress.count(), *total);

    assert!(at.path().join(path).is_file());
    let read = read_dir(&at.path().join("records")).unwrap();
    assert_eq!(read.gates, gates);
    assert_eq!((read.headers[0].sweep.as_str(), read.ended.len()), ("verify", 1));
    assert!(read.headers[0].command.starts_with("dapple verify --technique cpu-thread"));
}

#[test]
fn a_folder_that_refuses_is_said_and_the_verdict_stands() {
    let at = tempdir().unwrap();
    fs::write(at.path().join("records"), "a file where the folder should be").unwrap();
    let output = run(at.path(), &GATES);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(said(&output).contains("not recorded: "), "{}", said(&output));
    let printed = String::from_utf8_lossy(&output.stdout);
    assert!(printed.contains("passed"), "{printed}");
}

#[test]
fn a_claim_is_recorded_with_its_figures_and_an_unknown_one_leaves_nothing() {
    let at = tempdir().unwrap();
    let unknown = told(at.path(), &[&CLAIM[..], &["nobody"]].concat());
    let [FeedLine::Event(Feed::Failed { reason, .. }), FeedLine::Event(Feed::Done { code: 2 })] =
        &unknown[..]
    else {
        panic!("{unknown:?}")
    };
    assert!(reason.contains("nobody"), "{reason}");
    assert!(!at.path().join("records").exists());

    let known = told(at.path(), &[&CLAIM[..], &["gumbau-H3.2"]].concat());
    assert_eq!(known.last(), Some(&FeedLine::Event(Feed::Done { code: 0 })));
    let read = read_dir(&at.path().join("records")).unwrap();
    let [claim] = &read.claims[..] else { panic!("{:?}", read.claims) };
    assert!(known.contains(&FeedLine::Record(Line::Claim(Box::new(claim.clone())))));
    assert_eq!((claim.id.as_str(), claim.problem.as_str()), ("gumbau-H3.2", "partition-offsets"));
    assert!(!claim.figures.is_empty() && !claim.because.is_empty());
    let verdicts = ["reproduced", "refuted", "open", "needs-hardware"];
    assert!(verdicts.contains(&claim.verdict.as_str()), "{}", claim.verdict);
}

#[test]
fn the_catalogue_is_one_line_within_a_second() {
    let at = tempdir().unwrap();
    let start = Instant::now();
    let output = dapple(at.path()).arg("catalogue").output().unwrap();
    let took = start.elapsed();
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(text.lines().count(), 1);
    let Some(FeedLine::Event(Feed::Catalogue(catalogue))) = FeedLine::parse(&text).unwrap() else {
        panic!("{text}")
    };
    // Ten times what it takes on a machine at rest.
    assert!(took.as_secs_f64() < 5.0, "{took:?}");
    assert!(catalogue.problems.len() >= 2 && !catalogue.sweeps.is_empty());
    for problem in &catalogue.problems {
        assert!(!problem.techniques.is_empty() && problem.levels.len() == 3, "{}", problem.id);
        assert!(problem.metrics.iter().any(|m| m.0 == problem.axis));
        let knobs = problem.techniques.iter().flat_map(|t| &t.knobs).chain(&problem.parameters);
        for knob in knobs {
            assert!(knob.steps.contains(&knob.default), "{} {}", problem.id, knob.name);
        }
        let gates: usize = problem.gates.values().sum();
        assert!(gates >= problem.techniques.len(), "{}: {gates} gates", problem.id);
    }
}
