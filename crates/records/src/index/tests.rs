//! The index against the reader of whole rows, on the same files.

use std::fs;
use std::io::Write;

use proptest::prelude::*;
use tempfile::TempDir;

use super::*;
use crate::fixtures::{config, header, row};
use crate::front::{Constraint, Fronts, constrained, latest};
use crate::line::RunEnd;
use crate::read::read_dir;
use crate::row::Status;

/// What an entry says, without numbers that depend on the order of reading.
#[derive(Debug, PartialEq)]
struct Said {
    key: Key,
    setting: SettingName,
    run: Option<String>,
    ended: Ended,
    clock: String,
    time_ms: i64,
    bits: [u64; 5],
    values: Vec<(String, u64)>,
    row: String,
}

fn said(index: &Index) -> Vec<Said> {
    index
        .entries
        .iter()
        .map(|entry| {
            let names = index.metrics(entry).iter().chain(index.counters(entry));
            Said {
                key: index.key(entry).clone(),
                setting: index.setting(entry).clone(),
                run: index.headers.get(entry.run as usize).map(|h| h.run.clone()),
                ended: entry.ended,
                clock: index.clock(entry).to_owned(),
                time_ms: entry.time_ms,
                bits: [
                    entry.median_ns.to_bits(),
                    entry.mad_ns.to_bits(),
                    u64::from(entry.p99_ns.to_bits()),
                    entry.memory_bytes,
                    entry.identity,
                ],
                values: names
                    .map(|n| (n.clone(), index.value(entry, n).unwrap().to_bits()))
                    .collect(),
                row: index.row(entry).unwrap().to_line(),
            }
        })
        .collect()
}

fn expected(read: &crate::Read) -> Vec<Said> {
    read.rows
        .iter()
        .map(|row| Said {
            key: crate::front::key(row),
            setting: SettingName {
                technique: row.technique.clone(),
                variant: row.variant.clone(),
                form: row.form.clone(),
            },
            run: read.headers.iter().any(|h| h.run == row.run).then(|| row.run.clone()),
            ended: match row.status {
                Status::Ok => Ended::Ok,
                Status::Failed { .. } => Ended::Failed,
                Status::NotRun { .. } => Ended::NotRun,
            },
            clock: row.clock.clone(),
            time_ms: crate::time::millis(&row.time).unwrap_or_default(),
            bits: [
                row.median_ns().unwrap_or(f64::NAN).to_bits(),
                row.mad_ns().unwrap_or(f64::NAN).to_bits(),
                u64::from(row.p99_ns().map_or(f32::NAN, |ns| ns as f32).to_bits()),
                row.memory_bytes,
                table::identity(&row.row),
            ],
            values: {
                // An error hides a counter of its name.
                let errors = row.errors.iter().map(|(n, v)| (n.clone(), v.to_bits()));
                let counters = row.counters.iter().map(|(n, v)| {
                    let value = row.errors.get(n).copied().unwrap_or(*v as f64);
                    (n.clone(), value.to_bits())
                });
                errors.chain(counters).collect()
            },
            row: row.to_line(),
        })
        .collect()
}

/// Everything public of two indices, but for the order of shared names.
fn assert_same(a: &Index, b: &Index) {
    assert_eq!(said(a), said(b));
    assert_eq!(a.headers, b.headers);
    assert_eq!(a.ended, b.ended);
    assert_eq!(a.gates, b.gates);
    assert_eq!(a.claims, b.claims);
    assert_eq!(a.stress.len(), b.stress.len());
    assert_eq!((&a.skipped, &a.reasons), (&b.skipped, &b.reasons));
    assert_eq!(a.latest(), b.latest());
}

/// Holds an index against the whole rows.
fn assert_agrees(folder: &Path) {
    let (index, read) = (Index::open(folder).unwrap(), read_dir(folder).unwrap());
    assert_eq!(said(&index), expected(&read));
    assert_eq!(index.headers, read.headers);
    let ended: Vec<bool> = read.headers.iter().map(|h| read.ended.contains(&h.run)).collect();
    assert_eq!(index.ended, ended);
    assert_eq!((&index.skipped, &index.reasons), (&read.skipped, &read.reasons));
    let rows: Vec<&Row> = read.rows.iter().collect();
    assert_eq!(index.latest(), latest(&rows));
    let most = Constraint { name: "texels".into(), at_most: 5.0 };
    for constraints in [&[][..], &[most]] {
        for (metric, clock) in [("rmse", "gpu"), ("texels", "wall"), ("leak", "gpu")] {
            let whole = constrained(&rows, metric, clock, constraints);
            let brief = index.fronts(metric, clock, constraints, |_| true);
            assert_eq!(points(&brief), points(&whole));
        }
    }
}

