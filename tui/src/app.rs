//! The state of the dashboard: `update` changes it, `view` draws it, neither does anything else.

mod chrome;
#[cfg(test)]
mod tests;

use crate::{
    keys::{self, Action},
    msg::{Effect, JobId, Msg},
    screens::{self, Screen, World},
    theme::Theme,
    widgets::text,
};
use dapple_records::{Feed, FeedLine};
use ratatui::{
    buffer::Buffer,
    crossterm::event::{KeyEvent, KeyEventKind, KeyModifiers},
    layout::{Constraint, Layout, Rect},
    text::Line,
    widgets::Widget,
};
use ratatui_image::picker::Picker;
use std::sync::Arc;

/// The whole state.
#[derive(Clone, Debug)]
pub struct App {
    /// Shared by screens.
    pub world: World,
    /// The screen shown.
    pub screen: Screen,
    /// Whether the keys are shown.
    pub help: bool,
    /// Lines of the keys that are scrolled past.
    help_from: u16,
    /// Whether the user was asked to confirm that running jobs be stopped.
    asked: bool,
    /// Whether a key was pressed.
    touched: bool,
    catalogue_job: Option<JobId>,
    overview: screens::overview::State,
    front: screens::front::State,
    technique: screens::technique::State,
    live: screens::live::State,
    stress: screens::stress::State,
    claims: screens::claims::State,
    compare: screens::compare::State,
    runs: screens::runs::State,
}

/// Calls one method of the state that belongs to a screen.
macro_rules! of_screen {
    ($app:expr, $screen:expr, $method:ident ( $($argument:expr),* )) => {
        match $screen {
            Screen::Overview => $app.overview.$method($($argument),*),
            Screen::Front => $app.front.$method($($argument),*),
            Screen::Technique => $app.technique.$method($($argument),*),
            Screen::Live => $app.live.$method($($argument),*),
            Screen::Stress => $app.stress.$method($($argument),*),
            Screen::Claims => $app.claims.$method($($argument),*),
            Screen::Compare => $app.compare.$method($($argument),*),
            Screen::Runs => $app.runs.$method($($argument),*),
        }
    };
}

impl App {
    /// The state at the start.
    pub fn new(colour: bool, now_ms: i64) -> Self {
        Self {
            world: World {
                store: Arc::default(),
                catalogue: None,
                catalogue_trouble: None,
                jobs: Default::default(),
                theme: Theme { colour },
                now_ms,
                problem: String::new(),
                technique: String::new(),
                focus: None,
                picker: Picker::halfblocks(),
                request: 0,
                loaded: false,
                leaving: false,
            },
            screen: Screen::default(),
            help: false,
            help_from: 0,
            asked: false,
            touched: false,
            catalogue_job: None,
            overview: Default::default(),
            front: Default::default(),
            technique: Default::default(),
            live: Default::default(),
            stress: Default::default(),
            claims: Default::default(),
            compare: Default::default(),
            runs: Default::default(),
        }
    }

    /// What to do first: read the records, ask the program what there is.
    pub fn start(&mut self) -> Vec<Effect> {
        vec![Effect::Reload, self.ask_catalogue()]
    }

    fn ask_catalogue(&mut self) -> Effect {
        let job = self.world.jobs.reserve();
        self.catalogue_job = Some(job);
        self.world.catalogue_trouble = None;
        Effect::Start { job, arguments: vec!["catalogue".into()], input: false }
    }

    /// Takes in a message.
    pub fn update(&mut self, msg: Msg) -> Vec<Effect> {
        let mut effects = Vec::new();
        match &msg {
            Msg::Key(key) if key.kind == KeyEventKind::Release => return effects,
            Msg::Key(key) => return self.key(*key),
            Msg::Terminate => return vec![Effect::Quit],
            Msg::Resize => return effects,
            Msg::Tick(now) => self.world.now_ms = *now,
            Msg::Store(store) => {
                self.world.store = Arc::clone(store);
                self.world.loaded = true;
                self.choose_problem();
            }
            Msg::Heard { job, line } => {
                if Some(*job) == self.catalogue_job {
                    if let FeedLine::Event(Feed::Catalogue(catalogue)) = &**line {
                        // Until the user chose one, the first that is declared is shown.
                        if !self.touched {
                            self.world.problem.clear();
                        }
                        self.world.catalogue = Some(Arc::new((**catalogue).clone()));
                        self.choose_problem();
                    }
                } else {
                    self.world.jobs.hear(*job, line);
                }
            }
            Msg::Grumbled { job, text } => {
                if Some(*job) == self.catalogue_job {
                    self.world.catalogue_trouble = Some(text.clone());
                } else if let Some(job) = self.world.jobs.get_mut(*job) {
                    job.log(text.clone());
                }
            }
            Msg::Ended { job, code, how } => {
                if Some(*job) == self.catalogue_job {
                    self.catalogue_job = None;
                    let said = self.world.catalogue_trouble.take().unwrap_or_else(|| how.clone());
                    let missing = self.world.catalogue.is_none();
                    self.world.catalogue_trouble = missing.then_some(said);
                }
                let now = self.world.now_ms;
                effects.extend(self.world.jobs.end(*job, *code, how, now));
                effects.push(Effect::Reload);
            }
            Msg::Rows { .. } => {}
        }
        for screen in Screen::ALL {
            effects.extend(of_screen!(self, screen, hear(&msg, &mut self.world)));
        }
        effects
    }

