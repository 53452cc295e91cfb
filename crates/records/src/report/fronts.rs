//! Fronts of one problem: plot, table and pictures, one machine, adapter, case and clock each.

use super::{Input, Triplet, nothing, plot};
use crate::catalogue::ProblemInfo;
use crate::front::{self, Front, Key, Point};
use crate::row::{Row, Status};
use crate::text::{bytes, duration, significant};
use base64::Engine as _;
use maud::{Markup, html};
use std::collections::BTreeMap;

/// Fronts shown at most.
const MOST_FRONTS: usize = 100;
/// Settings in a table and a plot at most: those on the front first, then the fastest.
const MOST_POINTS: usize = 300;

/// The fronts of `rows`, all of `problem`.
pub fn fronts(input: &Input<'_>, problem: &ProblemInfo, rows: &[&Row]) -> Markup {
    let latest: Vec<&Row> = front::latest(rows).into_iter().map(|i| rows[i]).collect();
    let constraints = problem.front_constraints();
    let mut drawn = Vec::new();
    for clock in ["gpu", "wall"] {
        let timed: Vec<&Row> =
            latest.iter().copied().filter(|r| r.status == Status::Ok && r.clock == clock).collect();
        let fronts = front::constrained(&timed, &problem.axis, clock, &constraints).fronts;
        for front in fronts.into_iter().filter(|f| !f.points.is_empty()) {
            drawn.push(one(input, problem, &front, &timed, clock));
        }
    }
    let (total, untimed) =
        (drawn.len(), latest.iter().filter(|r| r.status == Status::Ok && r.clock == "none"));
    let untimed = untimed.count();
    html! {
        h3 { "Fronts" }
        @if total == 0 {
            (nothing("timed rows", &format!("dapple measure {}", problem.id)))
        }
        @for front in drawn.into_iter().take(MOST_FRONTS) { (front) }
        @if total > MOST_FRONTS { p.dim { (total - MOST_FRONTS) " more fronts are left out." } }
        @if untimed > 0 {
            p.dim { (untimed) " rows of reference forms carry errors and no time, and are not shown." }
        }
    }
}

fn one(
    input: &Input<'_>,
    problem: &ProblemInfo,
    front: &Front,
    rows: &[&Row],
    clock: &str,
) -> Markup {
    let key = &front.key;
    let first = rows[front.points[0].index];
    let device = match key.device.as_str() {
        "cpu" => format!("{}, {} threads", first.cpu, first.threads),
        _ => format!("{}, {}", key.adapter, first.driver),
    };
    let metric = metric(problem);
    let mut shown: Vec<&Point> = front.points.iter().filter(|p| p.on_front).collect();
    shown.extend(front.points.iter().filter(|p| !p.on_front));
    shown.truncate(MOST_POINTS);
    shown.sort_by(|a, b| a.time_ns.total_cmp(&b.time_ns));
    let series = series(problem, &shown, rows);
    let dots: Vec<_> = shown.iter().map(|p| dot(problem, p, rows[p.index], &series)).collect();
    let title = format!("{}, {}, {}", key.case, key.view, key.size);
    let best = front.points.iter().filter(|p| p.on_front).map(|p| label(rows[p.index]));
    let description = format!(
        "{} settings; on the front, fastest first: {}",
        front.points.len(),
        best.collect::<Vec<_>>().join(", ")
    );
    html! {
        h4 { (title) }
        p {
            "On " (device) " "
            @match key.device.as_str() {
                "software" => span.badge { "software adapter: times are not hardware's" },
                "cpu" => span.badge { "processor" },
                word => span.badge { (word) },
            }
            ", " (clock) " clock, machine " (key.machine) ". Error: " (metric) " against " (key.truth) "."
        }
        figure {
            (plot::scatter(&title, &description, &metric, &dots))
            figcaption {
                ul.legend { @for (technique, n) in &series { li { (plot::sign(*n)) " " (technique) } } }
            }
        }
        (table(problem, front, &shown, rows))
        @if front.points.len() > shown.len() {
            p.dim { (front.points.len() - shown.len()) " slower dominated settings are left out." }
        }
        @if !front.excluded.is_empty() {
            details {
                summary { (front.excluded.len()) " settings are not ranked" }
                ul { @for e in front.excluded.iter().take(50) {
                    li { (label(rows[e.index])) ": " (e.reason) }
                } }
            }
        }
        @for triplet in input.triplets.iter().filter(|t| same(&t.key, key)) { (pictures(triplet)) }
    }
}