/// Points and who takes no part; why stands in the row for those that failed.
fn points(fronts: &Fronts) -> (usize, Vec<String>) {
    let front = |front: &crate::front::Front| {
        let excluded: Vec<(usize, &str)> = front
            .excluded
            .iter()
            .map(|e| match e.reason.as_str() {
                reason if reason.starts_with("failed") => (e.index, "failed"),
                reason if reason.starts_with("not run") => (e.index, "not run"),
                reason => (e.index, reason),
            })
            .collect();
        format!("{:?} {:?} {excluded:?}", front.key, front.points)
    };
    (fronts.superseded, fronts.fronts.iter().map(front).collect())
}

/// Few distinct values, so that rows repeat, tie and shadow each other.
fn rows() -> impl Strategy<Value = Row> {
    let times = prop::sample::select(vec![
        "2026-01-02T03:04:05.678Z",
        "2026-01-02T03:04:05.679Z",
        "2026-01-02T03:04:05Z",
        "2025-12-31T23:59:60.000Z",
        "2026-01-01T00:00:00.000Z",
        "yesterday",
        "",
    ]);
    let ids = prop::sample::select(vec!["00000000000000aa", "00000000000000ab", "aa", "AA", "x"]);
    let names = (0..3_u8, 0..3_u8, 0..3_u8, 0..4_u8, 0..3_u8);
    let values = (prop::sample::select(vec![0.0, 0.1, 0.25, f64::NAN, 1e-300]), 0..9_u64, 1..9_u64);
    (times, ids, names, values).prop_map(|(time, id, names, (error, counter, ns))| {
        let (run, group, machine, kind, key) = names;
        let mut row = Row {
            run: format!("run{run}"),
            group: format!("group{group}"),
            machine: format!("machine{machine}"),
            case: format!("case{key}"),
            time: time.into(),
            row: id.into(),
            ..row(u64::from(key))
        };
        row.errors.insert("rmse".into(), error);
        row.counters = [("texels".into(), counter), ("rmse".into(), 7)].into();
        row.samples_ns = vec![vec![ns, 3], vec![ns]];
        match kind {
            0 => row.status = Status::Failed { stage: "port".into(), reason: "off".into() },
            1 => row.clock = "wall".into(),
            2 => drop(row.counters.remove("texels")),
            _ => {}
        }
        row
    })
}

fn lines() -> impl Strategy<Value = Vec<u8>> {
    let gate = (0..2_u8, 0..3_u8, 0..3_u8).prop_map(|(gate, time, run)| {
        let (gate, time) = (format!("gate{gate}"), format!("{time}"));
        let run = format!("run{run}");
        let line = GateLine {
            run,
            gate,
            time,
            problem: "p".into(),
            technique: "t".into(),
            outcome: "passed".into(),
            ..GateLine::default()
        };
        line.to_line().into_bytes()
    });
    let run = 0..3_u8;
    let ends = run.clone().prop_map(|run| {
        RunEnd { run: format!("run{run}"), ..RunEnd::default() }.to_line().into_bytes()
    });
    prop_oneof![
        8 => rows().prop_map(|row| row.to_line().into_bytes()),
        1 => gate,
        1 => run.prop_map(|run| header(&format!("run{run}")).to_line().into_bytes()),
        1 => ends,
        1 => prop::collection::vec(any::<u8>(), 0..30),
    ]
}

/// Bytes of a file: lines, some without their line feed, some bytes overwritten or lost.
fn file() -> impl Strategy<Value = Vec<u8>> {
    let damage = prop_oneof![
        3 => Just(None),
        1 => (any::<prop::sample::Index>(), prop::sample::select(b"{}[]\":,\n09ex\\n\xff".to_vec())).prop_map(Some),
    ];
    let ends = prop::sample::select(vec![&b"\n"[..], b"\n", b"\n", b"\r\n", b""]);
    prop::collection::vec((lines(), ends, damage), 0..12).prop_map(|lines| {
        let mut text = Vec::new();
        for (mut line, end, damage) in lines {
            if let (Some((at, byte)), false) = (damage, line.is_empty()) {
                let at = at.index(line.len());
                line[at] = byte;
            }
            text.extend(line);
            text.extend(end);
        }
        text
    })
}

