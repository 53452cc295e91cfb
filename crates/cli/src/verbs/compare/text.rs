//! A comparison as a table, as JSON lines, and as Markdown.

use super::{Compared, put_summary, summary};
use crate::{
    args::Format,
    figures::knobs,
    output::{Table, note, put, significant},
};
use anyhow::Result;
use dapple_records::{
    Row, Status,
    compare::{Change, Pair, TimeChange, Verdict},
    text::duration,
};
use serde_json::{Map, Value};

impl<'a> Compared<'a> {
    fn shown(&self) -> impl Iterator<Item = &'a Pair> {
        let all = self.all;
        self.comparison.pairs.iter().filter(move |pair| all || pair.is_changed())
    }

    fn sides(&self, pair: &Pair) -> (Option<&'a Row>, Option<&'a Row>) {
        (pair.old.map(|i| &self.old[i]), pair.new.map(|i| &self.new[i]))
    }
}

const COLUMNS: [&str; 8] = ["", "technique", "case", "before", "after", "ratio", "noise", "what"];

/// What a line of the table says of a pair.
struct Words {
    change: String,
    technique: String,
    case: String,
    before: String,
    after: String,
    ratio: Option<f64>,
    noise: String,
    what: String,
}

fn words(compared: &Compared<'_>, pair: &Pair) -> Words {
    let (old, new) = compared.sides(pair);
    let changes: Vec<&str> = pair.changes.iter().map(|c| c.name()).collect();
    let row = new.or(old);
    let technique = row.map(|row| {
        let knobs = knobs(row);
        let space = if knobs.is_empty() { "" } else { " " };
        format!("{}/{} ({}){space}{knobs}", row.technique, row.variant, row.form)
    });
    let time = pair.time.as_ref();
    Words {
        change: if changes.is_empty() { "same".into() } else { changes.join(", ") },
        technique: technique.unwrap_or_default(),
        case: row.map(|row| case(compared, row)).unwrap_or_default(),
        before: time.map(|t| duration(t.old_ns)).unwrap_or_default(),
        after: time.map(|t| duration(t.new_ns)).unwrap_or_default(),
        ratio: time.map(|t| t.ratio).filter(|ratio| ratio.is_finite()),
        noise: time.map(noise).unwrap_or_default(),
        what: what(pair, new),
    }
}

/// The case's name, with its truth where other cases have the same name.
fn case(compared: &Compared<'_>, row: &Row) -> String {
    match compared.same_names.contains(&(row.problem.as_str(), row.case.as_str())) {
        true => format!("{}, {}", row.case, row.truth),
        false => row.case.clone(),
    }
}

/// The band that noise explains; nothing where no verdict rests on it.
fn noise(time: &TimeChange) -> String {
    match time.because {
        "" => format!("±{:.0}%", 100.0 * time.band),
        _ => "not judged".into(),
    }
}

/// Errors and counters that changed, or why there is no result.
fn what(pair: &Pair, new: Option<&Row>) -> String {
    let mut parts = Vec::new();
    match new.map(|row| &row.status) {
        Some(Status::Failed { stage, reason }) => parts.push(format!("{stage}: {reason}")),
        Some(Status::NotRun { reason }) => parts.push(reason.clone()),
        Some(Status::Ok) | None => {}
    }
    let number = |value: Option<f64>| value.map_or_else(|| "none".into(), significant);
    let count = |value: Option<u64>| value.map_or_else(|| "none".into(), |v| v.to_string());
    for e in &pair.errors {
        if !matches!(e.verdict, Verdict::Same | Verdict::NotJudged) {
            parts.push(format!("{} {} → {}", e.metric, number(e.old), number(e.new)));
        }
    }
    for c in &pair.counters {
        parts.push(format!("{} {} → {}", c.name, count(c.old), count(c.new)));
    }
    parts.join("; ")
}

/// For people, worst first.
pub fn table(compared: &Compared<'_>) -> Result<()> {
    let mut table = Table::new(&COLUMNS);
    let mut lines = 0;
    for pair in compared.shown() {
        let w = words(compared, pair);
        table.row([
            w.change.into(),
            w.technique.into(),
            w.case.into(),
            w.before.into(),
            w.after.into(),
            w.ratio.into(),
            w.noise.into(),
            w.what.into(),
        ]);
        lines += 1;
    }
    if lines > 0 {
        table.print(Format::Table)?;
        put!("")?;
    }
    Ok(put_summary(compared)?)
}