/// Pictures do not depend on the machine that a front was measured on.
fn same(a: &Key, b: &Key) -> bool {
    let of = |k: &Key| {
        [&k.problem, &k.case, &k.scene_hash, &k.view, &k.size, &k.truth].map(String::clone)
    };
    of(a) == of(b) && a.device == b.device
}

/// A number for each technique, in the declared order, so that a sign means one technique in all
/// plots of the problem.
fn series<'a>(
    problem: &ProblemInfo,
    shown: &[&Point],
    rows: &[&'a Row],
) -> BTreeMap<&'a str, usize> {
    let declared = |id: &str| problem.techniques.iter().position(|t| t.id == id);
    let ids = shown.iter().map(|p| rows[p.index].technique.as_str());
    ids.map(|id| (id, declared(id).unwrap_or(problem.techniques.len()))).collect()
}

fn dot(
    problem: &ProblemInfo,
    point: &Point,
    row: &Row,
    series: &BTreeMap<&str, usize>,
) -> plot::Dot {
    plot::Dot {
        time_ns: point.time_ns,
        error: point.error,
        series: series.get(row.technique.as_str()).copied().unwrap_or_default(),
        on_front: point.on_front,
        label: format!(
            "{}: {}, error {}; {}",
            label(row),
            duration(point.time_ns),
            significant(point.error),
            knobs(problem, row)
        ),
    }
}

fn table(problem: &ProblemInfo, front: &Front, shown: &[&Point], rows: &[&Row]) -> Markup {
    html! {
        div.scroll tabindex="0" { table {
            thead { tr {
                th scope="col" { "technique" } th.n scope="col" { "time" } th.n scope="col" { "±" }
                th.n scope="col" { "p99" } th.n scope="col" { (metric(problem)) } th.n scope="col" { "memory" }
                th scope="col" { "standing" } th scope="col" { "knobs not at their default" }
            } }
            tbody { @for point in shown {
                @let row = rows[point.index];
                tr.off[!point.on_front] {
                    th.w scope="row" { (label(row)) }
                    td.n { (duration(point.time_ns)) }
                    td.n { (format!("{:.1} %", 100.0 * point.mad_ns / point.time_ns)) }
                    td.n { (row.p99_ns().map(duration).unwrap_or_default()) }
                    td.n { (significant(point.error)) }
                    td.n { (bytes(row.memory_bytes)) }
                    td.w { @match point.dominated_by {
                        None => span.good { "on the front" },
                        Some(by) => { "beaten by " (label(rows[front.points[by].index])) },
                    } }
                    td { (knobs(problem, row)) }
                }
            } }
        } }
    }
}

fn pictures(triplet: &Triplet) -> Markup {
    let [width, height] = triplet.size;
    let names = ["truth", "result", "error: orange too light, blue too dark"];
    html! {
        figure {
            div.triplet { @for (name, png) in names.iter().zip(&triplet.png) { figure {
                img width=(width) height=(height) alt={(triplet.setting) ": " (name)}
                    src={"data:image/png;base64," (base64::engine::general_purpose::STANDARD.encode(png))};
                figcaption { (name) }
            } } }
            figcaption { (triplet.setting) ": " (triplet.figures) }
        }
    }
}

fn metric(problem: &ProblemInfo) -> String {
    let unit = problem.metrics.iter().find(|m| m.0 == problem.axis).map_or("", |m| &m.1);
    if unit.is_empty() { problem.axis.clone() } else { format!("{} [{unit}]", problem.axis) }
}

fn label(row: &Row) -> String {
    format!("{}/{} ({})", row.technique, row.variant, row.form)
}

/// The knobs that are not at the technique's defaults.
fn knobs(problem: &ProblemInfo, row: &Row) -> String {
    let declared = problem.techniques.iter().find(|t| t.id == row.technique);
    let default = |name: &str| Some(&declared?.knobs.iter().find(|k| k.name == name)?.default);
    let word = |(name, value): (&String, &crate::Value)| match value.as_str() {
        Some(word) => format!("{name}={word}"),
        None => format!("{name}={value}"),
    };
    let turned = row.knobs.iter().filter(|(name, value)| default(name) != Some(value));
    turned.map(word).collect::<Vec<_>>().join(" ")
}
