//! The screen `compare`: two runs, row by row, and what changed beyond noise.

mod detail;
#[cfg(test)]
mod tests;
mod view;

use super::World;
use crate::{
    keys::Action,
    msg::{Effect, Msg},
    widgets::Cursor,
};
use dapple_records::{
    Row,
    compare::{Comparison, Options, Pair, compare},
};
use std::collections::BTreeSet;

/// Rows of one run that are compared; whole rows are held while they are.
const MOST: usize = 4_000;

/// What is selected and shown.
#[derive(Clone, Debug, Default)]
pub struct State {
    /// Ids of the runs chosen, empty for the newest that there are.
    chosen: [String; 2],
    /// Those compared, old and new: positions of headers.
    runs: Option<[usize; 2]>,
    /// Comparing, by the number of the request for the rows.
    asked: Option<Asked>,
    outcome: Option<Result<Outcome, String>>,
    /// Position of the metric among [`Outcome::metrics`].
    metric: usize,
    all: bool,
    cursor: Cursor,
    detail: Option<Detail>,
    shown: bool,
}

/// The rows of two runs, on their way.
#[derive(Clone, Debug)]
struct Asked {
    request: u64,
    /// Positions in the index, those of the old run first.
    entries: Vec<usize>,
    /// How many are of the old run.
    old: usize,
    /// Rows beyond [`MOST`].
    left_out: usize,
}

/// What came of it; whole rows are not kept.
#[derive(Clone, Debug)]
struct Outcome {
    comparison: Comparison,
    /// For each pair: what it is, and positions in the index.
    lines: Vec<Compared>,
    metrics: Vec<String>,
    left_out: usize,
}

/// One pair.
#[derive(Clone, Debug)]
struct Compared {
    setting: String,
    form: String,
    case: String,
    /// Positions in the index, old and new.
    entries: [Option<usize>; 2],
}

/// Both rows of a pair.
#[derive(Clone, Debug)]
struct Detail {
    request: u64,
    /// Which sides were asked for.
    sides: [bool; 2],
    rows: Option<Result<Vec<Row>, String>>,
    scroll: usize,
}

impl State {
    /// A key's action. Effects of the screen's own; changes of `world` that others see.
    pub fn update(&mut self, action: Action, world: &mut World) -> Vec<Effect> {
        if let Some(detail) = &mut self.detail {
            match action {
                Action::Close | Action::Open => self.detail = None,
                Action::Up => detail.scroll = detail.scroll.saturating_sub(1),
                Action::Down => detail.scroll += 1,
                Action::PageUp => detail.scroll = detail.scroll.saturating_sub(10),
                Action::PageDown => detail.scroll += 10,
                Action::First => detail.scroll = 0,
                _ => {}
            }
            // Not beyond the last line: each key back must be seen.
            let most = self.detail_lines(world).len();
            if let Some(detail) = &mut self.detail {
                detail.scroll = detail.scroll.min(most.saturating_sub(1));
            }
            return Vec::new();
        }
        if self.cursor.act(action, self.listed().len()) {
            return Vec::new();
        }
        match action {
            Action::OldRun => self.turn(0, world),
            Action::NewRun => self.turn(1, world),
            Action::Metric => {
                let count = self.metrics().len();
                self.metric = (self.metric + 1) % count.max(1);
                Vec::new()
            }
            Action::All => {
                self.all = !self.all;
                self.cursor = Cursor::default();
                Vec::new()
            }
            Action::Open => self.open(world),
            _ => Vec::new(),
        }
    }

    /// A message that is not a key: rows asked for, a child's line, new records, a tick. Every
    /// screen hears every message, whether it is shown or not.
    pub fn hear(&mut self, msg: &Msg, world: &mut World) -> Vec<Effect> {
        match msg {
            Msg::Store(_) => {
                self.detail = None;
                self.asked = None;
                self.runs = None;
                if self.shown { self.refresh(world) } else { Vec::new() }
            }
            Msg::Rows { request, rows } => {
                if self.asked.as_ref().is_some_and(|a| a.request == *request) {
                    if let Some(asked) = self.asked.take() {
                        self.outcome = Some(rows.clone().and_then(|r| judge(&asked, &r)));
                        self.choose_metric(world);
                    }
                } else if let Some(detail) = self.detail.as_mut().filter(|d| d.request == *request)
                {
                    detail.rows = Some(rows.clone());
                }
                Vec::new()
            }
            _ => Vec::new(),
        }
    }

    /// The screen is now shown.
    pub fn enter(&mut self, world: &mut World) -> Vec<Effect> {
        self.shown = true;
        // The problem may be another.
        self.runs = None;
        self.refresh(world)
    }

    /// Another screen is now shown.
    pub fn leave(&mut self, _world: &mut World) -> Vec<Effect> {
        self.shown = false;
        self.detail = None;
        Vec::new()
    }

    /// Compares again if the runs are others.
    fn refresh(&mut self, world: &mut World) -> Vec<Effect> {
        let runs = self.pick(world);
        if runs.is_some() && runs == self.runs {
            return Vec::new();
        }
        self.runs = runs;
        self.asked = None;
        self.detail = None;
        let Some([old, new]) = runs else {
            self.outcome = None;
            return Vec::new();
        };
        let (mut entries, mut left_out) = (Vec::new(), 0);
        let mut of_old = 0;
        for (side, run) in [old, new].into_iter().enumerate() {
            let all = rows_of(world, run);
            left_out += all.len().saturating_sub(MOST);
            entries.extend(all.into_iter().take(MOST));
            if side == 0 {
                of_old = entries.len();
            }
        }
        let request = world.next_request();
        self.asked = Some(Asked { request, entries: entries.clone(), old: of_old, left_out });
        vec![Effect::ReadRows { request, entries }]
    }