    fn key(&mut self, key: KeyEvent) -> Vec<Effect> {
        self.touched = true;
        let action = keys::lookup(key, self.screen);
        if self.asked {
            return self.answer(action == Some(Action::Quit));
        }
        // A form takes keys as text, but never the one that leaves whatever is typed.
        let leaves = key.modifiers.contains(KeyModifiers::CONTROL) && action == Some(Action::Quit);
        if self.screen == Screen::Runs && self.runs.typing() && !leaves {
            return self.runs.key(key, &mut self.world);
        }
        action.map(|action| self.act(action)).unwrap_or_default()
    }

    /// The answer to whether running jobs may be stopped.
    fn answer(&mut self, yes: bool) -> Vec<Effect> {
        self.asked = false;
        if yes {
            self.world.jobs.clear_queue(self.world.now_ms);
            return vec![Effect::Quit];
        }
        Vec::new()
    }

    fn act(&mut self, action: Action) -> Vec<Effect> {
        match action {
            Action::Quit if self.world.jobs.active() => {
                self.asked = true;
                Vec::new()
            }
            Action::Quit => vec![Effect::Quit],
            Action::Help => {
                self.help = !self.help;
                self.help_from = 0;
                Vec::new()
            }
            Action::Close if self.help => {
                self.help = false;
                Vec::new()
            }
            Action::Up | Action::Down | Action::PageUp | Action::PageDown | Action::First
                if self.help =>
            {
                let most = keys::on(self.screen).count() as u16;
                let from = self.help_from;
                self.help_from = match action {
                    Action::Up => from.saturating_sub(1),
                    Action::Down => (from + 1).min(most),
                    Action::PageUp => from.saturating_sub(10),
                    Action::PageDown => (from + 10).min(most),
                    _ => 0,
                };
                Vec::new()
            }
            Action::Go(screen) => self.go(screen),
            Action::NextScreen => self.go(self.neighbour(1)),
            Action::PreviousScreen => self.go(self.neighbour(Screen::ALL.len() - 1)),
            Action::Reload => {
                let mut effects = vec![Effect::Reload];
                if self.world.catalogue.is_none() && self.catalogue_job.is_none() {
                    effects.push(self.ask_catalogue());
                }
                effects
            }
            Action::Problem => {
                self.next_problem();
                of_screen!(self, self.screen, enter(&mut self.world))
            }
            action => {
                let mut effects = of_screen!(self, self.screen, update(action, &mut self.world));
                // A row that stands for more: the next screen shows it.
                let next = match (self.screen, action) {
                    (Screen::Overview, Action::Open) => Some(Screen::Front),
                    (Screen::Front, Action::Open) => Some(Screen::Technique),
                    (Screen::Technique, Action::Open) => Some(Screen::Live),
                    _ => None,
                };
                if let Some(screen) = next {
                    effects.extend(self.go(screen));
                }
                effects
            }
        }
    }

    fn go(&mut self, screen: Screen) -> Vec<Effect> {
        if screen == self.screen {
            return Vec::new();
        }
        let mut effects = of_screen!(self, self.screen, leave(&mut self.world));
        self.screen = screen;
        self.help = false;
        effects.extend(of_screen!(self, screen, enter(&mut self.world)));
        effects
    }

    fn neighbour(&self, step: usize) -> Screen {
        let at = Screen::ALL.iter().position(|s| *s == self.screen).unwrap_or_default();
        Screen::ALL[(at + step) % Screen::ALL.len()]
    }

    /// Keeps the chosen problem while there is one of that name.
    fn choose_problem(&mut self) {
        let ids = self.world.problems();
        if !ids.contains(&self.world.problem) {
            self.world.problem = ids.into_iter().next().unwrap_or_default();
        }
    }

    fn next_problem(&mut self) {
        let ids = self.world.problems();
        let at = ids.iter().position(|id| *id == self.world.problem).map_or(0, |i| i + 1);
        self.world.problem = ids.get(at % ids.len().max(1)).cloned().unwrap_or_default();
        self.world.technique.clear();
    }

    /// Draws everything. Any area will do, down to nothing.
    pub fn view(&self, area: Rect, buf: &mut Buffer) {
        // A terminal that shrank while a picture was made may be smaller than what it asked for.
        let area = area.intersection(buf.area);
        if area.is_empty() {
            return;
        }
        let theme = self.world.theme;
        let trouble = chrome::trouble(&self.world);
        let line = |shown: bool| Constraint::Length(u16::from(shown));
        let [tabs, status, body, footer] = Layout::vertical([
            line(true),
            line(trouble.is_some() && area.height >= 5),
            Constraint::Fill(1),
            line(area.height >= 3),
        ])
        .areas(area);
        chrome::tabs(self.screen, tabs.width, theme).render(tabs, buf);
        if let Some(trouble) = trouble {
            let text = format!("! {trouble}");
            Line::styled(text::fit(&text, status.width.into()), theme.bad()).render(status, buf);
        }
        if !body.is_empty() {
            of_screen!(self, self.screen, view(&self.world, body, buf));
        }
        chrome::footer(self.screen, &self.world, theme, footer, buf);
        if self.help {
            chrome::help(self.screen, self.help_from, theme, body, buf);
        }
        if self.asked {
            chrome::ask(&self.world.jobs, theme, body, buf);
        }
        if self.world.leaving {
            chrome::leaving(theme, body, buf);
        }
    }
}
