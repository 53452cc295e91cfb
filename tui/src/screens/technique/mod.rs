//! The screen `technique`: one technique's pictures, knobs with their curves, documentation.

mod curves;
mod pictures;
#[cfg(test)]
mod tests;
mod view;

use super::{Focus, World};
use crate::{
    keys::Action,
    msg::{Effect, Msg},
    screens::front::{Case, Place},
};
use dapple_records::{
    Row, Value,
    catalogue::{KnobInfo, TechniqueInfo},
    index::Ended,
};
use pictures::Pictures;
use std::collections::BTreeMap;

/// Whole rows that are read for the curves.
const MOST: usize = 400;

/// What is selected and shown.
#[derive(Clone, Debug, Default)]
pub struct State {
    /// Case and place chosen here, if any.
    chosen: Option<(Case, Place)>,
    /// Those that the technique was measured in.
    keys: Vec<(Case, Place)>,
    key: usize,
    /// Positions in the index of the settings recorded there, by variant, form, then time.
    settings: Vec<usize>,
    setting: usize,
    /// The whole rows of the selected setting's variant and form.
    rows: BTreeMap<usize, Row>,
    trouble: Option<String>,
    asked: Option<(u64, Vec<usize>)>,
    /// Rows there are beyond [`MOST`].
    left_out: usize,
    metric: usize,
    knob: usize,
    docs: bool,
    pictures: Pictures,
    shown: bool,
}

impl State {
    /// A key's action. Effects of the screen's own; changes of `world` that others see.
    pub fn update(&mut self, action: Action, world: &mut World) -> Vec<Effect> {
        match action {
            Action::Technique => {
                let ids = techniques(world);
                let at = ids.iter().position(|t| *t == world.technique).map_or(0, |i| i + 1);
                world.technique = ids.get(at % ids.len().max(1)).cloned().unwrap_or_default();
                (self.setting, self.knob) = (0, 0);
                world.focus = None;
                self.refresh(world)
            }
            Action::Scene => {
                let at = (self.key + 1) % self.keys.len().max(1);
                self.chosen = self.keys.get(at).cloned();
                world.focus = None;
                self.refresh(world)
            }
            Action::Left | Action::Right => {
                let count = self.settings.len().max(1);
                let step = if action == Action::Right { 1 } else { count - 1 };
                self.setting = (self.setting + step) % count;
                self.select(world)
            }
            Action::Up | Action::Down => {
                let count = self.knobs(world).len().max(1);
                let step = if action == Action::Down { 1 } else { count - 1 };
                self.knob = (self.knob.min(count - 1) + step) % count;
                Vec::new()
            }
            Action::Metric => {
                self.metric = (self.metric + 1) % self.metrics(world).len().max(1);
                Vec::new()
            }
            Action::Flip => {
                self.pictures.flip();
                Vec::new()
            }
            Action::PageDown | Action::PageUp => {
                self.docs = !self.docs;
                Vec::new()
            }
            _ => Vec::new(),
        }
    }

    /// A message that is not a key: rows asked for, a child's line, new records, a tick. Every
    /// screen hears every message, whether it is shown or not.
    pub fn hear(&mut self, msg: &Msg, world: &mut World) -> Vec<Effect> {
        match msg {
            Msg::Store(_) => {
                self.asked = None;
                self.rows.clear();
                if self.shown { self.refresh(world) } else { Vec::new() }
            }
            Msg::Rows { request, rows } => self.take_rows(*request, rows, world),
            Msg::Heard { .. } | Msg::Grumbled { .. } | Msg::Ended { .. } => {
                self.pictures.hear(msg, world)
            }
            _ => Vec::new(),
        }
    }

    /// The screen is now shown.
    pub fn enter(&mut self, world: &mut World) -> Vec<Effect> {
        self.shown = true;
        self.refresh(world)
    }

    /// Another screen is now shown.
    pub fn leave(&mut self, _world: &mut World) -> Vec<Effect> {
        self.shown = false;
        self.pictures.stop()
    }

    /// Finds what was recorded of the technique; the setting in focus is selected if it is there.
    fn refresh(&mut self, world: &mut World) -> Vec<Effect> {
        let ids = techniques(world);
        if !ids.contains(&world.technique) {
            world.technique = ids.first().cloned().unwrap_or_default();
        }
        let focus = world
            .focus
            .clone()
            .filter(|f| f.key.problem == world.problem && f.setting.technique == world.technique);
        let index = &world.store.index;
        let mut found: BTreeMap<(Case, Place), Vec<usize>> = BTreeMap::new();
        for &at in &world.store.latest {
            let Some(entry) = index.entries.get(at).filter(|e| e.ended == Ended::Ok) else {
                continue;
            };
            let (key, setting) = (index.key(entry), index.setting(entry));
            if key.problem == world.problem && setting.technique == world.technique {
                found.entry((Case::of(key), Place::of(key))).or_default().push(at);
            }
        }
        let focused = focus.as_ref().map(|f| (Case::of(&f.key), Place::of(&f.key)));
        self.keys = found.keys().cloned().collect();
        let wanted = focused.or(self.chosen.clone());
        let at = self.keys.iter().position(|k| Some(k) == wanted.as_ref());
        self.key = at.unwrap_or_default();
        self.settings = self.keys.get(self.key).and_then(|k| found.remove(k)).unwrap_or_default();
        self.settings.sort_by(|a, b| {
            let (a, b) = (&index.entries[*a], &index.entries[*b]);
            let names = index.setting(a).cmp(index.setting(b));
            names.then(a.median_ns.total_cmp(&b.median_ns)).then(a.identity.cmp(&b.identity))
        });
        let same = |at: &usize| {
            let entry = &index.entries[*at];
            focus
                .as_ref()
                .is_some_and(|f| f.identity == entry.identity && f.setting == *index.setting(entry))
        };
        let last = self.settings.len().saturating_sub(1);
        self.setting = self.settings.iter().position(same).unwrap_or(self.setting.min(last));
        self.select(world)
    }

