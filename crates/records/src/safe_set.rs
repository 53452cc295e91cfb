//! From stress points to the safe set of a technique along an axis: a union of intervals, which
//! may have holes.

use crate::stress::StressLine;

/// A part of the axis where every point probed was safe.
#[derive(Clone, Debug, PartialEq)]
pub struct Interval {
    /// Least safe value probed.
    pub from: f64,
    /// Greatest safe value probed.
    pub to: f64,
    /// Their labels.
    pub labels: [String; 2],
    /// Whether the axis was probed no further down, so that the end is the axis's, not the
    /// technique's.
    pub open_below: bool,
    /// The same upward.
    pub open_above: bool,
}

/// The safe set of points of one technique, variant, form and axis, in any order. Points that
/// were not run are passed over.
pub fn safe_set(points: &[&StressLine]) -> Vec<Interval> {
    let mut points: Vec<&&StressLine> =
        points.iter().filter(|p| p.verdict != "not-run" && !p.value.is_nan()).collect();
    points.sort_by(|a, b| a.value.total_cmp(&b.value));
    let mut set: Vec<Interval> = Vec::new();
    let mut inside = false;
    for (i, point) in points.iter().enumerate() {
        if !point.is_safe() {
            inside = false;
            continue;
        }
        match set.last_mut().filter(|_| inside) {
            Some(interval) => {
                interval.to = point.value;
                interval.labels[1].clone_from(&point.label);
            }
            None => set.push(Interval {
                from: point.value,
                to: point.value,
                labels: [point.label.clone(), point.label.clone()],
                open_below: i == 0,
                open_above: false,
            }),
        }
        inside = true;
        if i + 1 == points.len()
            && let Some(last) = set.last_mut()
        {
            last.open_above = true;
        }
    }
    set
}

/// Where the safe set ends: the points that are not safe beside those that are, ascending. Where
/// nothing is safe, the first alone.
pub fn breaks<'a>(points: &[&'a StressLine]) -> Vec<&'a StressLine> {
    let mut points: Vec<&StressLine> =
        points.iter().copied().filter(|p| p.verdict != "not-run" && !p.value.is_nan()).collect();
    points.sort_by(|a, b| a.value.total_cmp(&b.value));
    let beside = |i: usize| {
        let neighbours = [i.checked_sub(1), Some(i + 1)].into_iter().flatten();
        neighbours.filter_map(|n| points.get(n)).any(|p| p.is_safe())
    };
    let ends = (0..points.len()).filter(|i| !points[*i].is_safe() && beside(*i));
    let ends: Vec<&StressLine> = ends.map(|i| points[i]).collect();
    match points.first() {
        Some(first) if points.iter().all(|p| !p.is_safe()) => vec![first],
        _ => ends,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(values: &[(f64, &str)]) -> Vec<StressLine> {
        let point = |&(value, verdict): &(f64, &str)| StressLine {
            value,
            label: value.to_string(),
            verdict: verdict.into(),
            ..StressLine::default()
        };
        values.iter().map(point).collect()
    }

    fn ends(values: &[(f64, &str)]) -> Vec<(f64, f64, bool, bool)> {
        let points = points(values);
        let set = safe_set(&points.iter().collect::<Vec<_>>());
        set.iter().map(|i| (i.from, i.to, i.open_below, i.open_above)).collect()
    }

    #[test]
    fn holes_split_the_set_and_ends_say_whether_the_axis_ended() {
        let seen = ends(&[(3.0, "broken"), (1.0, "safe"), (2.0, "safe"), (4.0, "safe")]);
        assert_eq!(seen, [(1.0, 2.0, true, false), (4.0, 4.0, false, true)]);
        assert_eq!(ends(&[(1.0, "crashed")]), []);
        assert_eq!(ends(&[]), []);
        assert_eq!(ends(&[(1.0, "not-run"), (2.0, "safe")]), [(2.0, 2.0, true, true)]);
    }

    #[test]
    fn a_set_ends_beside_what_is_not_safe() {
        let at = |values: &[(f64, &str)]| {
            let points = points(values);
            let ends: Vec<f64> =
                breaks(&points.iter().collect::<Vec<_>>()).iter().map(|p| p.value).collect();
            ends
        };
        let hole = [(5.0, "broken"), (1.0, "broken"), (2.0, "broken"), (3.0, "safe")];
        assert_eq!(at(&hole), [2.0, 5.0]);
        assert_eq!(
            at(&[(1.0, "safe"), (2.0, "crashed"), (3.0, "broken"), (4.0, "safe")]),
            [2.0, 3.0]
        );
        assert_eq!(at(&[(2.0, "broken"), (1.0, "refused")]), [1.0]);
        assert_eq!(at(&[(1.0, "safe"), (2.0, "not-run")]), [0.0; 0]);
        assert_eq!(at(&[]), [0.0; 0]);
    }

    #[test]
    fn a_refusal_is_safe_only_where_it_is_asked_for() {
        assert_eq!(ends(&[(1.0, "refused")]), []);
        let mut asked = points(&[(1.0, "refused"), (2.0, "safe")]);
        for point in &mut asked {
            point.must_refuse = true;
        }
        let set = safe_set(&asked.iter().collect::<Vec<_>>());
        assert_eq!((set[0].from, set[0].to), (1.0, 1.0));
    }
}
