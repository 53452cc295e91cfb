//! The screen `live`: a knob is turned, and image, errors and frame times follow.
//!
//! A child (`dapple live`) does the work while the screen is shown. Every change sends the whole
//! setting under a new number; what comes back under an older number is dropped.

mod choice;
mod times;
mod view;

#[cfg(test)]
mod tests;

use super::World;
use crate::{
    keys::Action,
    msg::{Effect, JobId, Msg},
    plot::picture::Triplet,
    widgets::Cursor,
};
use choice::{Choice, Row, Turn};
use dapple_records::{Feed, FeedLine, Show};
use std::collections::BTreeMap;
use times::Times;

/// Lines of the child's own words that are kept for the case that it dies.
const LAST_WORDS: usize = 3;

/// What is selected and shown.
#[derive(Clone, Debug, Default)]
pub struct State {
    shown: bool,
    child: Option<JobId>,
    choice: Choice,
    cursor: Cursor,
    face: Face,
    /// Which metric is named first; counts up, and is read modulo the metrics there are.
    metric: usize,
    asked: Option<Asked>,
    answer: Option<Answer>,
    before: Option<Answer>,
    picture: Option<Triplet>,
    times: Times,
    stage: String,
    truth: String,
    trouble: Option<String>,
    last_words: Vec<String>,
}

/// Which picture is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Face {
    #[default]
    Result,
    Truth,
    Error,
}

/// The newest request.
#[derive(Clone, Debug, PartialEq)]
struct Asked {
    show: Show,
    at_ms: i64,
    answered: bool,
}

/// What a check found.
#[derive(Clone, Debug, Default, PartialEq)]
struct Answer {
    show: Show,
    errors: BTreeMap<String, f64>,
    counters: BTreeMap<String, u64>,
    memory_bytes: u64,
    violations: Vec<String>,
}

impl State {
    /// A key's action. Effects of the screen's own; changes of `world` that others see.
    pub fn update(&mut self, action: Action, world: &mut World) -> Vec<Effect> {
        let Some(info) = world.info() else { return Vec::new() };
        let rows = self.choice.rows(info);
        if self.cursor.act(action, rows.len()) {
            return Vec::new();
        }
        let turn = match action {
            Action::OrbitLeft => Some(Turn::Around(-1)),
            Action::OrbitRight => Some(Turn::Around(1)),
            Action::OrbitUp => Some(Turn::Up(1)),
            Action::OrbitDown => Some(Turn::Up(-1)),
            Action::Nearer => Some(Turn::Away(-1)),
            Action::Farther => Some(Turn::Away(1)),
            _ => None,
        };
        // What has no picture has no camera.
        if let Some(turn) = turn.filter(|_| info.pictures) {
            let turned = self.choice.turn(turn);
            return if turned { self.ask(world) } else { Vec::new() };
        }
        let row = match action {
            Action::Left | Action::Right => {
                self.cursor.at(rows.len()).and_then(|at| rows.get(at).cloned())
            }
            Action::Technique => Some(Row::Technique),
            Action::Form => Some(Row::Form),
            Action::Scene => Some(Row::Scene),
            _ => None,
        };
        if let Some(row) = row {
            if !self.choice.step(world, &row, action != Action::Left) {
                return Vec::new();
            }
            world.technique.clone_from(&self.choice.technique);
            return self.ask(world);
        }
        match action {
            Action::Flip => {
                self.face = if self.face == Face::Result { Face::Truth } else { Face::Result };
                Vec::new()
            }
            Action::ErrorMap => {
                self.face = if self.face == Face::Error { Face::Result } else { Face::Error };
                Vec::new()
            }
            Action::Metric => {
                self.metric = self.metric.wrapping_add(1);
                Vec::new()
            }
            Action::Reset => {
                self.choice.reset();
                self.ask(world)
            }
            // Starts the child again; one that is there answers again.
            Action::Open => self.ask(world),
            _ => Vec::new(),
        }
    }