    /// The two runs: those chosen while they are there, else the newest and the one before it, of
    /// the same sweep if there is one.
    fn pick(&self, world: &World) -> Option<[usize; 2]> {
        let runs = runs(world);
        let headers = &world.store.index.headers;
        let find = |id: &str| runs.iter().copied().find(|&r| headers[r].run == id);
        let new = find(&self.chosen[1]).or(runs.first().copied())?;
        let others = || runs.iter().copied().filter(|r| *r != new);
        let older = || others().filter(|&r| headers[r].time <= headers[new].time);
        let same = |r: &usize| headers[*r].sweep_hash == headers[new].sweep_hash;
        let old = find(&self.chosen[0])
            .filter(|r| *r != new)
            .or_else(|| older().find(same))
            .or_else(|| older().next())
            .or_else(|| others().next())?;
        Some([old, new])
    }

    /// The next older run on one side; never the one on the other.
    fn turn(&mut self, side: usize, world: &mut World) -> Vec<Effect> {
        let Some(now) = self.pick(world) else { return Vec::new() };
        let runs = runs(world);
        let at = runs.iter().position(|r| *r == now[side]).unwrap_or_default();
        let around = (1..runs.len()).map(|step| runs[(at + step) % runs.len()]);
        if let Some(next) = around.into_iter().find(|r| *r != now[1 - side]) {
            let id = |run: usize| world.store.index.headers[run].run.clone();
            self.chosen[side] = id(next);
            // What stands on the other side stays there.
            self.chosen[1 - side] = id(now[1 - side]);
        }
        self.cursor = Cursor::default();
        self.refresh(world)
    }

    fn open(&mut self, world: &mut World) -> Vec<Effect> {
        let Some((line, _)) = self.selected() else { return Vec::new() };
        let entries: Vec<usize> = line.entries.iter().flatten().copied().collect();
        let sides = line.entries.map(|e| e.is_some());
        let request = world.next_request();
        self.detail = Some(Detail { request, sides, rows: None, scroll: 0 });
        vec![Effect::ReadRows { request, entries }]
    }

    fn outcome(&self) -> Option<&Outcome> {
        self.outcome.as_ref()?.as_ref().ok()
    }

    fn metrics(&self) -> &[String] {
        self.outcome().map_or(&[], |o| &o.metrics)
    }

    /// The problem's axis metric first, if it was measured.
    fn choose_metric(&mut self, world: &World) {
        let axis = world.info().map(|i| i.axis.as_str());
        let at = self.metrics().iter().position(|m| Some(m.as_str()) == axis);
        self.metric = at.unwrap_or_default();
    }

    /// Positions of the pairs in the table.
    fn listed(&self) -> Vec<usize> {
        let Some(outcome) = self.outcome() else { return Vec::new() };
        let pairs = outcome.comparison.pairs.iter().enumerate();
        pairs.filter(|(_, p)| self.all || p.is_changed()).map(|(i, _)| i).collect()
    }

    fn selected(&self) -> Option<(&Compared, &Pair)> {
        let listed = self.listed();
        let at = *listed.get(self.cursor.at(listed.len())?)?;
        let outcome = self.outcome()?;
        Some((outcome.lines.get(at)?, outcome.comparison.pairs.get(at)?))
    }
}

/// Positions of the runs that have rows of the current problem, the newest first.
fn runs(world: &World) -> Vec<usize> {
    let index = &world.store.index;
    let ours: Vec<bool> = index.keys.iter().map(|k| k.problem == world.problem).collect();
    let of = |e: &&dapple_records::index::Entry| ours.get(e.key as usize) == Some(&true);
    let used: BTreeSet<u32> = index.entries.iter().filter(of).map(|e| e.run).collect();
    let mut runs: Vec<usize> =
        (0..index.headers.len()).filter(|run| used.contains(&(*run as u32))).collect();
    runs.sort_by(|a, b| index.headers[*b].time.cmp(&index.headers[*a].time).then(b.cmp(a)));
    runs
}

/// Positions of a run's rows of the current problem.
fn rows_of(world: &World, run: usize) -> Vec<usize> {
    let index = &world.store.index;
    let ours: Vec<bool> = index.keys.iter().map(|k| k.problem == world.problem).collect();
    let entries = index.entries.iter().enumerate();
    entries
        .filter(|(_, e)| e.run as usize == run && ours.get(e.key as usize) == Some(&true))
        .map(|(at, _)| at)
        .collect()
}

fn judge(asked: &Asked, rows: &[Row]) -> Result<Outcome, String> {
    if rows.len() != asked.entries.len() {
        return Err("the records changed while they were read; r reads them again".into());
    }
    let (old, new) = rows.split_at(asked.old);
    let comparison = compare(old, new, &Options::default());
    let line = |pair: &Pair| {
        let row = pair.new.map(|i| &new[i]).or(pair.old.map(|i| &old[i]));
        let row = row.cloned().unwrap_or_default();
        let setting = match row.variant.as_str() {
            "" => row.technique,
            variant => format!("{}/{variant}", row.technique),
        };
        let mut case = vec![row.case, row.view, row.size];
        case.retain(|part| !part.is_empty());
        let case = case.join(" · ");
        let entries = [
            pair.old.and_then(|i| asked.entries.get(i).copied()),
            pair.new.and_then(|i| asked.entries.get(asked.old + i).copied()),
        ];
        Compared { setting, form: row.form, case, entries }
    };
    let lines = comparison.pairs.iter().map(line).collect();
    let metrics: BTreeSet<&String> = rows.iter().flat_map(|r| r.errors.keys()).collect();
    let metrics = metrics.into_iter().cloned().collect();
    Ok(Outcome { comparison, lines, metrics, left_out: asked.left_out })
}
