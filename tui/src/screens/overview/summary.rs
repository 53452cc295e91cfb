//! What the records say of each problem, made once when they change.

use crate::{screens::World, store::Store};
use dapple_records::{
    StressLine,
    catalogue::ProblemInfo,
    front::Key,
    index::{Ended, Entry},
    safe_set::safe_set,
    time::millis,
};
use std::collections::{BTreeMap, BTreeSet};

/// One problem's line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Problem id.
    pub id: String,
    /// Techniques declared, else found.
    pub techniques: usize,
    /// Gates of the latest machine and adapter.
    pub gates: Gates,
    /// The best at the declared levels: one for each machine and adapter, hardware first.
    pub best: Vec<Best>,
    /// Verdicts on claims.
    pub claims: Verdicts,
    /// Stress axes times techniques, and how many of these are safe on the whole axis.
    pub stable: (usize, usize),
    /// The newest record.
    pub newest_ms: Option<i64>,
    /// Its machine.
    pub machine: String,
}

/// Outcomes of gates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gates {
    /// Held, with the control caught.
    pub passed: usize,
    /// Anything that breaks a build.
    pub failed: usize,
    /// Without an adapter.
    pub not_run: usize,
    /// The latest of them.
    pub time_ms: Option<i64>,
    /// Names of those that failed.
    pub broken: Vec<String>,
}

/// Verdicts on claims.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verdicts {
    /// The figures agree.
    pub reproduced: usize,
    /// The figures contradict.
    pub refuted: usize,
    /// Not decided, or in need of hardware.
    pub open: usize,
    /// Could not be judged.
    pub errors: usize,
}

impl Verdicts {
    /// All of them.
    pub fn total(&self) -> usize {
        self.reproduced + self.refuted + self.open + self.errors
    }
}

/// The cheapest settings at each level on one machine and adapter, on the case measured last.
#[derive(Clone, Debug, PartialEq)]
pub struct Best {
    /// Case, machine, adapter.
    pub key: Key,
    /// For each level the cheapest setting that meets it, if one does.
    pub at: Vec<Option<Cheapest>>,
}

/// A setting that meets a level.
#[derive(Clone, Debug, PartialEq)]
pub struct Cheapest {
    /// Technique and variant.
    pub name: String,
    /// Median time.
    pub time_ns: f64,
    /// Its spread.
    pub mad_ns: f64,
    /// Error in the axis metric.
    pub error: f64,
}

/// One line a problem, in the order of declaration.
pub fn summaries(world: &World) -> Vec<Summary> {
    let store = &world.store;
    world
        .problems()
        .into_iter()
        .map(|id| {
            let info =
                world.catalogue.as_ref().and_then(|c| c.problems.iter().find(|p| p.id == id));
            summary(store, &id, info)
        })
        .collect()
}

fn summary(store: &Store, id: &str, info: Option<&ProblemInfo>) -> Summary {
    let index = &store.index;
    let of = |at: &&usize| index.entries.get(**at).is_some_and(|e| index.key(e).problem == id);
    let entries: Vec<&Entry> =
        store.latest.iter().filter(of).filter_map(|&at| index.entries.get(at)).collect();
    let found: BTreeSet<&str> =
        entries.iter().map(|e| index.setting(e).technique.as_str()).collect();

    // Of everything there is, what is newest and where it comes from.
    let rows = entries.iter().map(|e| (e.time_ms, index.key(e).machine.as_str()));
    let gates = index.gates.iter().filter(|g| g.problem == id);
    let claims = index.claims.iter().filter(|c| c.problem == id);
    let stress: Vec<&StressLine> = index.stress.iter().filter(|s| s.problem == id).collect();
    let when = |time: &str| millis(time).unwrap_or_default();
    let newest = rows
        .chain(gates.clone().map(|g| (when(&g.time), g.machine.as_str())))
        .chain(claims.clone().map(|c| (when(&c.time), c.machine.as_str())))
        .chain(stress.iter().map(|s| (when(&s.time), s.machine.as_str())))
        .max();

    Summary {
        id: id.into(),
        techniques: info.map_or(found.len(), |info| info.techniques.len()),
        gates: gates_of(store, id),
        best: info.map(|info| best(store, &entries, info)).unwrap_or_default(),
        claims: verdicts(store, id),
        stable: stable(&stress),
        newest_ms: newest.map(|n| n.0),
        machine: newest.map(|n| n.1.to_string()).unwrap_or_default(),
    }
}

