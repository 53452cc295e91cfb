//! `dapple stress`: real axes pushed as a user would, with deaths on the way.

mod common;

use common::{dapple, run, said};
use dapple_records::{FeedLine, Line, Read, StressLine, feed::Feed, read_dir};
use std::{path::Path, process::Output};

const FACTORS: [&str; 4] = ["stress", "partition-offsets", "--axis", "factors"];
const CPU: [&str; 2] = ["--form", "cpu"];

fn records(folder: &Path) -> Read {
    read_dir(&folder.join("records")).unwrap()
}

fn printed(output: &Output) -> Vec<StressLine> {
    let text = String::from_utf8_lossy(&output.stdout);
    let line = |line: &str| match Line::parse(line.as_bytes()).unwrap() {
        Line::Stress(point) => *point,
        other => panic!("{other:?}"),
    };
    text.lines().map(line).collect()
}

#[track_caller]
fn code(output: &Output, expected: i32) {
    assert_eq!(output.status.code(), Some(expected), "{}", said(output));
    assert!(!said(output).contains("panicked"), "{}", said(output));
}

#[test]
fn an_axis_is_pushed_recorded_and_each_point_shows_again() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let output = run(at, &[&FACTORS[..], &CPU, &["--format", "jsonl"]].concat());
    code(&output, 0);
    let points = printed(&output);
    assert_eq!(points.len(), 2 * 10, "two techniques, ten words");
    assert!(points.iter().all(StressLine::is_safe), "{points:?}");
    assert_eq!(points.iter().filter(|p| p.verdict == "refused").count(), 2 * 4);
    let nan = points.iter().find(|p| p.label == "nan").unwrap();
    assert!(nan.reason.contains("cell 1") && nan.reason.contains("NaN"), "{}", nan.reason);
    let read = records(at);
    assert_eq!(read.stress, points);
    assert_eq!((read.headers[0].sweep.as_str(), read.ended.len()), ("stress", 1));

    for label in ["nan", "one"] {
        let point = points.iter().find(|p| p.label == label).unwrap();
        let words: Vec<&str> = point.command.split(' ').skip(1).collect();
        let output = run(at, &words);
        code(&output, 0);
        let text = String::from_utf8_lossy(&output.stdout);
        let title = format!("{}/plain (cpu) at factors = {label}\n", point.technique);
        assert!(text.contains(&title), "{text}");
        assert!(text.contains(&point.verdict) && text.contains(&point.reason), "{text}");
    }
}

#[test]
fn a_crash_and_a_hang_are_points_of_their_culprit_and_the_axis_goes_on() {
    for (fault, said_of_it) in [("crash", "SIGABRT"), ("hang", "no end after 3 s")] {
        let folder = tempfile::tempdir().unwrap();
        let fault = format!("{fault}:cpu-threads@1");
        let more = ["--fault", &fault, "--limit", "3", "--format", "jsonl"];
        let output = run(folder.path(), &[&FACTORS[..], &CPU, &more].concat());
        code(&output, 1);
        let points = printed(&output);
        assert_eq!(points.len(), 20);
        let crashed: Vec<_> = points.iter().filter(|p| !p.is_safe()).collect();
        assert_eq!(crashed.len(), 1, "{crashed:?}");
        assert_eq!((crashed[0].technique.as_str(), crashed[0].value), ("cpu-threads", 1.0));
        assert_eq!(crashed[0].verdict, "crashed");
        assert!(crashed[0].reason.contains(said_of_it), "{}", crashed[0].reason);
        assert_eq!(records(folder.path()).stress, points);
    }
}

#[test]
fn tables_say_where_it_is_safe_and_what_breaks() {
    let folder = tempfile::tempdir().unwrap();
    let fault = ["--fault", "crash:cpu-thread@2"];
    let output = run(folder.path(), &[&FACTORS[..], &CPU, &fault].concat());
    code(&output, 1);
    let text = String::from_utf8_lossy(&output.stdout);
    let row = |name: &str| text.lines().find(|l| l.contains(name)).unwrap().to_string();
    assert!(row("cpu-thread/").contains("path, zero, least"), "{text}");
    assert!(row("cpu-thread/").contains("minus-zero: crashed: "), "{text}");
    assert!(row("cpu-threads/").contains("everywhere"), "{text}");
    assert!(said(&output).contains("factors: 20 points"), "{}", said(&output));
}

