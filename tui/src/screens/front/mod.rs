//! The screen `front`: error against time, with the settings that nothing else beats in both.

mod model;
#[cfg(test)]
mod tests;
mod view;

use super::World;
use crate::{
    keys::Action,
    msg::{Effect, Msg},
    widgets::Cursor,
};
use dapple_records::{Feed, FeedLine, Row, front::Point};
use model::{Choice, Model};
use std::collections::BTreeMap;

pub use model::{Case, Place, letter};

/// Whole rows that are kept.
const CACHED: usize = 64;

/// What is selected and shown.
#[derive(Clone, Debug, Default)]
pub struct State {
    choice: Choice,
    model: Model,
    /// Positions in the model's points of the rows in the table.
    listed: Vec<usize>,
    /// Whether settings off the front are in the table too.
    only_front: bool,
    cursor: Cursor,
    /// Whole rows by their position in the index.
    rows: BTreeMap<usize, Result<Row, String>>,
    /// The request under way and the position it asks for.
    asked: Option<(u64, usize)>,
    shown: bool,
}

impl State {
    /// A key's action. Effects of the screen's own; changes of `world` that others see.
    pub fn update(&mut self, action: Action, world: &mut World) -> Vec<Effect> {
        if self.cursor.act(action, self.listed.len()) {
            return self.select(world);
        }
        match action {
            Action::Scene => self.choice.case = next(&self.model.cases, self.model.case),
            Action::Adapter => self.choice.place = next(&self.model.places, self.model.place),
            Action::Metric => {
                let at = self.model.metrics.iter().position(|m| *m == self.model.metric);
                self.choice.metric = next(&self.model.metrics, at.unwrap_or_default());
            }
            Action::Clock => {
                let at = self.model.clocks.iter().position(|c| *c == self.model.gpu_clock);
                self.choice.gpu_clock = next(&self.model.clocks, at.unwrap_or_default());
            }
            Action::All => self.only_front = !self.only_front,
            _ => return Vec::new(),
        }
        self.refresh(world)
    }

    /// A message that is not a key: rows asked for, a child's line, new records, a tick. Every
    /// screen hears every message, whether it is shown or not.
    pub fn hear(&mut self, msg: &Msg, world: &mut World) -> Vec<Effect> {
        match msg {
            Msg::Store(_) => {
                // Positions are others now.
                self.rows.clear();
                self.asked = None;
            }
            Msg::Heard { line, .. } => {
                let FeedLine::Event(Feed::Catalogue(_)) = &**line else { return Vec::new() };
            }
            Msg::Rows { request, rows } => return self.take_rows(*request, rows, world),
            _ => return Vec::new(),
        }
        if self.shown { self.refresh(world) } else { Vec::new() }
    }

    /// The screen is now shown.
    pub fn enter(&mut self, world: &mut World) -> Vec<Effect> {
        self.shown = true;
        self.refresh(world)
    }

    /// Another screen is now shown.
    pub fn leave(&mut self, _world: &mut World) -> Vec<Effect> {
        self.shown = false;
        Vec::new()
    }

    /// Makes plot and table anew; the same setting stays selected if it is still there.
    fn refresh(&mut self, world: &mut World) -> Vec<Effect> {
        let kept = world.focus.clone();
        self.model = Model::of(world, &self.choice);
        let points = self.model.points.iter().enumerate();
        self.listed =
            points.filter(|(_, p)| p.on_front || !self.only_front).map(|(i, _)| i).collect();
        let index = &world.store.index;
        let same = |&at: &usize| {
            let entry = &index.entries[self.model.points[at].index];
            kept.as_ref().is_some_and(|focus| {
                focus.identity == entry.identity && focus.setting == *index.setting(entry)
            })
        };
        match self.listed.iter().position(same) {
            Some(at) => self.cursor.set(at),
            None => self.cursor.set(0),
        }
        self.select(world)
    }

    /// The selected point.
    fn point(&self) -> Option<&Point> {
        self.model.points.get(*self.listed.get(self.cursor.at(self.listed.len())?)?)
    }

    /// Tells other screens what is selected, and asks for its row.
    fn select(&mut self, world: &mut World) -> Vec<Effect> {
        let Some(at) = self.point().map(|p| p.index) else { return Vec::new() };
        if let Some(focus) = super::Focus::of(&world.store.index, at) {
            world.technique.clone_from(&focus.setting.technique);
            world.focus = Some(focus);
        }
        self.ask(world)
    }

    /// One request at a time: while keys are held down, only the last selection matters.
    fn ask(&mut self, world: &mut World) -> Vec<Effect> {
        let Some(at) = self.point().map(|p| p.index) else { return Vec::new() };
        if self.asked.is_some() || self.rows.contains_key(&at) {
            return Vec::new();
        }
        let request = world.next_request();
        self.asked = Some((request, at));
        vec![Effect::ReadRows { request, entries: vec![at] }]
    }

    fn take_rows(
        &mut self,
        request: u64,
        rows: &Result<Vec<Row>, String>,
        world: &mut World,
    ) -> Vec<Effect> {
        let Some((_, at)) = self.asked.filter(|(asked, _)| *asked == request) else {
            return Vec::new();
        };
        self.asked = None;
        if self.rows.len() >= CACHED {
            self.rows.clear();
        }
        let gone = || "the record is gone".to_string();
        let row = rows.clone().and_then(|rows| rows.into_iter().next().ok_or_else(gone));
        self.rows.insert(at, row);
        self.ask(world)
    }

    /// The whole row of the selected point, once it has been read.
    fn row(&self) -> Option<&Result<Row, String>> {
        self.rows.get(&self.point()?.index)
    }
}

/// The one after, the first after the last.
fn next<T: Clone>(list: &[T], at: usize) -> Option<T> {
    list.get((at + 1) % list.len().max(1)).cloned()
}
