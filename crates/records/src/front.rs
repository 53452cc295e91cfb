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

/// Indices of the rows that count, in order: of those with the same identity and machine the last
/// by time (by position at equal times), whatever its status.
pub fn latest(rows: &[&Row]) -> Vec<usize> {
    let mut latest: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for (index, row) in rows.iter().enumerate() {
        let kept = latest.entry((&row.machine, &row.row)).or_insert(index);
        if rows[*kept].time <= row.time {
            *kept = index;
        }
    }
    let mut chosen: Vec<usize> = latest.into_values().collect();
    chosen.sort_unstable();
    chosen
}

/// [`constrained`] without constraints.
pub fn front(rows: &[&Row], metric: &str, clock: &str) -> Fronts {
    constrained(rows, metric, clock, &[])
}

/// Fronts of `metric` (an error, else a counter; less is better) against the median time by
/// `clock` (`gpu` or `wall`).
///
/// Only the [`latest`] rows count. Failed rows, rows that were not run, rows by another clock, rows
/// without time or with a missing or non-finite metric, and rows that break or did not measure a
/// constraint are excluded and listed. Two equal points are both on the front.
pub fn constrained(rows: &[&Row], metric: &str, clock: &str, constraints: &[Constraint]) -> Fronts {
    let chosen = latest(rows);

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

pub(crate) fn key(row: &Row) -> Key {
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

/// Sorts points of one key by time, then error, and marks those on their front.
pub fn mark(points: &mut [Point]) {
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::fixtures::{config, row};

    fn timed(n: u64, ns: u64, rmse: f64) -> Row {
        let mut row = row(n);
        row.samples_ns = vec![vec![ns]];
        row.errors.insert("rmse".into(), rmse);
        row
    }

    fn only(rows: &[Row]) -> Front {
        let mut fronts = front(&rows.iter().collect::<Vec<_>>(), "rmse", "gpu").fronts;
        assert_eq!(fronts.len(), 1);
        fronts.remove(0)
    }

    #[test]
    fn a_later_failure_takes_the_place_of_a_result_and_a_later_result_that_of_a_failure() {
        let failed = Status::Failed { stage: "check".into(), reason: "off".into() };
        let at = |id: &str, time: &str, status: &Status| Row {
            row: id.into(),
            time: time.into(),
            status: status.clone(),
            ..Row::default()
        };
        let rows = [
            at("a", "2", &failed),
            at("a", "1", &Status::Ok),
            at("b", "1", &failed),
            at("b", "2", &Status::Ok),
        ];
        let kept = latest(&rows.iter().collect::<Vec<_>>());
        assert_eq!(kept, [0, 3]);
    }

    #[test]
    fn a_front_by_hand() {
        let rows = [
            timed(0, 40, 0.05), // on
            timed(1, 10, 0.30), // on
            timed(2, 20, 0.10), // on
            timed(3, 30, 0.20), // dominated by row 2
            timed(4, 20, 0.10), // equal to row 2: on
            timed(5, 20, 0.15), // as fast as row 2, worse
            timed(6, 50, 0.05), // as good as row 0, slower
        ];
        let front = only(&rows);
        let seen: Vec<(usize, Option<usize>)> = front
            .points
            .iter()
            .map(|p| {
                assert_eq!(p.on_front, p.dominated_by.is_none());
                (p.index, p.dominated_by.map(|d| front.points[d].index))
            })
            .collect();
        let expected =
            [(1, None), (2, None), (4, None), (5, Some(2)), (3, Some(2)), (0, None), (6, Some(0))];
        assert_eq!(seen, expected);
    }

    #[test]
    fn what_failed_or_broke_a_constraint_is_listed_and_never_on_the_front() {
        let mut rows: Vec<Row> = (0..6).map(|n| timed(n, 10 - n, 0.1)).collect();
        rows[1].status = Status::Failed { stage: "port".into(), reason: "off".into() };
        rows[2].status = Status::NotRun { reason: "no adapter".into() };
        rows[3].counters.insert("false_culls".into(), 1);
        rows[4].clock = "wall".into();
        rows[5].errors.clear();
        for n in [0, 1, 2, 4, 5] {
            rows[n].counters.insert("false_culls".into(), 0);
        }
        let refs: Vec<&Row> = rows.iter().collect();
        let none = Constraint { name: "false_culls".into(), at_most: 0.0 };
        let fronts = constrained(&refs, "rmse", "gpu", std::slice::from_ref(&none)).fronts;
        let points: Vec<usize> = fronts[0].points.iter().map(|p| p.index).collect();
        assert_eq!(points, [0]);
        let reasons: Vec<&str> = fronts[0].excluded.iter().map(|e| e.reason.as_str()).collect();
        assert_eq!(
            reasons,
            [
                "failed at port: off",
                "not run: no adapter",
                "constraint false_culls is 1, above 0",
                "timed by the clock \"wall\", not \"gpu\"",
                "rmse was not measured",
            ]
        );
        // The control: without the constraint the wrong result would win.
        let free = front(&refs, "rmse", "gpu");
        assert!(free.fronts[0].points.iter().any(|p| p.index == 3 && p.on_front));
        // A constraint that was not measured, or is NaN, is not met.
        rows[0].counters.clear();
        let refs: Vec<&Row> = rows.iter().collect();
        assert!(constrained(&refs, "rmse", "gpu", &[none]).fronts[0].points.is_empty());
        rows[0].errors.insert("leak".into(), f64::NAN);
        let leak = Constraint { name: "leak".into(), at_most: 1.0 };
        let found = constrained(&[&rows[0]], "rmse", "gpu", &[leak]);
        assert_eq!(found.fronts[0].excluded[0].reason, "constraint leak is NaN, above 1");
    }

    #[test]
    fn machines_adapters_and_scenes_are_never_ranked_against_each_other() {
        let rows = [
            timed(0, 10, 0.1),
            Row { machine: "other".into(), ..timed(1, 20, 0.2) },
            Row { adapter: "other".into(), ..timed(2, 20, 0.2) },
            Row { scene_hash: "other".into(), ..timed(3, 20, 0.2) },
            Row { case: "other".into(), ..timed(4, 20, 0.2) },
            Row { truth: "other".into(), ..timed(5, 20, 0.2) },
        ];
        let fronts = front(&rows.iter().collect::<Vec<_>>(), "rmse", "gpu").fronts;
        assert_eq!(fronts.len(), rows.len());
        assert!(fronts.iter().all(|f| f.points.len() == 1 && f.points[0].on_front));
    }

    #[test]
    fn the_latest_measurement_of_a_row_counts_even_a_failure() {
        let old = Row { time: "2025".into(), ..timed(0, 10, 0.1) };
        let new = Row { time: "2026".into(), ..timed(0, 20, 0.1) };
        let failed = Row {
            time: "2027".into(),
            status: Status::NotRun { reason: "x".into() },
            ..old.clone()
        };
        let fronts = front(&[&new, &old], "rmse", "gpu");
        assert_eq!((fronts.superseded, fronts.fronts[0].points[0].time_ns), (1, 20.0));
        let fronts = front(&[&failed, &new, &old], "rmse", "gpu");
        assert_eq!(fronts.superseded, 2);
        assert!(fronts.fronts[0].points.is_empty() && fronts.fronts[0].excluded.len() == 1);
    }

    #[test]
    fn counters_serve_as_the_axis_and_no_rows_give_no_front() {
        let fronts = front(&[&row(0)], "texels", "gpu");
        assert_eq!(fronts.fronts[0].points[0].error, u64::MAX as f64);
        assert_eq!(front(&[], "rmse", "gpu"), Fronts::default());
    }

    proptest! {
        #![proptest_config(config())]

        #[test]
        fn the_front_is_what_nothing_dominates(
            values in prop::collection::vec((1..8_u64, 0..8_u8), 1..40),
        ) {
            let rows: Vec<Row> = values
                .iter()
                .enumerate()
                .map(|(n, v)| timed(n as u64, v.0, f64::from(v.1)))
                .collect();
            let front = only(&rows);
            prop_assert_eq!(front.points.len(), values.len());
            let dominates = |a: &Point, b: &Point| {
                a.time_ns <= b.time_ns
                    && a.error <= b.error
                    && (a.time_ns < b.time_ns || a.error < b.error)
            };
            for point in &front.points {
                let dominated = front.points.iter().any(|other| dominates(other, point));
                prop_assert_eq!(point.on_front, !dominated);
                if let Some(by) = point.dominated_by {
                    let by = &front.points[by];
                    prop_assert!(by.on_front && dominates(by, point));
                    let least = front.points.iter().filter(|p| p.on_front && dominates(p, point));
                    prop_assert!(least.into_iter().all(|p| p.error >= by.error));
                }
            }
        }
    }
}
