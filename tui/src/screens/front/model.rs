//! What one plot shows: the rows of one problem, case, machine and adapter by one metric and clock.

use crate::screens::World;
use dapple_records::{
    front::{Key, Point, mark},
    index::{Ended, Entry, SettingName},
};
use std::collections::{BTreeMap, BTreeSet};

/// What is measured. Points of two cases are never in one plot.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Case {
    /// Case id.
    pub case: String,
    /// View or path.
    pub view: String,
    /// Output size.
    pub size: String,
    /// Truth and its parameters.
    pub truth: String,
    scene_hash: String,
}

/// Where it was measured. Points of two places are never in one plot.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// Machine.
    pub machine: String,
    /// `hardware`, `software` or `cpu`.
    pub device: String,
    /// Adapter's name.
    pub adapter: String,
}

/// What the user chose; what is no longer there is passed over, not forgotten.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Choice {
    /// The case.
    pub case: Option<Case>,
    /// The place.
    pub place: Option<Place>,
    /// The metric.
    pub metric: Option<String>,
    /// Whether the clock is the adapter's.
    pub gpu_clock: Option<bool>,
}

/// The plot.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// Cases there are.
    pub cases: Vec<Case>,
    /// Position of the one shown.
    pub case: usize,
    /// Places that the case was measured at.
    pub places: Vec<Place>,
    /// Position of the one shown.
    pub place: usize,
    /// Metrics that any of the rows has.
    pub metrics: Vec<String>,
    /// The one shown.
    pub metric: String,
    /// Clocks that any of the rows has: whether it is the adapter's.
    pub clocks: Vec<bool>,
    /// The one shown.
    pub gpu_clock: bool,
    /// By time, then error; their index is a position in the record index.
    pub points: Vec<Point>,
    /// How many rows take no part, by reason.
    pub left_out: BTreeMap<String, usize>,
    /// Technique and variant of each letter.
    pub series: Vec<(String, String)>,
}

impl Case {
    /// From a key.
    pub fn of(key: &Key) -> Self {
        Self {
            case: key.case.clone(),
            view: key.view.clone(),
            size: key.size.clone(),
            truth: key.truth.clone(),
            scene_hash: key.scene_hash.clone(),
        }
    }

    /// Without the truth.
    pub fn label(&self) -> String {
        let parts = [&self.case, &self.view, &self.size];
        let told: Vec<&str> = parts.iter().map(|p| p.as_str()).filter(|p| !p.is_empty()).collect();
        told.join(" · ")
    }
}

impl Place {
    /// From a key.
    pub fn of(key: &Key) -> Self {
        Self {
            machine: key.machine.clone(),
            device: key.device.clone(),
            adapter: key.adapter.clone(),
        }
    }

    /// For people; software adapters are marked, and machines other than this one named.
    pub fn label(&self, world: &World) -> String {
        let here = world.catalogue.as_ref().is_some_and(|c| c.machine == self.machine);
        let machine =
            if here { "this machine".into() } else { format!("machine {}", self.machine) };
        match self.device.as_str() {
            "cpu" => format!("cpu, {machine}"),
            "software" => format!("{} (SOFTWARE), {machine}", self.adapter),
            _ => format!("{}, {machine}", self.adapter),
        }
    }

    /// This machine first, hardware before the processor before software.
    fn rank(&self, world: &World) -> (bool, u8) {
        let here = world.catalogue.as_ref().is_some_and(|c| c.machine == self.machine);
        let device = match self.device.as_str() {
            "hardware" => 0,
            "cpu" => 1,
            _ => 2,
        };
        (!here, device)
    }
}

impl Model {
    /// From the records of the current problem.
    pub fn of(world: &World, choice: &Choice) -> Self {
        let index = &world.store.index;
        let of_problem: Vec<bool> = index.keys.iter().map(|k| k.problem == world.problem).collect();
        let ours = |e: &&Entry| of_problem.get(e.key as usize).copied().unwrap_or(false);
        let entries = || {
            let latest = world.store.latest.iter();
            latest.filter_map(|&at| Some((at, index.entries.get(at)?))).filter(|(_, e)| ours(e))
        };
        // Rows that died before their case was known have a key of their own without a truth.
        let used: BTreeSet<u32> =
            entries().filter(|(_, e)| e.ended == Ended::Ok).map(|(_, e)| e.key).collect();
        let keys = || used.iter().filter_map(|&key| index.keys.get(key as usize));

        let mut model = Self::default();
        model.cases = keys().map(Case::of).collect::<BTreeSet<_>>().into_iter().collect();
        model.case = position(&model.cases, choice.case.as_ref());
        let Some(case) = model.cases.get(model.case).cloned() else { return model };
        let places: BTreeSet<Place> =
            keys().filter(|k| Case::of(k) == case).map(Place::of).collect();
        model.places = places.into_iter().collect();
        model.places.sort_by_key(|place| place.rank(world));
        model.place = position(&model.places, choice.place.as_ref());
        let Some(place) = model.places.get(model.place).cloned() else { return model };

        let here: Vec<bool> = index
            .keys
            .iter()
            .enumerate()
            .map(|(i, k)| of_problem[i] && Case::of(k) == case && Place::of(k) == place)
            .collect();
        let rows: Vec<(usize, &Entry)> =
            entries().filter(|(_, e)| here.get(e.key as usize) == Some(&true)).collect();
        model.choose_metric(world, choice, &rows);
        model.choose_clock(choice, &rows);
        model.place_points(world, &rows);
        model
    }