fn append(path: &Path, bytes: &[u8]) {
    fs::OpenOptions::new().create(true).append(true).open(path).unwrap().write_all(bytes).unwrap();
}

fn folder(files: &[(&str, String)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn the_index_says_what_the_rows_say(files in prop::collection::vec(file(), 1..4)) {
        let folder = tempfile::tempdir().unwrap();
        for (i, bytes) in files.iter().enumerate() {
            fs::write(folder.path().join(format!("{i}.jsonl")), bytes).unwrap();
        }
        assert_agrees(folder.path());
    }

    #[test]
    fn refreshing_after_any_appends_is_opening(
        files in prop::collection::vec(file(), 3),
        steps in prop::collection::vec((0..3_usize, any::<prop::sample::Index>()), 1..8),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let mut index = Index::open(folder.path()).unwrap();
        let mut written = [0; 3];
        for (file, upto) in steps {
            let upto = written[file] + upto.index(files[file].len() - written[file] + 1);
            let bytes = &files[file][written[file]..upto];
            append(&folder.path().join(format!("{}.jsonl", 2 - file)), bytes);
            written[file] = upto;
            index.refresh().unwrap();
            assert_same(&index, &Index::open(folder.path()).unwrap());
        }
        prop_assert!(!index.refresh().unwrap(), "nothing was appended");
    }

    #[test]
    fn a_brief_row_is_the_row_or_left_to_the_full_reader(
        row in rows(),
        hits in prop::collection::vec(
            (any::<prop::sample::Index>(), prop::sample::select(b"{}[]\":,. 0-9eE\\ntrue\x01\xc3".to_vec())),
            0..4,
        ),
    ) {
        let mut line = row.to_line().into_bytes();
        prop_assert!(Brief::parse(&line).is_some(), "the fast way is not taken");
        for (at, byte) in hits {
            let at = at.index(line.len());
            line[at] = byte;
        }
        if let Some(brief) = Brief::parse(&line) {
            match Line::parse(&line) {
                Ok(Line::Row(row)) => prop_assert_eq!(
                    format!("{brief:?}"),
                    format!("{:?}", Brief::of(&row))
                ),
                other => prop_assert!(false, "the full reader says {:?}", other),
            }
        }
    }
}

#[test]
fn odd_but_valid_lines_are_read_alike() {
    let line = row(0).to_line();
    let with = |text: &str| line.replacen('{', &format!("{{{text},"), 1);
    let odd = [
        with(r#""kind":"gate""#),
        with(r#""error.rmse":"text""#),
        with(r#""error.rmse":1,"error.zero":null"#),
        with(r#""knob.deep":[{"a":[1,{"b":"\ud83d\ude00"}]}]"#),
        with(r#""counter.":"no name","pass._ns":-1,"pass.x":[]"#),
        with(r#""threads":2.0,"dirty":null"#),
        with(r#""caf\u00e9":1e308"#),
        line.replace(r#""memory_bytes":1099511627776"#, r#""memory_bytes":5.0"#),
        line.replace(r#""samples_ns":[[100,200],[300]]"#, r#""samples_ns":null"#),
        line.replace(r#""view":"front""#, r#""view":"fr\u006fnt""#),
    ];
    let files: Vec<(String, String)> =
        odd.into_iter().enumerate().map(|(i, line)| (format!("{i}.jsonl"), line)).collect();
    let files: Vec<(&str, String)> = files.iter().map(|(n, t)| (n.as_str(), t.clone())).collect();
    for file in &files {
        assert_ne!(file.1, line);
        assert_agrees(folder(std::slice::from_ref(file)).path());
    }
    let bad = [with(r#""later":1e999"#), with(&format!(r#""deep":{}1"#, "[".repeat(200)))];
    for line in bad {
        assert!(Brief::parse(line.as_bytes()).is_none() && Line::parse(line.as_bytes()).is_err());
    }
}

#[test]
fn a_row_is_read_from_its_place_or_not_at_all() {
    let (first, second) = (row(0), row(1));
    let text = format!("{}\n{}{}\n", header("a").to_line(), first.to_line(), second.to_line());
    let folder = folder(&[("a.jsonl", text.clone())]);
    let path = folder.path().join("a.jsonl");
    let index = Index::open(folder.path()).unwrap();
    let rows: Vec<Row> = index.entries.iter().map(|e| index.row(e).unwrap()).collect();
    assert_eq!(rows, [first, second], "also two rows in one line");
    let changes: [(&str, &str); 5] = [
        (r#""knob.resolution":1"#, r#""knob.resolution":2"#),
        (r#""samples_ns":[[101,200],[300]]"#, r#""samples_ns":[[101,200],[301]]"#),
        (r#""technique":"vsm""#, r#""technique":"msm""#),
        ("05.678Z", "06.678Z"),
        ("}{", "} "),
    ];
    for (from, to) in changes {
        let changed = text.replace(from, to);
        assert!(changed.len() == text.len() && changed != text, "{from}");
        fs::write(&path, &changed).unwrap();
        let read: Vec<_> = index.entries.iter().map(|entry| index.row(entry)).collect();
        // A knob is part of the identity, which stands in the line itself: a change of the one
        // without the other shows only there.
        let wrong = read.iter().flatten().filter(|r| !rows.contains(r)).count();
        assert!(wrong == 0 || from.contains("knob"), "{from}");
        assert!(read.iter().any(Result::is_err) || from.contains("knob"), "{from}");
    }
    fs::write(&path, &text[1..]).unwrap();
    let error = index.row(&index.entries[0]).unwrap_err();
    assert!(matches!(error, RecordError::Moved(_)) && error.to_string().contains("a.jsonl"));
    fs::remove_file(&path).unwrap();
    let error = index.row(&index.entries[0]).unwrap_err();
    assert!(error.to_string().contains("a.jsonl"), "{error}");
}

#[test]
fn only_what_was_appended_is_read_again() {
    let lines: Vec<String> = (0..100).map(|n| row(n).to_line()).collect();
    let folder = folder(&[("a.jsonl", lines.join("\n") + "\n")]);
    let path = folder.path().join("a.jsonl");
    let mut index = Index::open(folder.path()).unwrap();
    // Damage far from both ends goes unseen where nothing but the new line is read.
    let mut bytes = fs::read(&path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle..middle + 50].fill(b'x');
    fs::write(&path, &bytes).unwrap();
    append(&path, (row(100).to_line() + "\n").as_bytes());
    assert!(index.refresh().unwrap());
    assert_eq!(index.entries.len(), 101);
    assert_eq!(index.row(&index.entries[100]).unwrap(), row(100));
    // The control: reading all of it sees the damage.
    assert_eq!(Index::open(folder.path()).unwrap().entries.len(), 100);
}

#[test]
fn files_that_shrink_vanish_or_are_replaced_are_read_anew_and_a_lost_folder_is_empty() {
    let text = |range: std::ops::Range<u64>| -> String {
        range.map(|n| row(n).to_line() + "\n").collect()
    };
    let folder = folder(&[("a.jsonl", text(0..4)), ("b.jsonl", text(4..6))]);
    let path = folder.path().join("a.jsonl");
    let mut index = Index::open(folder.path()).unwrap();
    let mut check = |rows: usize, what: &str| {
        assert!(index.refresh().unwrap(), "{what}");
        assert_eq!(index.entries.len(), rows, "{what}");
        if folder.path().exists() {
            assert_same(&index, &Index::open(folder.path()).unwrap());
        }
        assert!(!index.refresh().unwrap(), "{what}: twice");
    };
    fs::write(&path, text(0..2)).unwrap();
    check(4, "shrunk");
    fs::write(&path, text(10..13)).unwrap();
    check(5, "written over, longer");
    let other = folder.path().join("other");
    fs::write(&other, text(20..23)).unwrap();
    fs::rename(&other, &path).unwrap();
    check(5, "replaced by one of the same length");
    append(&path, b"{\"kind\":\"row\",");
    check(5, "half a line");
    append(&path, b"\n");
    check(5, "the half closed");
    append(&path, row(30).to_line().as_bytes());
    check(6, "a line without its line feed");
    append(&path, b"\n");
    check(6, "its line feed");
    fs::remove_file(&path).unwrap();
    check(2, "vanished");
    fs::write(folder.path().join("0.jsonl"), text(7..8)).unwrap();
    check(3, "a new file, first by name");
    fs::remove_dir_all(folder.path()).unwrap();
    check(0, "the folder gone");
    fs::create_dir(folder.path()).unwrap();
    fs::write(&path, text(0..1)).unwrap();
    check(1, "the folder back");
}

#[test]
fn a_folder_that_cannot_be_listed_is_an_error_and_the_index_stays() {
    let folder = folder(&[("a.jsonl", row(0).to_line())]);
    let mut index = Index::open(folder.path()).unwrap();
    fs::remove_dir_all(folder.path()).unwrap();
    fs::write(folder.path(), "a file").unwrap();
    assert!(index.refresh().unwrap_err().to_string().starts_with("cannot list "));
    assert_eq!(index.entries.len(), 1);
    fs::remove_file(folder.path()).unwrap();
    assert!(Index::open(folder.path()).is_err());
}

#[test]
fn gates_claims_and_stress_points_are_the_latest_over_all_runs() {
    let gate = |run: &str, time: &str, outcome: &str, adapter: &str| GateLine {
        run: run.into(),
        time: time.into(),
        problem: "p".into(),
        technique: "t".into(),
        gate: "g".into(),
        outcome: outcome.into(),
        adapter: adapter.into(),
        ..GateLine::default()
    };
    let claim = |time: &str, verdict: &str| ClaimLine {
        run: time.into(),
        time: time.into(),
        problem: "p".into(),
        id: "c".into(),
        verdict: verdict.into(),
        ..ClaimLine::default()
    };
    let point = |time: &str, value: f64, verdict: &str| StressLine {
        run: time.into(),
        time: time.into(),
        problem: "p".into(),
        case: "c".into(),
        technique: "t".into(),
        form: "cpu".into(),
        axis: "scale".into(),
        value,
        verdict: verdict.into(),
        ..StressLine::default()
    };
    let newer = [
        gate("b", "2", "passed", "x").to_line(),
        claim("2", "reproduced").to_line(),
        point("2", 1.0, "safe").to_line(),
    ];
    let older = [
        gate("a", "1", "failed", "x").to_line(),
        gate("a", "1", "failed", "y").to_line(),
        claim("1", "open").to_line(),
        point("1", 1.0, "broken").to_line(),
        point("1", 2.0, "broken").to_line(),
    ];
    // The older ones stand in the later file.
    let folder = folder(&[("1.jsonl", newer.join("\n")), ("2.jsonl", older.join("\n"))]);
    let index = Index::open(folder.path()).unwrap();
    let outcomes: Vec<&str> = index.gates.iter().map(|g| g.outcome.as_str()).collect();
    assert_eq!(outcomes, ["passed", "failed"]);
    assert_eq!(index.claims, [claim("2", "reproduced")]);
    assert_eq!(index.stress, [point("2", 1.0, "safe"), point("1", 2.0, "broken")]);
}

#[test]
fn rows_with_very_many_values_are_read_from_the_file_where_the_index_ends() {
    let mut many = row(0);
    many.errors = (0..100).map(|n| (format!("e{n:03}"), f64::from(n) / 7.0)).collect();
    let folder = folder(&[("a.jsonl", many.to_line())]);
    let index = Index::open(folder.path()).unwrap();
    let entry = &index.entries[0];
    assert_eq!(index.metrics(entry).len(), table::MOST_VALUES);
    assert_eq!(index.value(entry, "e099"), Some(99.0 / 7.0));
    assert_eq!(index.value(entry, "e001"), Some(1.0 / 7.0));
    assert_eq!(index.value(entry, "texels"), Some(u64::MAX as f64));
    assert_eq!((index.value(entry, "none"), index.error(entry, "texels")), (None, None));
}

#[test]
fn a_file_of_noise_is_counted_and_not_kept() {
    let folder = folder(&[("a.jsonl", "x\n".repeat(300_000) + &row(0).to_line())]);
    let (index, read) = (Index::open(folder.path()).unwrap(), read_dir(folder.path()).unwrap());
    assert_eq!((index.entries.len(), read.rows.len()), (1, 1));
    assert_eq!(index.reasons, read.reasons);
    assert_eq!(read.skipped_count(), 300_000);
    assert_eq!(index.skipped.len(), crate::read::MOST_SKIPPED);
    assert_eq!(index.skipped, read.skipped);
}

#[test]
fn an_entry_is_small() {
    assert!(size_of::<Entry>() <= 96, "{}", size_of::<Entry>());
}
