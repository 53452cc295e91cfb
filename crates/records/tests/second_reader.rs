//! Another JSON reader gets from our lines what we put in, and finds them flat: each key holds one
//! type of scalar, or a list, on every line. That is what column readers need to infer a table.
// Helpers of tests may panic as tests do.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::collections::{BTreeMap, HashMap};

use dapple_records::{ClaimFigure, ClaimLine, GateLine, Line, RunHeader, StressLine, Writer};
use tinyjson::JsonValue;

type Object = HashMap<String, JsonValue>;

fn objects(text: &str) -> Vec<Object> {
    let object = |line: &str| match line.parse::<JsonValue>().unwrap() {
        JsonValue::Object(object) => object,
        other => panic!("not an object: {other:?}"),
    };
    text.lines().map(object).collect()
}

/// The column's type; none for an object, or a list that holds one.
fn column(value: &JsonValue) -> Option<String> {
    match value {
        JsonValue::Null => Some("null".into()),
        JsonValue::Boolean(_) => Some("flag".into()),
        JsonValue::Number(_) => Some("number".into()),
        JsonValue::String(_) => Some("text".into()),
        JsonValue::Object(_) => None,
        JsonValue::Array(items) => {
            let inner: Vec<String> = items.iter().map(column).collect::<Option<_>>()?;
            let inner = inner.iter().find(|t| *t != "null").map_or("null", String::as_str);
            Some(format!("list of {inner}"))
        }
    }
}

/// Keys that no column of one type could hold.
fn misfits(objects: &[Object]) -> Vec<String> {
    let mut columns: BTreeMap<&str, String> = BTreeMap::new();
    let mut misfits = Vec::new();
    for (key, value) in objects.iter().flatten() {
        match column(value) {
            None => misfits.push(key.clone()),
            Some(null) if null.ends_with("null") => {}
            Some(found) => {
                if *columns.entry(key).or_insert_with(|| found.clone()) != found {
                    misfits.push(key.clone());
                }
            }
        }
    }
    misfits
}

fn text(object: &Object, key: &str) -> String {
    object.get(key).and_then(|v| v.get::<String>()).cloned().unwrap_or_else(|| panic!("{key}"))
}

fn number(object: &Object, key: &str) -> f64 {
    *object.get(key).and_then(|v| v.get::<f64>()).unwrap_or_else(|| panic!("{key}"))
}

