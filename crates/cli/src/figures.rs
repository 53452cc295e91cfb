//! Rows as tables: fronts, failures, notes.

use crate::{
    args::Format,
    output::{Table, note, put, significant},
};
use anyhow::Result;
use dapple_records::{
    Row, Status,
    front::{self, Front},
    text::{bytes, duration},
};
use dapple_suite::{SuiteError, problem::Spec, problems};
use std::{
    collections::{BTreeMap, BTreeSet},
    io,
};

/// What to print of a set of rows.
pub struct View<'a> {
    /// Error metric; the problem's axis if `None`.
    pub metric: Option<&'a str>,
    /// Print dominated settings too.
    pub all: bool,
    /// Output format.
    pub format: Format,
}

/// Prints the fronts of every problem among the rows, then what is not in them and why.
pub fn print_fronts(rows: &[Row], view: &View<'_>) -> Result<()> {
    let mut by_problem: BTreeMap<&str, Vec<&Row>> = BTreeMap::new();
    for row in rows {
        by_problem.entry(&row.problem).or_default().push(row);
    }
    let mut ranked = Table::new(&RANKED);
    for (id, rows) in by_problem {
        let Ok(problem) = problems::find(id) else {
            note!("{} rows of `{id}`, which this program does not know", rows.len());
            continue;
        };
        let spec = problem.spec();
        let metric = view.metric.unwrap_or(spec.axis);
        if !spec.metrics.iter().any(|m| m.name == metric) {
            let known = spec.metrics.iter().map(|m| m.name);
            return Err(SuiteError::unknown("metric", metric, known).into());
        }
        // Before rows are told apart by status and clock: a technique that fails its check today is
        // not on today's front.
        let rows: Vec<&Row> = front::latest(&rows).into_iter().map(|i| rows[i]).collect();
        print_problem(spec, metric, &rows, view, &mut ranked)?;
    }
    if view.format != Format::Table {
        ranked.print(view.format)?;
    }
    Ok(())
}

/// Prints the fronts of one problem for people, or adds them to `ranked` for programs.
fn print_problem(
    spec: &Spec,
    metric: &str,
    rows: &[&Row],
    view: &View<'_>,
    ranked: &mut Table,
) -> Result<()> {
    let constraints = spec.front_constraints();
    // The clocks are never mixed in one front: device time leaves out what the host waits for.
    for clock in ["gpu", "wall"] {
        let rows: Vec<&Row> =
            rows.iter().copied().filter(|r| r.status == Status::Ok && r.clock == clock).collect();
        let fronts = front::constrained(&rows, metric, clock, &constraints);
        // Two machines may have processors and adapters of one name.
        let machines: BTreeSet<_> = fronts.fronts.iter().map(|f| &f.key.machine).collect();
        for front in &fronts.fronts {
            if view.format != Format::Table {
                rank(ranked, metric, front, &rows, view.all);
            } else if !front.points.is_empty() {
                title(spec, metric, front, &rows, clock)?;
                if machines.len() > 1 {
                    put!("  machine: {}", front.key.machine)?;
                }
                shown(front, &rows, view.all).print(view.format)?;
                dominated_note(front, &rows)?;
                put!("")?;
            }
            for excluded in &front.excluded {
                note!("not ranked: {}: {}", label(rows[excluded.index]), excluded.reason);
            }
        }
    }
    print_untimed(metric, rows);
    print_missing(rows);
    Ok(())
}

fn title(spec: &Spec, metric: &str, front: &Front, rows: &[&Row], clock: &str) -> io::Result<()> {
    let key = &front.key;
    let unit = spec.metrics.iter().find(|m| m.name == metric).map_or("", |m| m.unit);
    let unit = if unit.is_empty() { String::new() } else { format!(" [{unit}]") };
    let first = rows[front.points[0].index];
    put!("{}: {}, {}, {}", spec.id, key.case, key.view, key.size)?;
    put!("  error: {metric}{unit} against {}", key.truth)?;
    let device = if key.device == "cpu" {
        first.cpu.clone()
    } else {
        format!("{} ({})", key.adapter, key.device)
    };
    let ratio = match first.baseline.as_str() {
        "" => String::new(),
        baseline => format!("; ratio to {baseline}"),
    };
    put!("  time: {} form on {device}, {clock} clock{ratio}", first.form)
}