/// For a pull request.
pub fn markdown(compared: &Compared<'_>) -> Result<()> {
    put!("### dapple compare\n")?;
    for line in summary(compared).lines() {
        put!("{line}  ")?;
    }
    let mut begun = false;
    for pair in compared.shown() {
        if !begun {
            put!("\n| change | technique | case | before | after | ratio | noise | what |")?;
            put!("|---|---|---|--:|--:|--:|--:|---|")?;
            begun = true;
        }
        let w = words(compared, pair);
        let ratio = w.ratio.map(significant).unwrap_or_default();
        let cells = [w.change, w.technique, w.case, w.before, w.after, ratio, w.noise, w.what];
        put!("| {} |", cells.map(|cell| escaped(&cell)).join(" | "))?;
    }
    Ok(())
}

/// Text as a cell of a Markdown table: no bar, line feed or markup of its own.
fn escaped(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '|' | '*' | '_' | '`' | '<' | '[' | '\\' | '~' | '#' => out.extend(['\\', c]),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

/// For programs: one flat object a row; the summary goes to standard error.
pub fn jsonl(compared: &Compared<'_>) -> Result<()> {
    for pair in compared.shown() {
        put!("{}", Value::Object(object(compared, pair)))?;
    }
    note!("{}", summary(compared));
    Ok(())
}

fn object(compared: &Compared<'_>, pair: &Pair) -> Map<String, Value> {
    let (old, new) = compared.sides(pair);
    let mut out = Map::new();
    let mut put = |key: String, value: Value| out.insert(key, value);
    let first = pair.changes.first().copied();
    put("change".into(), first.map_or("same", Change::name).into());
    let changes: Vec<_> = pair.changes.iter().map(|c| c.name()).collect();
    put("changes".into(), changes.into());
    if let Some(row) = new.or(old) {
        for (key, text) in [
            ("problem", &row.problem),
            ("technique", &row.technique),
            ("variant", &row.variant),
            ("form", &row.form),
            ("case", &row.case),
            ("view", &row.view),
            ("size", &row.size),
            ("truth", &row.truth),
        ] {
            put(key.into(), text.as_str().into());
        }
        for (name, value) in &row.knobs {
            put(format!("knob.{name}"), value.clone());
        }
    }
    for (side, row) in [("old", old), ("new", new)] {
        let Some(row) = row else { continue };
        let status = match &row.status {
            Status::Ok => "ok",
            Status::Failed { .. } => "failed",
            Status::NotRun { .. } => "not_run",
        };
        put(format!("{side}.status"), status.into());
        for (key, text) in [
            ("run", &row.run),
            ("row", &row.row),
            ("machine", &row.machine),
            ("adapter", &row.adapter),
            ("revision", &row.revision),
            ("time", &row.time),
        ] {
            put(format!("{side}.{key}"), text.as_str().into());
        }
    }
    if let Some(time) = &pair.time {
        put("old.median_ns".into(), time.old_ns.into());
        put("new.median_ns".into(), time.new_ns.into());
        put("ratio".into(), time.ratio.into());
        put("band".into(), time.band.into());
        put("time".into(), verdict(time.verdict).into());
        put("not_judged".into(), time.because.into());
    }
    for e in &pair.errors {
        put(format!("old.error.{}", e.metric), e.old.into());
        put(format!("new.error.{}", e.metric), e.new.into());
        put(format!("error.{}", e.metric), verdict(e.verdict).into());
    }
    for c in &pair.counters {
        put(format!("old.counter.{}", c.name), c.old.into());
        put(format!("new.counter.{}", c.name), c.new.into());
    }
    out
}

fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Same => "same",
        Verdict::Better => "better",
        Verdict::Worse => "worse",
        Verdict::Appeared => "appeared",
        Verdict::Vanished => "vanished",
        Verdict::NotJudged => "not judged",
    }
}

#[cfg(test)]
mod tests {
    use super::escaped;

    #[test]
    fn a_cell_of_a_table_stays_one_cell() {
        assert_eq!(escaped("a|b\nc*d_e"), r"a\|b c\*d\_e");
        assert_eq!(escaped("plain 1 → 2"), "plain 1 → 2");
    }
}
