//! `dapple compare` as a build server uses it.

mod common;

use common::{dapple, run, said};
use dapple_records::{Row, Status, Value};
use std::{collections::BTreeMap, fs, path::Path, process::Output};

fn row(technique: &str, form: &str) -> Row {
    let device = if form == "gpu" { "software" } else { "cpu" };
    Row {
        run: "r".into(),
        group: format!("0000.{technique}"),
        problem: "shadow-filtering".into(),
        technique: technique.into(),
        variant: "plain".into(),
        form: form.into(),
        knobs: BTreeMap::from([("resolution".into(), Value::from(256))]),
        case: "spheres".into(),
        scene_hash: "feed".into(),
        view: "front".into(),
        size: "192x144".into(),
        truth: "8 rays".into(),
        adapter: device.into(),
        device: device.into(),
        cpu: "a processor".into(),
        threads: 2,
        machine: "here".into(),
        revision: "abc".into(),
        time: "2026-01-02T03:04:05.678Z".into(),
        clock: "wall".into(),
        samples_ns: vec![vec![1000], vec![1010], vec![990]],
        errors: BTreeMap::from([("rmse".into(), 0.1), ("leak".into(), 0.02)]),
        counters: BTreeMap::from([("texels".into(), 100)]),
        ..Row::default()
    }
    .identified()
}

fn write(folder: &Path, name: &str, rows: &[Row]) {
    let lines: Vec<String> = rows.iter().map(Row::to_line).collect();
    fs::write(folder.join(name), lines.join("\n")).unwrap();
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// Compares what was written with the arguments of the build server.
fn as_in_ci(folder: &Path) -> Output {
    run(
        folder,
        &["compare", "old.jsonl", "new.jsonl", "--any-machine", "--fail-on", "worse,counters,gone"],
    )
}

fn both() -> Vec<Row> {
    ["cpu", "gpu"].iter().flat_map(|form| ["vsm", "msm"].map(|t| row(t, form))).collect()
}

#[test]
fn a_counter_and_an_error_that_changed_fail_the_build_and_name_the_row() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write(at, "new.jsonl", &both());
    write(at, "old.jsonl", &both());
    let output = as_in_ci(at);
    assert_eq!(output.status.code(), Some(0), "{}{}", stdout(&output), said(&output));
    assert!(stdout(&output).starts_with("4 rows compared, no change"), "{}", stdout(&output));

    type Change = fn(&mut Row);
    let changes: [(Change, &str); 4] = [
        (|r| *r.errors.get_mut("rmse").unwrap() /= 2.0, "rmse 0.05000 → 0.1000"),
        (|r| *r.counters.get_mut("texels").unwrap() += 1, "texels 101 → 100"),
        (|r| *r = Row { technique: "evsm".into(), ..r.clone() }.identified(), "gone"),
        (|r| r.counters = BTreeMap::from([("taps".into(), 9)]), "taps 9 → none"),
    ];
    for (change, expect) in changes {
        let mut old = both();
        change(&mut old[3]);
        write(at, "old.jsonl", &old);
        let output = as_in_ci(at);
        let text = stdout(&output);
        assert_eq!(output.status.code(), Some(1), "{expect}\n{text}{}", said(&output));
        assert!(text.contains(expect), "{expect} in\n{text}");
        let name = if expect == "gone" { "evsm/plain (gpu)" } else { "msm/plain (gpu)" };
        assert!(text.contains(name) && !text.contains("vsm/plain (cpu)"), "{text}");
        assert!(said(&output).contains("failed: 1 rows by --fail-on"), "{}", said(&output));
        // What fails is what was named.
        let output = run(at, &["compare", "old.jsonl", "new.jsonl", "--fail-on", "slower"]);
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    }
    // The last bits of another driver are no change.
    let mut old = both();
    *old[3].errors.get_mut("rmse").unwrap() += 1e-4;
    write(at, "old.jsonl", &old);
    assert_eq!(as_in_ci(at).status.code(), Some(0));
}

#[test]
fn cases_of_one_name_are_told_apart_by_their_truth() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let other = |row: Row| Row { truth: "64 rays".into(), ..row }.identified();
    let old = [both(), both().into_iter().map(other).collect()].concat();
    let mut new = old.clone();
    *new[5].errors.get_mut("rmse").unwrap() *= 2.0;
    write(at, "old.jsonl", &old);
    write(at, "new.jsonl", &new);
    let text = stdout(&as_in_ci(at));
    assert!(text.contains("8 rows compared, 1 worse"), "{text}");
    assert!(text.contains("spheres, 64 rays") && !text.contains("spheres, 8 rays"), "{text}");
    // A name that stands for one case stands alone.
    write(at, "old.jsonl", &old[4..]);
    write(at, "new.jsonl", &new[4..]);
    assert!(!stdout(&as_in_ci(at)).contains("64 rays"));
}

#[test]
fn rows_that_no_adapter_could_run_are_said_and_fail_only_where_one_is_demanded() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write(at, "old.jsonl", &both());
    let reason = "no adapter at hand";
    let new = both().into_iter().map(|row| match row.form.as_str() {
        "gpu" => Row {
            status: Status::NotRun { reason: reason.into() },
            adapter: "none".into(),
            device: "none".into(),
            scene_hash: String::new(),
            truth: "width=192".into(),
            samples_ns: Vec::new(),
            errors: BTreeMap::new(),
            counters: BTreeMap::new(),
            ..row
        }
        .identified(),
        _ => row,
    });
    write(at, "new.jsonl", &new.collect::<Vec<_>>());
    let output = as_in_ci(at);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(stdout(&output).contains("4 rows compared, 2 not run"), "{}", stdout(&output));
    assert!(stdout(&output).contains(reason));
    let arguments =
        ["compare", "old.jsonl", "new.jsonl", "--any-machine", "--fail-on", "worse,counters"];
    let output = dapple(at).args(arguments).env("DAPPLE_REQUIRE_GPU", "1").output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
}