#[test]
fn another_reader_gets_the_same_values() {
    let rows: Vec<_> = (0..50).map(|n| common::row(n * 977)).collect();
    let run = String::from("00000000000000aa");
    let header =
        RunHeader { run: run.clone(), sweep: "s".into(), threads: 2, ..Default::default() };
    let gate = GateLine {
        run: run.clone(),
        problem: "p".into(),
        technique: "t".into(),
        gate: "g".into(),
        outcome: "passed".into(),
        checked: 1 << 40,
        worst: Some(0.1),
        ..GateLine::default()
    };
    let figure =
        |value: f64| ClaimFigure { what: "time \"here\"".into(), value, unit: "µs".into() };
    let claim = ClaimLine {
        run: run.clone(),
        problem: "p".into(),
        id: "c".into(),
        verdict: "open".into(),
        figures: vec![figure(1.5), figure(f64::NAN)],
        ..ClaimLine::default()
    };
    let stress = StressLine {
        run: run.clone(),
        problem: "p".into(),
        case: "c".into(),
        technique: "t".into(),
        form: "cpu".into(),
        axis: "scale".into(),
        verdict: "safe".into(),
        value: 1e-6,
        knobs: [("width".into(), 3.into())].into(),
        error: Some(5e-324),
        ..StressLine::default()
    };

    let folder = tempfile::tempdir().unwrap();
    let mut writer = Writer::create(folder.path(), &header).unwrap();
    for row in &rows {
        writer.append(&dapple_records::Row { run: run.clone(), ..row.clone() }).unwrap();
    }
    for line in [
        Line::Gate(Box::new(gate.clone())),
        Line::Claim(Box::new(claim.clone())),
        Line::Stress(Box::new(stress.clone())),
    ] {
        writer.append_line(&line).unwrap();
    }
    writer.end().unwrap();

    let found = objects(&std::fs::read_to_string(writer.path()).unwrap());
    assert_eq!(found.len(), 1 + rows.len() + 3 + 1);
    assert_eq!(misfits(&found), Vec::<String>::new());
    for object in &found {
        assert_eq!((number(object, "schema"), text(object, "run")), (1.0, run.clone()));
    }
    assert_eq!((text(&found[0], "kind"), number(&found[0], "threads")), ("run".into(), 2.0));
    for (row, object) in rows.iter().zip(&found[1..]) {
        assert_eq!(text(object, "kind"), "row");
        for (key, value) in [
            ("row", &row.row),
            ("technique", &row.technique),
            ("form", &row.form),
            ("case", &row.case),
            ("machine", &row.machine),
            ("adapter", &row.adapter),
            ("time", &row.time),
            ("clock", &row.clock),
        ] {
            assert_eq!(text(object, key), *value);
        }
        assert_eq!(text(object, "status"), "ok");
        let bits = |key: &str| number(object, key).to_bits();
        for (name, value) in &row.errors {
            assert_eq!(bits(&format!("error.{name}")), value.to_bits());
        }
        for (name, count) in &row.counters {
            assert_eq!(number(object, &format!("counter.{name}")), *count as f64);
        }
        for (key, value) in
            [("median_ns", row.median_ns()), ("mad_ns", row.mad_ns()), ("ratio", row.ratio)]
        {
            assert_eq!(Some(number(object, key)), value);
        }
        assert_eq!(number(object, "knob.resolution"), row.knobs["resolution"].as_f64().unwrap());
        assert_eq!(number(object, "memory_bytes"), row.memory_bytes as f64);
        let samples: &Vec<JsonValue> = object["samples_ns"].get().unwrap();
        let first: &Vec<JsonValue> = samples[0].get().unwrap();
        assert_eq!((samples.len(), first.len()), (5, 24));
        assert_eq!(first[3].get::<f64>(), Some(&(row.samples_ns[0][3] as f64)));
    }
    let [g, c, s, end] = &found[1 + rows.len()..] else { panic!("four lines behind the rows") };
    assert_eq!((text(g, "gate"), text(g, "outcome")), (gate.gate, gate.outcome));
    assert_eq!((number(g, "checked"), number(g, "worst")), (gate.checked as f64, 0.1));
    assert_eq!((text(c, "id"), text(c, "verdict")), (claim.id, claim.verdict));
    let values: &Vec<JsonValue> = c["figure_value"].get().unwrap();
    assert!(values[0].get::<f64>() == Some(&1.5) && values[1].is_null());
    let whats: &Vec<JsonValue> = c["figure_what"].get().unwrap();
    assert_eq!(whats[1].get::<String>().unwrap(), "time \"here\"");
    assert_eq!((text(s, "axis"), text(s, "verdict")), (stress.axis, stress.verdict));
    assert_eq!((number(s, "value"), number(s, "error")), (1e-6, 5e-324));
    assert_eq!(number(s, "knob.width"), 3.0);
    assert_eq!((text(end, "kind"), number(end, "rows")), ("end".into(), rows.len() as f64));
}

/// Controls: what is nested or changes its type is reported.
#[test]
fn what_fits_no_column_is_caught() {
    for (lines, key) in [
        ("{\"a\":{\"b\":1}}", "a"),
        ("{\"a\":[{\"b\":1}]}", "a"),
        ("{\"a\":1}\n{\"a\":\"1\"}", "a"),
        ("{\"a\":[1]}\n{\"a\":1}", "a"),
        ("{\"a\":[[1]]}\n{\"a\":[1]}", "a"),
    ] {
        assert_eq!(misfits(&objects(lines)), [key], "{lines}");
    }
    assert!(misfits(&objects("{\"a\":null,\"b\":[]}\n{\"a\":1,\"b\":[[1]]}")).is_empty());
}