/// A front for people: one line a setting, narrow enough for 80 columns.
fn shown(front: &Front, rows: &[&Row], all: bool) -> Table {
    let leaks = front.points.iter().any(|p| rows[p.index].errors.contains_key("leak"));
    let mut columns = vec!["", "technique", "time", "±", "ratio", "error"];
    columns.extend(leaks.then_some("leak"));
    columns.extend(["memory", "knobs"]);
    let mut table = Table::new(&columns);
    for point in front.points.iter().filter(|p| all || p.on_front) {
        let row = rows[point.index];
        let spread = 100.0 * point.mad_ns / point.time_ns;
        let mut cells = vec![
            if point.on_front { "*" } else { "" }.into(),
            format!("{}/{}", row.technique, row.variant).into(),
            duration(point.time_ns).into(),
            format!("{spread:.0}%").into(),
            row.ratio.into(),
            point.error.into(),
        ];
        cells.extend(leaks.then(|| row.errors.get("leak").copied().into()));
        cells.extend([bytes(row.memory_bytes).into(), knobs(row).into()]);
        table.row(cells);
    }
    table
}

/// Columns for programs: units in the names, nothing rounded.
const RANKED: [&str; 20] = [
    "problem",
    "case",
    "view",
    "size",
    "scene_hash",
    "technique",
    "variant",
    "form",
    "knobs",
    "machine",
    "adapter",
    "device",
    "clock",
    "time_ns",
    "mad_ns",
    "ratio",
    "metric",
    "error",
    "memory_bytes",
    "on_front",
];

fn rank(ranked: &mut Table, metric: &str, front: &Front, rows: &[&Row], all: bool) {
    for point in front.points.iter().filter(|p| all || p.on_front) {
        let row = rows[point.index];
        let words = [
            &row.problem,
            &row.case,
            &row.view,
            &row.size,
            &row.scene_hash,
            &row.technique,
            &row.variant,
            &row.form,
            &knobs(row),
            &row.machine,
            &row.adapter,
            &row.device,
            &row.clock,
        ]
        .map(|word| word.as_str().into());
        let numbers = [
            point.time_ns.into(),
            point.mad_ns.into(),
            row.ratio.into(),
            metric.into(),
            point.error.into(),
            row.memory_bytes.into(),
            point.on_front.into(),
        ];
        ranked.row([words.to_vec(), numbers.to_vec()].concat());
    }
}

/// The knobs in which settings differ from the technique's defaults; all others are defaults.
pub fn knobs(row: &Row) -> String {
    let technique = problems::find(&row.problem).and_then(|p| p.spec().technique(&row.technique));
    let default = |name: &str| {
        let knob = technique.as_ref().ok()?.knobs.iter().find(|k| k.name == name)?;
        Some(knob.default_value())
    };
    row.knobs
        .iter()
        .filter(|(name, value)| default(name).as_ref() != Some(value))
        .map(|(name, value)| match value.as_str() {
            Some(word) => format!("{name}={word}"),
            None => format!("{name}={value}"),
        })
        .collect::<Vec<_>>()
        .join(" ")
}

/// Names the techniques that are dominated at every setting, and by what.
fn dominated_note(front: &Front, rows: &[&Row]) -> io::Result<()> {
    let on_front: Vec<_> =
        front.points.iter().filter(|p| p.on_front).map(|p| &rows[p.index].technique).collect();
    let mut beaten: BTreeMap<&str, &str> = BTreeMap::new();
    for point in &front.points {
        let row = rows[point.index];
        if let Some(by) = point.dominated_by.filter(|_| !on_front.contains(&&row.technique)) {
            beaten.insert(&row.technique, &rows[front.points[by].index].technique);
        }
    }
    if !beaten.is_empty() {
        let list: Vec<_> = beaten.iter().map(|(a, b)| format!("{a} (by {b})")).collect();
        put!("dominated: {}", list.join(", "))?;
    }
    Ok(())
}

/// Reference forms are never timed: their error stands alone.
fn print_untimed(metric: &str, rows: &[&Row]) {
    for row in rows.iter().filter(|r| r.status == Status::Ok && r.clock == "none") {
        if let Some(error) = row.errors.get(metric) {
            note!("not timed: {}: {metric} {}", label(row), significant(*error));
        }
    }
}

/// What failed and what was not run, one line a reason: a case that cannot be prepared fails all
/// its settings for the same one.
fn print_missing(rows: &[&Row]) {
    let mut reasons: BTreeMap<(&str, String), Vec<&Row>> = BTreeMap::new();
    for row in rows {
        match &row.status {
            Status::Ok => {}
            Status::Failed { stage, reason } => {
                reasons.entry(("failed", format!("{stage}: {reason}"))).or_default().push(row);
            }
            Status::NotRun { reason } => {
                reasons.entry(("not run", reason.clone())).or_default().push(row);
            }
        }
    }
    for ((outcome, reason), rows) in reasons {
        let who = match rows.as_slice() {
            [row] => label(row),
            rows => format!("{} settings", rows.len()),
        };
        note!("{outcome}: {who}: {reason}");
    }
}

/// A row in a few words.
pub fn label(row: &Row) -> String {
    format!("{} {}/{} ({})", row.case, row.technique, row.variant, row.form)
}
