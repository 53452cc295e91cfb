//! From stress points to a map: techniques by axes, and what a cell says.

use super::super::World;
use dapple_records::{
    StressLine,
    safe_set::{Interval, safe_set},
};
use std::collections::BTreeSet;

/// What points must share to stand in one map.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// Machine.
    pub machine: String,
    /// Adapter; `cpu` for forms that use none.
    pub adapter: String,
    /// `hardware`, `software` or `cpu`.
    pub device: String,
    /// The case that the axes start from.
    pub case: String,
}

/// How a technique stands on an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// No point was run.
    NotRun,
    /// Safe wherever probed.
    Full,
    /// Safe in one part.
    Part,
    /// Safe in several parts, with holes between.
    Holes,
    /// Safe nowhere.
    None,
    /// A point took the process along, or bad input was taken for good.
    Crashed,
}

/// A cell of the map.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// How it stands.
    pub kind: Kind,
    /// Share of the axis that is safe, 0..=1; none if nothing was run.
    pub share: Option<f64>,
}

/// The forms there are points of, sorted.
pub fn forms(world: &World) -> Vec<String> {
    unique(of_problem(world).map(|p| p.form.clone()))
}

/// The places there are points of a form from, sorted.
pub fn places(world: &World, form: &str) -> Vec<Place> {
    unique(of_problem(world).filter(|p| p.form == form).map(place))
}

fn place(point: &StressLine) -> Place {
    let [machine, adapter, device, case] =
        [&point.machine, &point.adapter, &point.device, &point.case].map(Clone::clone);
    Place { machine, adapter, device, case }
}

fn of_problem(world: &World) -> impl Iterator<Item = &StressLine> {
    world.store.index.stress.iter().filter(|p| p.problem == world.problem)
}

fn unique<T: Ord>(items: impl Iterator<Item = T>) -> Vec<T> {
    items.collect::<BTreeSet<_>>().into_iter().collect()
}

/// The points of one map with the names of its rows and columns.
pub struct Map<'a> {
    /// Technique and variant, in the order declared.
    pub rows: Vec<(&'a str, &'a str)>,
    /// Axes, in the order declared.
    pub axes: Vec<&'a str>,
    points: Vec<&'a StressLine>,
}

impl<'a> Map<'a> {
    /// The map of a form at a place.
    pub fn of(world: &'a World, form: &str, at: &Place) -> Self {
        let points: Vec<_> =
            of_problem(world).filter(|p| p.form == form && place(p) == *at).collect();
        let info = world.info();
        let technique = |id: &str| {
            let known = info.and_then(|i| i.techniques.iter().position(|t| t.id == id));
            known.unwrap_or(usize::MAX)
        };
        let axis = |id: &str| {
            let known = info.and_then(|i| i.extremes.iter().position(|e| e.0 == id));
            known.unwrap_or(usize::MAX)
        };
        let mut rows = unique(points.iter().map(|p| (p.technique.as_str(), p.variant.as_str())));
        rows.sort_by_key(|row| technique(row.0));
        let mut axes = unique(points.iter().map(|p| p.axis.as_str()));
        axes.sort_by_key(|id| axis(id));
        Self { rows, axes, points }
    }

    /// The points of a cell, along the axis.
    pub fn cell(&self, (technique, variant): (&str, &str), axis: &str) -> Vec<&'a StressLine> {
        let mut points: Vec<_> = self
            .points
            .iter()
            .copied()
            .filter(|p| p.technique == technique && p.variant == variant && p.axis == axis)
            .collect();
        points.sort_by(|a, b| a.value.total_cmp(&b.value));
        points
    }
}

/// What a cell says.
pub fn summary(points: &[&StressLine]) -> Summary {
    let run: Vec<_> = points.iter().copied().filter(|p| p.verdict != "not-run").collect();
    if run.is_empty() {
        return Summary { kind: Kind::NotRun, share: None };
    }
    let set = safe_set(&run);
    let safe = run.iter().filter(|p| p.is_safe()).count();
    let kind = if run.iter().any(|p| is_fault(p)) {
        Kind::Crashed
    } else if safe == run.len() {
        Kind::Full
    } else if safe == 0 {
        Kind::None
    } else if set.len() > 1 {
        Kind::Holes
    } else {
        Kind::Part
    };
    let share = match Scale::of(&run) {
        _ if safe == run.len() => 1.0,
        Some(scale) => set.iter().map(|i| scale.at(i.to) - scale.at(i.from)).sum::<f64>(),
        // Words have no distance: each counts the same.
        None => safe as f64 / run.len() as f64,
    };
    Summary { kind, share: Some(share.clamp(0.0, 1.0)) }
}

/// A fault of the technique's own, not a limit: a crash, or bad input that was taken for good.
fn is_fault(point: &StressLine) -> bool {
    point.verdict == "crashed"
        || point.must_refuse && matches!(point.verdict.as_str(), "safe" | "broken")
}

/// An axis of numbers, from its least to its greatest value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    from: f64,
    to: f64,
    logarithmic: bool,
}

impl Scale {
    /// Of points along an axis; none for words and for a single value.
    pub fn of(points: &[&StressLine]) -> Option<Self> {
        if points.iter().any(|p| p.label.parse::<f64>().is_err()) {
            return None;
        }
        let values = || points.iter().map(|p| p.value).filter(|v| v.is_finite());
        let (least, most) =
            (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
        let logarithmic = least > 0.0 && points.iter().any(|p| p.logarithmic);
        let [from, to] = if logarithmic { [least.log10(), most.log10()] } else { [least, most] };
        (to > from).then_some(Self { from, to, logarithmic })
    }

    /// Where a value lies, 0 at the least and 1 at the greatest.
    pub fn at(&self, value: f64) -> f64 {
        let x = if self.logarithmic { value.log10() } else { value };
        ((x - self.from) / (self.to - self.from)).clamp(0.0, 1.0)
    }
}

/// The axis as `width` characters: full where safe, `·` where not, a mark of its own for a point
/// that is safe alone.
pub fn bar(points: &[&StressLine], width: usize) -> String {
    let run: Vec<_> = points.iter().copied().filter(|p| p.verdict != "not-run").collect();
    let Some(scale) = Scale::of(&run).filter(|_| width > 0) else { return String::new() };
    let column = |value: f64| (scale.at(value) * (width - 1) as f64).round() as usize;
    let mut bar = vec!['·'; width];
    for point in run.iter().filter(|p| !p.is_safe()) {
        bar[column(point.value)] = 'x';
    }
    for interval in safe_set(&run) {
        let (from, to) = (column(interval.from), column(interval.to));
        bar[from..=to].fill('█');
        if from == to {
            bar[from] = '▌';
        }
    }
    bar.into_iter().collect()
}

/// An interval in words: `[` where the axis ends, `]` outward where the technique broke.
pub fn interval(interval: &Interval) -> String {
    let open = if interval.open_below { '[' } else { ']' };
    let close = if interval.open_above { ']' } else { '[' };
    let [from, to] = &interval.labels;
    if from == to { format!("only {from}") } else { format!("{open}{from}, {to}{close}") }
}
