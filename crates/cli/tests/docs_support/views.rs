//! Markdown views of `dapple list PROBLEM --format csv`.

use crate::common;
use std::{collections::BTreeMap, fmt::Write, path::Path};

/// A row of the list.
struct Row {
    technique: String,
    kind: String,
    name: String,
    values: String,
    what: String,
}

fn rows(printed: &str) -> Vec<Row> {
    let mut reader = csv::Reader::from_reader(printed.as_bytes());
    let header = reader.headers().unwrap().clone();
    let column = |name: &str| {
        header.iter().position(|h| h == name).unwrap_or_else(|| panic!("no column `{name}`"))
    };
    let columns = ["technique", "kind", "name", "default", "values", "what"].map(column);
    let rows: Vec<Row> = reader
        .records()
        .map(|record| {
            let record = record.unwrap();
            let [technique, kind, name, default, values, what] =
                columns.map(|c| record[c].to_string());
            let turns = kind == "knob" || kind == "parameter";
            let values = if turns { format!("{values} [{default}]") } else { values };
            Row { technique, kind, name, values, what }
        })
        .collect();
    assert!(!rows.is_empty());
    rows
}

/// The view of that name.
pub fn markdown(view: &str, printed: &str, folder: &Path) -> String {
    match view {
        "techniques" => techniques(printed, folder),
        "knobs" => knobs(&rows(printed)),
        other => panic!("no view `{other}`; there is: techniques, knobs"),
    }
}

/// Every problem of `dapple list` with its techniques.
fn techniques(printed: &str, folder: &Path) -> String {
    let mut reader = csv::Reader::from_reader(printed.as_bytes());
    let mut table =
        String::from("| problem | technique | variants | forms | source |\n|---|---|---|---|---|");
    let records: Vec<_> = reader.records().map(Result::unwrap).collect();
    for problem in records.iter().filter(|r| &r[0] == "problem") {
        let list = common::run(folder, &["list", &problem[1], "--format", "csv"]);
        let rows = rows(&String::from_utf8(list.stdout).unwrap());
        let page = format!("[{0}](docs/{0}.md)", &problem[1]);
        let mut shown = page.as_str();
        for t in rows.iter().filter(|r| r.kind == "technique") {
            let variants: Vec<_> = rows
                .iter()
                .filter(|r| r.kind == "variant" && r.technique == t.technique)
                .map(|r| r.name.as_str())
                .collect();
            let variants = if variants == ["plain"] { String::new() } else { variants.join(", ") };
            let _ = write!(
                table,
                "\n| {shown} | `{}` {} | {variants} | {} | {} |",
                t.technique, t.name, t.values, t.what
            );
            shown = "";
        }
    }
    table
}

/// Case parameters, then each knob once with the techniques that have it.
fn knobs(rows: &[Row]) -> String {
    let all: Vec<&str> =
        rows.iter().filter(|r| r.kind == "technique").map(|r| r.technique.as_str()).collect();
    let mut order: Vec<(&Row, Vec<&str>)> = Vec::new();
    let mut places: BTreeMap<[&str; 3], usize> = BTreeMap::new();
    for row in rows.iter().filter(|r| r.kind == "knob" || r.kind == "parameter") {
        let key = [row.name.as_str(), row.values.as_str(), row.what.as_str()];
        let place = *places.entry(key).or_insert(order.len());
        if place == order.len() {
            order.push((row, Vec::new()));
        }
        order[place].1.push(&row.technique);
    }
    let mut table =
        String::from("| knob | values [default] | what | techniques |\n|---|---|---|---|");
    for (row, of) in order {
        let of = if row.kind == "parameter" {
            "(of the case: `--param`)".into()
        } else if of.len() == all.len() {
            "all".into()
        } else if 2 * of.len() > all.len() {
            let without: Vec<_> = all.iter().filter(|t| !of.contains(t)).copied().collect();
            format!("all but {}", without.join(", "))
        } else {
            of.join(", ")
        };
        let values = row.values.replace('|', "\\|");
        let _ = write!(table, "\n| `{}` | {values} | {} | {of} |", row.name, row.what);
    }
    table
}
