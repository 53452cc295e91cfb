//! The screen `technique`.

use super::World;
use crate::{
    keys::Action,
    msg::{Effect, Msg},
};
use ratatui::{buffer::Buffer, layout::Rect, text::Line, widgets::Widget};

/// What is selected and shown.
#[derive(Clone, Debug, Default)]
pub struct State {}

impl State {
    /// A key's action. Effects of the screen's own; changes of `world` that others see.
    pub fn update(&mut self, _action: Action, _world: &mut World) -> Vec<Effect> {
        Vec::new()
    }

    /// A message that is not a key: rows asked for, a child's line, new records, a tick. Every
    /// screen hears every message, whether it is shown or not.
    pub fn hear(&mut self, _msg: &Msg, _world: &mut World) -> Vec<Effect> {
        Vec::new()
    }

    /// The screen is now shown.
    pub fn enter(&mut self, _world: &mut World) -> Vec<Effect> {
        Vec::new()
    }

    /// Another screen is now shown.
    pub fn leave(&mut self, _world: &mut World) -> Vec<Effect> {
        Vec::new()
    }

    /// Draws.
    pub fn view(&self, _world: &World, area: Rect, buf: &mut Buffer) {
        Line::from("technique").render(area, buf);
    }
}