    /// Reads the rows of the selected setting and those it is compared with, then its pictures.
    fn select(&mut self, world: &mut World) -> Vec<Effect> {
        self.trouble = None;
        let Some(at) = self.selected() else {
            self.asked = None;
            self.rows.clear();
            return self.show(world);
        };
        world.focus = Focus::of(&world.store.index, at);
        if self.rows.contains_key(&at) {
            return self.show(world);
        }
        let index = &world.store.index;
        let name = index.setting(&index.entries[at]);
        let siblings = || {
            let of = |other: &&usize| index.setting(&index.entries[**other]) == name;
            self.settings.iter().filter(of).copied()
        };
        // The selected one comes first: it is read even where there are too many.
        let others = siblings().filter(|other| *other != at);
        let entries: Vec<usize> = std::iter::once(at).chain(others).take(MOST).collect();
        self.left_out = siblings().count().saturating_sub(MOST);
        let request = world.next_request();
        self.asked = Some((request, entries.clone()));
        vec![Effect::ReadRows { request, entries }]
    }

    fn take_rows(
        &mut self,
        request: u64,
        rows: &Result<Vec<Row>, String>,
        world: &mut World,
    ) -> Vec<Effect> {
        let Some((_, entries)) = self.asked.take_if(|(asked, _)| *asked == request) else {
            return Vec::new();
        };
        match rows {
            Ok(rows) => self.rows = entries.into_iter().zip(rows.iter().cloned()).collect(),
            Err(why) => self.trouble = Some(why.clone()),
        }
        self.show(world)
    }

    /// Asks for the pictures of what is selected.
    fn show(&mut self, world: &mut World) -> Vec<Effect> {
        if !self.shown || !world.info().is_some_and(|i| i.pictures) {
            return self.pictures.stop();
        }
        let request = match (self.row(), self.selected()) {
            (Some(row), _) => pictures::request(row),
            // Its row is still being read.
            (None, Some(_)) => return Vec::new(),
            (None, None) => match self.info(world) {
                Some(info) => pictures::defaults(&world.problem, info),
                None => return Vec::new(),
            },
        };
        self.pictures.want(request, world)
    }

    /// Position in the index of the selected setting.
    fn selected(&self) -> Option<usize> {
        self.settings.get(self.setting).copied()
    }

    fn row(&self) -> Option<&Row> {
        self.rows.get(&self.selected()?)
    }

    fn info<'a>(&self, world: &'a World) -> Option<&'a TechniqueInfo> {
        world.info()?.techniques.iter().find(|t| t.id == world.technique)
    }

    /// The declared knobs; those of the record where nothing is declared.
    fn knobs(&self, world: &World) -> Vec<KnobInfo> {
        if let Some(info) = self.info(world) {
            return info.knobs.clone();
        }
        let names = self.row().into_iter().flat_map(|row| row.knobs.keys());
        names.map(|name| KnobInfo { name: name.clone(), ..KnobInfo::default() }).collect()
    }

    /// Metrics of the selected setting, the axis first.
    fn metrics(&self, world: &World) -> Vec<String> {
        let axis = world.info().map(|i| i.axis.clone()).unwrap_or_default();
        let index = &world.store.index;
        let entry = self.selected().and_then(|at| index.entries.get(at));
        let mut metrics: Vec<String> = entry.map_or(Vec::new(), |e| index.metrics(e).to_vec());
        metrics.sort_by_key(|m| *m != axis);
        metrics
    }

    fn metric(&self, world: &World) -> String {
        let metrics = self.metrics(world);
        metrics.get(self.metric % metrics.len().max(1)).cloned().unwrap_or_default()
    }
}

/// Ids of the techniques: declared, else found in records.
fn techniques(world: &World) -> Vec<String> {
    if let Some(info) = world.info() {
        return info.techniques.iter().map(|t| t.id.clone()).collect();
    }
    let index = &world.store.index;
    let ours = index.entries.iter().filter(|e| index.key(e).problem == world.problem);
    let mut ids: Vec<String> = ours.map(|e| index.setting(e).technique.clone()).collect();
    ids.sort();
    ids.dedup();
    ids
}

/// A knob's value without the quotes of JSON.
fn told(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_string)
}