    fn choose_metric(&mut self, world: &World, choice: &Choice, rows: &[(usize, &Entry)]) {
        let index = &world.store.index;
        let mut there: BTreeSet<&str> = BTreeSet::new();
        for (_, entry) in rows {
            there.extend(index.metrics(entry).iter().map(String::as_str));
        }
        let info = world.info();
        let declared = info.map_or(&[][..], |i| &i.metrics);
        self.metrics = declared
            .iter()
            .map(|(name, ..)| name.as_str())
            .filter(|name| there.contains(name))
            .map(str::to_string)
            .collect();
        let declared = self.metrics.clone();
        let others = there.iter().filter(|n| !declared.iter().any(|d| d == *n));
        self.metrics.extend(others.map(|n| n.to_string()));
        let wanted = choice.metric.as_ref().filter(|m| self.metrics.contains(m));
        let axis = info.map(|i| &i.axis).filter(|a| self.metrics.contains(a));
        self.metric = wanted.or(axis).or(self.metrics.first()).cloned().unwrap_or_default();
    }

    fn choose_clock(&mut self, choice: &Choice, rows: &[(usize, &Entry)]) {
        let timed = |gpu: bool| {
            rows.iter()
                .any(|(_, e)| e.gpu_clock == gpu && e.ended == Ended::Ok && e.median_ns > 0.0)
        };
        self.clocks = [true, false].into_iter().filter(|gpu| timed(*gpu)).collect();
        let wanted = choice.gpu_clock.filter(|c| self.clocks.contains(c));
        self.gpu_clock = wanted.or(self.clocks.first().copied()).unwrap_or_default();
    }

    fn place_points(&mut self, world: &World, rows: &[(usize, &Entry)]) {
        let index = &world.store.index;
        let constraints = world.info().map_or(&[][..], |i| &i.constraints);
        for &(at, entry) in rows {
            match point(world, at, entry, &self.metric, self.gpu_clock, constraints) {
                Ok(point) => self.points.push(point),
                Err(reason) => *self.left_out.entry(reason).or_default() += 1,
            }
        }
        mark(&mut self.points);
        let shown: BTreeSet<(&str, &str)> = self
            .points
            .iter()
            .map(|p| index.setting(&index.entries[p.index]))
            .map(|s| (s.technique.as_str(), s.variant.as_str()))
            .collect();
        self.series = shown.into_iter().map(|(t, v)| (t.to_string(), v.to_string())).collect();
        let declared = world.info().map_or(&[][..], |i| &i.techniques);
        self.series.sort_by_key(|(technique, variant)| {
            let at = declared.iter().position(|t| t.id == *technique);
            let of = |v: &(String, String)| v.0 == *variant;
            let variant = at.and_then(|at| declared[at].variants.iter().position(of));
            (at.unwrap_or(usize::MAX), variant.unwrap_or(usize::MAX))
        });
    }

    /// Number of a setting's series.
    pub fn series_of(&self, setting: &SettingName) -> usize {
        let same = |s: &(String, String)| s.0 == setting.technique && s.1 == setting.variant;
        self.series.iter().position(same).unwrap_or_default()
    }
}

/// The letter of the nth series: A to Z, a to z, 0 to 9, and again.
pub fn letter(n: usize) -> char {
    const LETTERS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789";
    char::from(LETTERS[n % LETTERS.len()])
}

fn position<T: PartialEq>(list: &[T], wanted: Option<&T>) -> usize {
    wanted.and_then(|w| list.iter().position(|item| item == w)).unwrap_or_default()
}

/// As [`dapple_records::front::constrained`] decides it for whole rows.
fn point(
    world: &World,
    at: usize,
    entry: &Entry,
    metric: &str,
    gpu_clock: bool,
    constraints: &[(String, f64)],
) -> Result<Point, String> {
    let index = &world.store.index;
    match entry.ended {
        Ended::Ok => {}
        Ended::Failed => return Err("failed".into()),
        Ended::NotRun => return Err("not run".into()),
    }
    // NaN is not above 0 either.
    if !entry.median_ns.is_finite() || !entry.mad_ns.is_finite() {
        return Err("not timed".into());
    }
    if entry.gpu_clock != gpu_clock {
        return Err("by the other clock".into());
    }
    for (name, most) in constraints {
        let kept = index.value(entry, name).is_some_and(|value| value <= *most);
        if !kept {
            return Err(format!("{name} above {most} or not measured"));
        }
    }
    match index.error(entry, metric) {
        Some(error) if error.is_finite() => Ok(Point {
            index: at,
            time_ns: entry.median_ns,
            mad_ns: entry.mad_ns,
            error,
            on_front: false,
            dominated_by: None,
        }),
        _ => Err(format!("no {metric}")),
    }
}
