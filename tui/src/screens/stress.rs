//! The screen `stress`: techniques against extremes, and why a technique breaks.

mod image;
mod map;
mod view;

#[cfg(test)]
mod tests;

use super::World;
use crate::{
    keys::Action,
    msg::{Effect, Msg},
    widgets::Cursor,
};
use dapple_records::StressLine;
use image::Image;
use map::{Map, Place};

/// What is selected and shown.
#[derive(Clone, Debug, Default)]
pub struct State {
    row: Cursor,
    column: usize,
    form: usize,
    place: usize,
    /// Whether the points of the selected cell are listed, and which is selected.
    open: Option<Cursor>,
    image: Image,
}

impl State {
    /// The form and place shown; none without records.
    fn shown(&self, world: &World) -> Option<(String, Place)> {
        let mut forms = map::forms(world);
        if forms.is_empty() {
            return None;
        }
        let form = forms.swap_remove(self.form % forms.len());
        let mut places = map::places(world, &form);
        let at = self.place.checked_rem(places.len())?;
        Some((form, places.swap_remove(at)))
    }

    /// The selected cell: technique, variant and axis with their points.
    fn cell<'a>(&self, map: &Map<'a>) -> Option<(&'a str, &'a str, &'a str, Vec<&'a StressLine>)> {
        let row = *map.rows.get(self.row.at(map.rows.len())?)?;
        let axis = *map.axes.get(self.column.min(map.axes.len().checked_sub(1)?))?;
        Some((row.0, row.1, axis, map.cell(row, axis)))
    }

    /// A key's action. Effects of the screen's own; changes of `world` that others see.
    pub fn update(&mut self, action: Action, world: &mut World) -> Vec<Effect> {
        let Some((form, place)) = self.shown(world) else { return Vec::new() };
        let map = Map::of(world, &form, &place);
        match action {
            Action::Form => {
                // Positions past the end are read modulo what there is.
                self.form = (self.form + 1) % map::forms(world).len().max(1);
                self.place = 0;
                return self.close();
            }
            Action::Adapter => {
                self.place = (self.place + 1) % map::places(world, &form).len().max(1);
                return self.close();
            }
            Action::Close => return self.close(),
            _ => {}
        }
        let Some((.., points)) = self.cell(&map) else { return Vec::new() };
        let listed = listed(&points);
        if let Some(cursor) = &mut self.open {
            if cursor.act(action, listed.len()) {
                return Vec::new();
            }
            let command = cursor.at(listed.len()).map(|at| listed[at].command.clone());
            return match (action, command) {
                (Action::Open, Some(command)) => self.image.start(&command, world),
                _ => Vec::new(),
            };
        }
        let (rows, axes) = (map.rows.len(), map.axes.len());
        self.column = self.column.min(axes.saturating_sub(1));
        match action {
            Action::Left => self.column = self.column.saturating_sub(1),
            Action::Right => self.column = (self.column + 1).min(axes.saturating_sub(1)),
            Action::Open if !listed.is_empty() => self.open = Some(Cursor::default()),
            action => {
                self.row.act(action, rows);
            }
        }
        Vec::new()
    }

    fn close(&mut self) -> Vec<Effect> {
        self.open = None;
        self.image.stop()
    }

    /// A message that is not a key: rows asked for, a child's line, new records, a tick. Every
    /// screen hears every message, whether it is shown or not.
    pub fn hear(&mut self, msg: &Msg, _world: &mut World) -> Vec<Effect> {
        self.image.hear(msg);
        Vec::new()
    }

    /// The screen is now shown.
    pub fn enter(&mut self, _world: &mut World) -> Vec<Effect> {
        // Another problem has other cells.
        self.close()
    }

    /// Another screen is now shown.
    pub fn leave(&mut self, _world: &mut World) -> Vec<Effect> {
        self.close()
    }
}

/// The points that a list shows: those that failed, or all where none did.
fn listed<'a>(points: &[&'a StressLine]) -> Vec<&'a StressLine> {
    let failing: Vec<_> = points.iter().copied().filter(|p| !p.is_safe()).collect();
    if failing.is_empty() { points.to_vec() } else { failing }
}