    /// A message that is not a key: rows asked for, a child's line, new records, a tick. Every
    /// screen hears every message, whether it is shown or not.
    pub fn hear(&mut self, msg: &Msg, world: &mut World) -> Vec<Effect> {
        match msg {
            Msg::Heard { job, line } if Some(*job) == self.child => {
                if let FeedLine::Event(event) = &**line {
                    self.take_in(event);
                }
            }
            Msg::Grumbled { job, text } if Some(*job) == self.child => {
                if self.last_words.len() == LAST_WORDS {
                    self.last_words.remove(0);
                }
                self.last_words.push(text.clone());
            }
            Msg::Ended { job, how, .. } if Some(*job) == self.child => {
                self.child = None;
                self.asked = None;
                let words = std::mem::take(&mut self.last_words);
                let said = words.iter().map(|w| format!("; {w}")).collect::<String>();
                self.trouble = Some(format!("the live process ended: {how}{said}"));
            }
            // The declarations came while the screen was already shown.
            _ if self.shown && self.asked.is_none() && self.trouble.is_none() => {
                return self.ask_first(world);
            }
            _ => {}
        }
        Vec::new()
    }

    /// The screen is now shown.
    pub fn enter(&mut self, world: &mut World) -> Vec<Effect> {
        self.shown = true;
        self.ask_first(world)
    }

    /// Another screen is now shown: its child would only slow others down.
    pub fn leave(&mut self, _world: &mut World) -> Vec<Effect> {
        self.shown = false;
        self.asked = None;
        self.trouble = None;
        self.stage.clear();
        self.child.take().map(Effect::Stop).into_iter().collect()
    }

    /// Takes over what other screens chose, and asks for it.
    fn ask_first(&mut self, world: &mut World) -> Vec<Effect> {
        let Some(info) = world.info() else { return Vec::new() };
        if self.choice.problem != info.id {
            *self = Self {
                shown: self.shown,
                child: self.child,
                choice: Choice::of(info, &world.technique),
                ..Self::default()
            };
        } else if !world.technique.is_empty() {
            self.choice.set_technique(info, &world.technique);
        }
        self.ask(world)
    }

    /// Asks for what is chosen; starts the child if there is none.
    fn ask(&mut self, world: &mut World) -> Vec<Effect> {
        let mut effects = Vec::new();
        let request = world.next_request();
        let job = self.child.unwrap_or_else(|| {
            let job = world.jobs.reserve();
            effects.push(Effect::Start { job, arguments: vec!["live".into()], input: true });
            self.last_words.clear();
            job
        });
        self.child = Some(job);
        let Some(info) = world.info() else { return Vec::new() };
        let show = self.choice.show(info, request);
        // Plain data with string keys: serialising it cannot fail.
        let line = serde_json::to_string(&show).unwrap_or_default();
        effects.push(Effect::Write { job, line });
        self.asked = Some(Asked { show, at_ms: world.now_ms, answered: false });
        self.trouble = None;
        effects
    }

    fn take_in(&mut self, event: &Feed) {
        let Some(asked) = &mut self.asked else { return };
        let newest = asked.show.request;
        match event {
            Feed::Stage { stage, .. } => self.stage.clone_from(stage),
            Feed::Ready { truth, .. } => self.truth.clone_from(truth),
            Feed::Checked { request, errors, counters, memory_bytes, violations }
                if *request == newest =>
            {
                asked.answered = true;
                let answer = Answer {
                    show: asked.show.clone(),
                    errors: errors.clone(),
                    counters: counters.clone(),
                    memory_bytes: *memory_bytes,
                    violations: violations.clone(),
                };
                // Asked again for the same, the change to what was there before stays.
                let same =
                    |old: &Answer| Show { request: newest, ..old.show.clone() } == answer.show;
                let old = self.answer.replace(answer.clone());
                if !old.as_ref().is_some_and(same) {
                    self.before = old.filter(|o| o.show.problem == answer.show.problem);
                    self.times = Times::default();
                    self.picture = self.picture.take().filter(|_| self.before.is_some());
                }
                self.stage.clear();
            }
            Feed::Picture { request, width, height, truth, result } if *request == newest => {
                match Triplet::decode(*width, *height, truth, result) {
                    Ok(picture) => self.picture = Some(picture),
                    Err(reason) => self.trouble = Some(format!("the picture: {reason}")),
                }
            }
            Feed::Frame { request, ns, clock } if *request == newest => self.times.add(*ns, clock),
            Feed::Failed { request, reason } if *request == newest => {
                asked.answered = true;
                self.stage.clear();
                self.trouble = Some(reason.clone());
            }
            _ => {}
        }
    }
}
