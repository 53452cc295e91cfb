//! Pareto fronts of error against time.

use std::collections::BTreeMap;

use crate::row::{Row, Status};

/// What points must share to be compared. Rows of different machines, adapters, scenes, sizes or
/// truths are never ranked against each other.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    /// Problem id.
    pub problem: String,
    /// Case id.
    pub case: String,
    /// Scene hash.
    pub scene_hash: String,
    /// View or camera path.
    pub view: String,
    /// Output size.
    pub size: String,
    /// Truth parameters.
    pub truth: String,
    /// Machine.
    pub machine: String,
    /// Adapter.
    pub adapter: String,
    /// `hardware`, `software` or `cpu`.
    pub device: String,
}

/// One technique setting.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Index into the rows given to [`front()`].
    pub index: usize,
    /// Median frame time.
    pub time_ns: f64,
    /// Its spread: median absolute deviation over repeats.
    pub mad_ns: f64,
    /// The axis metric; less is better.
    pub error: f64,
    /// No other point is at least as good in both and better in one.
    pub on_front: bool,
    /// Index into the front's points: of the points on the front that dominate this one, the one
    /// with the least error.
    pub dominated_by: Option<usize>,
}

/// A row that takes no part, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Excluded {
    /// Index into the rows given to [`front()`].
    pub index: usize,
    /// Why, for people.
    pub reason: String,
}

/// The points of one key.
#[derive(Clone, Debug, PartialEq)]
pub struct Front {
    /// What the points share.
    pub key: Key,
    /// By time, then error.
    pub points: Vec<Point>,
    /// Rows of this key that take no part, in the order given.
    pub excluded: Vec<Excluded>,
}

/// All fronts, in the order of their keys.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fronts {
    /// One for each key that has a row; `points` may be empty.
    pub fronts: Vec<Front>,
    /// Rows left out because a later row measured the same.
    pub superseded: usize,
}

/// A hard constraint: the named error or counter may not exceed `at_most`.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraint {
    /// Name among the row's errors, else among its counters.
    pub name: String,
    /// Greatest value allowed.
    pub at_most: f64,
}

/// [`constrained`] without constraints.
pub fn front(rows: &[&Row], metric: &str, clock: &str) -> Fronts {
    constrained(rows, metric, clock, &[])
}

/// Fronts of `metric` (an error, else a counter; less is better) against the median time by
/// `clock` (`gpu` or `wall`).
///
/// Of rows with the same identity and machine only the last by time counts (by position at equal
/// times), whatever its status. Failed rows, rows that were not run, rows by another clock, rows
/// without time or with a missing or non-finite metric, and rows that break or did not measure a
/// constraint are excluded and listed. Two equal points are both on the front.
pub fn constrained(rows: &[&Row], metric: &str, clock: &str, constraints: &[Constraint]) -> Fronts {
    let mut latest: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for (index, row) in rows.iter().enumerate() {
        let kept = latest.entry((&row.machine, &row.row)).or_insert(index);
        if rows[*kept].time <= row.time {
            *kept = index;
        }
    }
    let mut chosen: Vec<usize> = latest.into_values().collect();
    chosen.sort_unstable();

    let mut fronts: BTreeMap<Key, Front> = BTreeMap::new();
    for &index in &chosen {
        let key = key(rows[index]);
        let front = fronts.entry(key.clone()).or_insert_with(|| Front {
            key,
            points: Vec::new(),
            excluded: Vec::new(),
        });
        match point(rows[index], index, metric, clock, constraints) {
            Ok(point) => front.points.push(point),
            Err(reason) => front.excluded.push(Excluded { index, reason }),
        }
    }
    let mut fronts: Vec<Front> = fronts.into_values().collect();
    for front in &mut fronts {
        mark(&mut front.points);
    }
    Fronts { fronts, superseded: rows.len() - chosen.len() }
}

fn key(row: &Row) -> Key {
    Key {
        problem: row.problem.clone(),
        case: row.case.clone(),
        scene_hash: row.scene_hash.clone(),
        view: row.view.clone(),
        size: row.size.clone(),
        truth: row.truth.clone(),
        machine: row.machine.clone(),
        adapter: row.adapter.clone(),
        device: row.device.clone(),
    }
}

fn point(
    row: &Row,
    index: usize,
    metric: &str,
    clock: &str,
    constraints: &[Constraint],
) -> Result<Point, String> {
    match &row.status {
        Status::Ok => {}
        Status::Failed { stage, reason } => return Err(format!("failed at {stage}: {reason}")),
        Status::NotRun { reason } => return Err(format!("not run: {reason}")),
    }
    if row.clock != clock {
        return Err(format!("timed by the clock {:?}, not {clock:?}", row.clock));
    }
    for constraint in constraints {
        let Some(value) = value(row, &constraint.name) else {
            return Err(format!("constraint {} was not measured", constraint.name));
        };
        // Written so that NaN breaks the constraint.
        if !matches!(
            value.partial_cmp(&constraint.at_most),
            Some(std::cmp::Ordering::Less | std::cmp::Ordering::Equal)
        ) {
            return Err(format!(
                "constraint {} is {value}, above {}",
                constraint.name, constraint.at_most
            ));
        }
    }
    let (Some(time_ns), Some(mad_ns)) = (row.median_ns(), row.mad_ns()) else {
        return Err("no samples".to_owned());
    };
    match value(row, metric) {
        None => Err(format!("{metric} was not measured")),
        Some(error) if !error.is_finite() => Err(format!("{metric} is {error}")),
        Some(error) => {
            Ok(Point { index, time_ns, mad_ns, error, on_front: false, dominated_by: None })
        }
    }
}

fn value(row: &Row, name: &str) -> Option<f64> {
    row.errors.get(name).copied().or_else(|| row.counters.get(name).map(|&count| count as f64))
}

fn mark(points: &mut [Point]) {
    points.sort_by(|a, b| {
        a.time_ns
            .total_cmp(&b.time_ns)
            .then(a.error.total_cmp(&b.error))
            .then(a.index.cmp(&b.index))
    });
    // The point of least error among those no slower; of equal errors the fastest.
    let mut best: Option<usize> = None;
    for i in 0..points.len() {
        let dominating = best.filter(|&b| {
            points[b].error < points[i].error
                || points[b].error == points[i].error && points[b].time_ns < points[i].time_ns
        });
        points[i].on_front = dominating.is_none();
        points[i].dominated_by = dominating;
        if best.is_none_or(|b| points[i].error < points[b].error) {
            best = Some(i);
        }
    }
}