#[test]
fn names_that_nothing_has_are_refused_with_what_there_is() {
    let folder = tempfile::tempdir().unwrap();
    let with = |more: &[&str]| run(folder.path(), &[&["stress"], more].concat());
    for (arguments, part) in [
        (&["partition-offsets", "--axis", "beauty"][..], "there is: leaves"),
        (&["partition-offsets", "--technique", "beauty"], "there is: thread-per-cell"),
        (&["partition-offsets", "--form", "reference"], "there is: cpu, gpu"),
        (&["partition-offsets", "--technique", "cpu-thread", "--form", "gpu"], "nothing to push"),
        (&["beauty"], "no problem `beauty`"),
        (&["--axis", "scale"], "name the problem"),
        (&["partition-offsets", "--at", "1"], "--at takes one axis"),
        (&["partition-offsets", "--axis", "leaves", "--at", "1e9"], "0..=1e7"),
        (&["partition-offsets", "--axis", "factors", "--at", "many"], "there is: path"),
        (&["partition-offsets", "--scene", "data:a.obj"], "DAPPLE_DATA"),
        (&["partition-offsets", "--axis", "leaves", "--form", "cpu", "--scene", "no"], "`no`"),
        (&["partition-offsets", "--limit", "0"], "1.."),
    ] {
        let output = with(arguments);
        code(&output, 2);
        assert!(said(&output).contains(part), "{arguments:?}: {}", said(&output));
    }
}

#[test]
fn without_an_adapter_the_gpu_points_are_there_and_say_so() {
    let folder = tempfile::tempdir().unwrap();
    let output = dapple(folder.path())
        .args(FACTORS)
        .args(["--technique", "multi-draw", "--technique", "cpu-thread", "--format", "jsonl"])
        .env("VK_DRIVER_FILES", "/nonexistent")
        .env("VK_ICD_FILENAMES", "/nonexistent")
        .output()
        .unwrap();
    code(&output, 0);
    let points = printed(&output);
    let (gpu, cpu): (Vec<_>, Vec<_>) = points.iter().partition(|p| p.form == "gpu");
    assert_eq!((gpu.len(), cpu.len()), (10, 10));
    assert!(gpu.iter().all(|p| p.verdict == "not-run" && p.reason.contains("no graphics adapter")));
    assert!(cpu.iter().all(|p| p.is_safe()));
    assert!(said(&output).contains("not run: no graphics adapter"), "{}", said(&output));
}

#[test]
fn one_point_is_shown_with_pictures_and_told_to_a_dashboard() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let point = ["stress", "shadow-filtering", "--axis", "bias", "--technique", "hard", "--form"];
    let here = ["cpu", "--at", "0", "--param", "width=32", "-o", "out"];
    let output = run(at, &[&point[..], &here].concat());
    code(&output, 0);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("hard/plain (cpu) at bias = 0"), "{text}");
    for name in ["truth.png", "result.png", "error.png"] {
        let image = image::open(at.join("out").join(name)).unwrap();
        assert_eq!((image.width(), image.height()), (32, 18));
    }
    assert!(!at.join("records").exists(), "a look records nothing");

    let output = run(at, &[&point[..], &here, &["--feed"]].concat());
    code(&output, 0);
    let text = String::from_utf8_lossy(&output.stdout);
    let told: Vec<FeedLine> =
        text.lines().filter_map(|line| FeedLine::parse(line).unwrap()).collect();
    assert!(matches!(&told[0], FeedLine::Record(Line::Stress(p)) if p.label == "0"), "{text}");
    let picture = |l: &FeedLine| matches!(l, FeedLine::Event(Feed::Picture { width: 32, .. }));
    assert!(told.iter().any(picture), "{text}");
    assert_eq!(told.last(), Some(&FeedLine::Event(Feed::Done { code: 0 })));
}

#[test]
fn a_run_is_told_to_a_dashboard_as_it_goes() {
    let folder = tempfile::tempdir().unwrap();
    let output = run(folder.path(), &[&FACTORS[..], &CPU, &["--feed"]].concat());
    code(&output, 0);
    let text = String::from_utf8_lossy(&output.stdout);
    let told: Vec<FeedLine> =
        text.lines().filter_map(|line| FeedLine::parse(line).unwrap()).collect();
    let started = FeedLine::Event(Feed::Started { path: String::new(), total: 20, resumed: 0 });
    let without_path = |line: &FeedLine| match line {
        FeedLine::Event(Feed::Started { total, resumed, .. }) => {
            let (path, total, resumed) = (String::new(), *total, *resumed);
            FeedLine::Event(Feed::Started { path, total, resumed })
        }
        other => other.clone(),
    };
    assert_eq!(without_path(&told[0]), started);
    let points = told.iter().filter(|l| matches!(l, FeedLine::Record(Line::Stress(_)))).count();
    assert_eq!(points, 20);
    assert!(told.contains(&FeedLine::Event(Feed::Progress { done: 20 })));
    assert_eq!(told.last(), Some(&FeedLine::Event(Feed::Done { code: 0 })));
}
