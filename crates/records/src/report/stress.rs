//! Where techniques break: a table of safe sets, technique by axis.

use super::{latest, nothing};
use crate::catalogue::ProblemInfo;
use crate::safe_set::{Interval, safe_set};
use crate::stress::StressLine;
use maud::{Markup, html};
use std::collections::BTreeMap;

/// The map of one problem: a table for each machine, adapter, form and case.
pub fn map(problem: &ProblemInfo, points: &[&StressLine]) -> Markup {
    let mut tables: BTreeMap<[&str; 4], Vec<&StressLine>> = BTreeMap::new();
    for point in points {
        let key = [&*point.machine, &point.adapter, &point.form, &point.case];
        tables.entry(key).or_default().push(point);
    }
    html! {
        h3 { "Where they break" }
        @if tables.is_empty() {
            (nothing("stress points", &format!("dapple stress {}", problem.id)))
        }
        @for (key, points) in &tables { (table(problem, key, points)) }
    }
}

fn table<'a>(problem: &ProblemInfo, key: &[&str; 4], points: &[&'a StressLine]) -> Markup {
    let [machine, adapter, form, case] = key;
    let mut cells: BTreeMap<(String, &str), Vec<&StressLine>> = BTreeMap::new();
    let of = |p: &'a StressLine| ([&*p.technique, &p.variant, &p.axis], p.value.to_bits());
    for point in latest(points, of, |p| &p.time).into_values() {
        let who = format!("{}/{}", point.technique, point.variant);
        cells.entry((who, &point.axis)).or_default().push(point);
    }
    let mut techniques: Vec<&String> = cells.keys().map(|k| &k.0).collect();
    techniques.dedup();
    let declared = problem.extremes.iter().map(|e| e.0.as_str());
    let axes: Vec<&str> =
        declared.filter(|axis| cells.keys().any(|(_, seen)| seen == axis)).collect();
    html! {
        div.scroll tabindex="0" { table {
            caption {
                "Safe sets from the case " (case) ", form " (form) ", adapter " (adapter) ", machine " (machine)
                ". An end in brackets is the axis's own; an open one is where the technique broke."
            }
            thead { tr {
                th scope="col" { "technique" }
                @for axis in &axes { th scope="col" { (axis) } }
            } }
            tbody { @for technique in techniques { tr {
                th.w scope="row" { (technique) }
                @for axis in &axes { td { @match cells.get(&(technique.clone(), *axis)) {
                    Some(points) => (cell(points)),
                    None => span.dim { "does not apply" },
                } } }
            } } }
        } }
    }
}

fn cell(points: &[&StressLine]) -> Markup {
    let set = safe_set(points);
    let broken: Vec<_> = points.iter().filter(|p| !p.is_safe() && p.verdict != "not-run").collect();
    let run = points.iter().any(|p| p.verdict != "not-run");
    html! {
        @if !run { span.dim { "not run" } }
        @else if broken.is_empty() { span.good { "everywhere probed" } }
        @else if set.is_empty() { span.bad { "nowhere" } }
        @else { span.bad { "safe in " } (safe(points, &set)) }
        @if !broken.is_empty() {
            details {
                summary { (broken.len()) " of " (points.len()) " points broke" }
                ul { @for point in broken.iter().take(6) {
                    li { (point.label) ": " (point.verdict) ": " (point.reason) br; code { (point.command) } }
                } }
            }
        }
    }
}

/// Intervals of numbers; words have no order, and are listed.
fn safe(points: &[&StressLine], set: &[Interval]) -> String {
    if points.iter().any(|p| p.label.parse::<f64>().is_err()) {
        let safe = points.iter().filter(|p| p.is_safe());
        return safe.map(|p| p.label.as_str()).collect::<Vec<_>>().join(", ");
    }
    set.iter().map(interval).collect::<Vec<_>>().join(", ")
}

fn interval(interval: &Interval) -> String {
    let (open, close) =
        (if interval.open_below { '[' } else { ']' }, if interval.open_above { ']' } else { '[' });
    let [from, to] = &interval.labels;
    if from == to { from.clone() } else { format!("{open}{from}, {to}{close}") }
}