#[test]
fn slower_rows_fail_where_asked_and_every_format_tells_them() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let mut new = both();
    new[1].samples_ns.iter_mut().flatten().for_each(|ns| *ns *= 2);
    new[2].status = Status::Failed { stage: "check".into(), reason: "off | by one".into() };
    write(at, "old.jsonl", &both());
    write(at, "new.jsonl", &new);
    let compare = |more: &[&str]| run(at, &[&["compare", "old.jsonl", "new.jsonl"], more].concat());
    assert_eq!(compare(&[]).status.code(), Some(0));
    assert_eq!(compare(&["--fail-on", "counters,gone"]).status.code(), Some(0));
    let output = compare(&["--fail-on", "slower"]);
    assert_eq!(output.status.code(), Some(1));
    let text = stdout(&output);
    let lines: Vec<&str> = text.lines().collect();
    // Worst first: the failure, then the slower row; what did not change is not shown.
    assert!(lines[1].contains("fails") && lines[1].contains("vsm/plain (gpu)"), "{text}");
    assert!(lines[2].contains("slower") && lines[2].contains("2.000"), "{text}");
    assert!(text.contains("4 rows compared, 1 fails, 1 slower"), "{text}");
    assert!(text.contains("geometric mean 1.260"), "{text}");

    let json = stdout(&compare(&["--format", "jsonl", "--all"]));
    let objects: Vec<Value> = json.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let changes: Vec<&str> = objects.iter().map(|o| o["change"].as_str().unwrap()).collect();
    assert_eq!(changes, ["fails", "slower", "same", "same"]);
    assert_eq!((&objects[1]["technique"], &objects[1]["ratio"]), (&"msm".into(), &2.0.into()));
    let nested = objects.iter().flat_map(|o| o.as_object().unwrap().values()).any(Value::is_object);
    assert!(!nested, "{json}");

    let page = stdout(&compare(&["--format", "markdown"]));
    let table: Vec<&str> = page.lines().filter(|line| line.starts_with('|')).collect();
    assert_eq!(table.len(), 4, "{page}");
    let bars = |line: &str| line.replace(r"\|", "").matches('|').count();
    assert!(table.iter().all(|line| bars(line) == bars(table[0])), "{page}");
}

#[test]
fn what_cannot_be_compared_is_refused_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write(at, "old.jsonl", &both());
    let elsewhere = both().into_iter().map(|row| Row { machine: "there".into(), ..row });
    write(at, "there.jsonl", &elsewhere.collect::<Vec<_>>());
    write(at, "other.jsonl", &[Row { problem: "other".into(), ..row("vsm", "cpu") }.identified()]);
    write(at, "empty.jsonl", &[]);
    for (new, more, expect) in [
        ("there.jsonl", &[][..], "of machine here with 2 threads before, on"),
        ("other.jsonl", &[], "no row in common"),
        ("empty.jsonl", &[], "no rows in empty.jsonl"),
        ("old.jsonl", &["--threshold", "nan"], "must be a finite share"),
        ("old.jsonl", &["--threshold=-1"], "must be a finite share"),
        ("old.jsonl", &["--any-machine", "--fail-on", "slower"], "are not judged"),
    ] {
        let output = run(at, &[&["compare", "old.jsonl", new], more].concat());
        assert_eq!(output.status.code(), Some(2), "{new} {more:?}: {}", said(&output));
        assert!(said(&output).contains(expect), "{new} {more:?}: {}", said(&output));
    }
    let output = run(at, &["compare", "old.jsonl", "there.jsonl", "--any-machine"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(stdout(&output).contains("4 times are not judged"), "{}", stdout(&output));
    assert_eq!(run(at, &["compare", "old.jsonl", "missing"]).status.code(), Some(3));
}

/// The repository's own baseline is one that the build server can compare with.
#[test]
fn the_baseline_in_the_repository_is_whole_and_holds_no_time() {
    let baseline = concat!(env!("CARGO_MANIFEST_DIR"), "/../../benches/baseline");
    let read = dapple_records::read_dir(Path::new(baseline)).unwrap();
    assert_eq!(read.skipped_count(), 0);
    assert!(read.rows.len() >= 100, "{} rows", read.rows.len());
    let forms = |form: &str| read.rows.iter().filter(|row| row.form == form).count();
    assert!(forms("cpu") >= 50 && forms("gpu") >= 50, "{} {}", forms("cpu"), forms("gpu"));
    for row in &read.rows {
        dapple_records::validate(row).unwrap();
        assert_eq!(row.status, Status::Ok, "{} {}", row.case, row.technique);
        assert!(row.samples_ns.is_empty() && row.ratio.is_none());
    }
    // Every setting of the sweep is there: a sweep that grew needs a new baseline.
    let (_, sweep) = dapple_suite::sweep::load("quick").unwrap();
    assert_eq!(read.rows.len(), sweep.plan("quick").unwrap().rows());
}