fn gates_of(store: &Store, id: &str) -> Gates {
    let gates = || store.index.gates.iter().filter(|g| g.problem == id);
    // One machine's and adapter's: those of the gate that ran last.
    let Some(last) = gates().max_by(|a, b| a.time.cmp(&b.time)) else { return Gates::default() };
    let mut of = Gates { time_ms: millis(&last.time), ..Gates::default() };
    for gate in gates().filter(|g| g.machine == last.machine && g.adapter == last.adapter) {
        match gate.outcome.as_str() {
            "passed" => of.passed += 1,
            "not-run" => of.not_run += 1,
            _ => {
                of.failed += 1;
                of.broken.push(format!("{} {} ({})", gate.technique, gate.gate, gate.outcome));
            }
        }
    }
    of
}

fn verdicts(store: &Store, id: &str) -> Verdicts {
    // One verdict a claim: the latest, of whatever machine.
    let mut latest: BTreeMap<&str, (&str, &str)> = BTreeMap::new();
    for claim in store.index.claims.iter().filter(|c| c.problem == id) {
        let now = (claim.time.as_str(), claim.verdict.as_str());
        let kept = latest.entry(&claim.id).or_insert(now);
        *kept = now.max(*kept);
    }
    let mut of = Verdicts::default();
    for (_, verdict) in latest.into_values() {
        match verdict {
            "reproduced" => of.reproduced += 1,
            "refuted" => of.refuted += 1,
            "open" | "needs-hardware" => of.open += 1,
            _ => of.errors += 1,
        }
    }
    of
}

/// Of all pairs of a technique (variant, form, adapter) and an axis that were pushed: how many are
/// safe on the whole axis.
fn stable(stress: &[&StressLine]) -> (usize, usize) {
    let mut pairs: BTreeMap<[&str; 7], Vec<&StressLine>> = BTreeMap::new();
    for &s in stress.iter().filter(|s| s.verdict != "not-run") {
        let key = [&s.machine, &s.adapter, &s.case, &s.technique, &s.variant, &s.form, &s.axis];
        pairs.entry(key.map(String::as_str)).or_default().push(s);
    }
    let spans = |points: &Vec<&StressLine>| matches!(safe_set(points).as_slice(), [all] if all.open_below && all.open_above);
    (pairs.values().filter(|points| spans(points)).count(), pairs.len())
}

fn best(store: &Store, entries: &[&Entry], info: &ProblemInfo) -> Vec<Best> {
    let index = &store.index;
    // Machine and adapter, and of these the case that was measured last.
    let mut newest: BTreeMap<(u8, &str, &str), (i64, u32)> = BTreeMap::new();
    for entry in entries {
        let key = index.key(entry);
        let of = (rank(&key.device), key.machine.as_str(), key.adapter.as_str());
        let now = (entry.time_ms, entry.key);
        let kept = newest.entry(of).or_insert(now);
        *kept = now.max(*kept);
    }
    newest
        .into_values()
        .filter_map(|(_, key)| {
            let rivals: Vec<&Entry> = entries.iter().filter(|e| e.key == key).copied().collect();
            let first = rivals.first()?;
            let at = info.levels.iter().map(|level| cheapest(store, &rivals, info, *level));
            Some(Best { key: index.key(first).clone(), at: at.collect() })
        })
        .collect()
}

/// Hardware says most about use, imitated hardware least.
fn rank(device: &str) -> u8 {
    match device {
        "hardware" => 0,
        "cpu" => 1,
        "software" => 2,
        _ => 3,
    }
}

fn cheapest(store: &Store, rivals: &[&Entry], info: &ProblemInfo, level: f64) -> Option<Cheapest> {
    let index = &store.index;
    // Times of one clock only: the adapter's where there is one.
    let timed = |e: &&&Entry| e.ended == Ended::Ok && e.median_ns.is_finite();
    let gpu = rivals.iter().filter(timed).any(|e| e.gpu_clock);
    let meets = |e: &&&Entry| {
        info.constraints
            .iter()
            .all(|(metric, most)| index.value(e, metric).is_some_and(|value| value <= *most))
    };
    rivals
        .iter()
        .filter(timed)
        .filter(|e| e.gpu_clock == gpu)
        .filter(meets)
        .filter_map(|e| Some((e, index.value(e, &info.axis).filter(|error| *error <= level)?)))
        .min_by(|a, b| a.0.median_ns.total_cmp(&b.0.median_ns).then(a.1.total_cmp(&b.1)))
        .map(|(e, error)| {
            let setting = index.setting(e);
            let plain = setting.variant.is_empty() || setting.variant == "plain";
            let name = match plain {
                true => setting.technique.clone(),
                false => format!("{}/{}", setting.technique, setting.variant),
            };
            Cheapest { name, time_ns: e.median_ns, mad_ns: e.mad_ns, error }
        })
}
