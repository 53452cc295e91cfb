//! The state of the dashboard: `update` changes it, `view` draws it, neither does anything else.

use crate::{
    keys::{self, Action},
    msg::{Effect, JobId, Msg},
    screens::{self, Screen, World},
    theme::Theme,
};
use dapple_records::{Feed, FeedLine};
use ratatui::{
    buffer::Buffer,
    crossterm::event::KeyEventKind,
    layout::{Constraint, Layout, Rect},
    text::{Line, Span},
    widgets::{Block, Clear, Paragraph, Widget, Wrap},
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
                picker: Picker::halfblocks(),
                request: 0,
            },
            screen: Screen::default(),
            help: false,
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
        let job = self.world.jobs.reserve();
        self.catalogue_job = Some(job);
        let ask = Effect::Start { job, arguments: vec!["catalogue".into()], input: false };
        vec![Effect::Reload, ask]
    }

    /// Takes in a message.
    pub fn update(&mut self, msg: Msg) -> Vec<Effect> {
        let mut effects = Vec::new();
        match &msg {
            Msg::Key(key) => {
                if key.kind == KeyEventKind::Release {
                    return effects;
                }
                // A form takes keys as text, but never the one that always quits.
                let action = keys::lookup(*key, self.screen);
                if self.screen == Screen::Runs && self.runs.typing() && action != Some(Action::Quit)
                {
                    return self.runs.key(*key, &mut self.world);
                }
                return action.map_or(effects, |action| self.act(action));
            }
            Msg::Resize => return effects,
            Msg::Tick(now) => self.world.now_ms = *now,
            Msg::Store(store) => {
                self.world.store = Arc::new((**store).clone());
                self.choose_problem();
            }
            Msg::Heard { job, line } => {
                if Some(*job) == self.catalogue_job {
                    if let FeedLine::Event(Feed::Catalogue(catalogue)) = &**line {
                        self.world.catalogue = Some(Arc::new((**catalogue).clone()));
                        self.choose_problem();
                    }
                } else {
                    self.world.jobs.hear(*job, line);
                }
            }
            Msg::Grumbled { job, text } => {
                if let Some(job) = self.world.jobs.get_mut(*job) {
                    job.log(text.clone());
                }
            }
            Msg::Ended { job, code, how } => {
                if Some(*job) == self.catalogue_job && self.world.catalogue.is_none() {
                    self.world.catalogue_trouble = Some(how.clone());
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

    fn act(&mut self, action: Action) -> Vec<Effect> {
        match action {
            Action::Quit => vec![Effect::Quit],
            Action::Help => {
                self.help = !self.help;
                Vec::new()
            }
            Action::Close if self.help => {
                self.help = false;
                Vec::new()
            }
            Action::Go(screen) => self.go(screen),
            Action::NextScreen => self.go(self.neighbour(1)),
            Action::PreviousScreen => self.go(self.neighbour(Screen::ALL.len() - 1)),
            Action::Reload => vec![Effect::Reload],
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
        let theme = self.world.theme;
        let [tabs, body, footer] =
            Layout::vertical([Constraint::Length(1), Constraint::Min(1), Constraint::Length(1)])
                .areas(area);
        self.tabs().render(tabs, buf);
        of_screen!(self, self.screen, view(&self.world, body, buf));
        self.footer(footer.width).style(theme.dim()).render(footer, buf);
        if self.help {
            self.draw_help(body, buf);
        }
    }

    fn tabs(&self) -> Line<'static> {
        let theme = self.world.theme;
        let mut spans = Vec::new();
        for (i, screen) in Screen::ALL.iter().enumerate() {
            let text = format!("{}{}", i + 1, screen.title());
            let current = *screen == self.screen;
            let (text, style) = if current {
                (format!("[{text}]"), theme.title())
            } else {
                (format!(" {text} "), theme.dim())
            };
            spans.push(Span::styled(text, style));
        }
        Line::from(spans)
    }

    /// As many of the screen's keys as fit; the way to the others and out comes first.
    fn footer(&self, width: u16) -> Line<'static> {
        let labelled = || keys::on(self.screen).filter(|b| !b.label.is_empty());
        let last = |b: &&keys::Binding| matches!(b.action, Action::Quit | Action::Help);
        let mut text = String::new();
        for binding in labelled().filter(last).chain(labelled().filter(|b| !last(b))) {
            let more = format!("{} {}  ", binding.name, binding.label);
            if text.chars().count() + more.chars().count() > usize::from(width) + 2 {
                break;
            }
            text += &more;
        }
        Line::from(text)
    }

    fn draw_help(&self, area: Rect, buf: &mut Buffer) {
        let mut lines: Vec<Line<'_>> = keys::on(self.screen)
            .map(|b| Line::from(format!("{:>9}  {}", b.name, b.help)))
            .collect();
        lines.push(Line::from("   Ctrl-C  leave"));
        let height = (lines.len() as u16 + 2).min(area.height);
        let width = 50.min(area.width);
        let popup = Rect {
            x: area.x + (area.width - width) / 2,
            y: area.y + (area.height - height) / 2,
            width,
            height,
        };
        Clear.render(popup, buf);
        Paragraph::new(lines)
            .wrap(Wrap { trim: false })
            .block(Block::bordered().title(format!("{}: keys", self.screen.title())))
            .render(popup, buf);
    }
}
