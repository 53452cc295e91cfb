//! The screen `runs`: jobs with their progress, the runs in the records, a form to start more.

mod form;
#[cfg(test)]
mod tests;

use super::World;
use crate::{
    jobs::{Job, State as JobState},
    keys::Action,
    msg::{Effect, Msg},
    theme::Theme,
    widgets::{
        Cell, Column, Cursor, bar, format,
        pane::{self, Pair, pair},
        popup, table, text,
    },
};
use dapple_records::RunHeader;
use form::{Done, Form};
use ratatui::{
    buffer::Buffer,
    crossterm::event::KeyEvent,
    layout::{Constraint, Layout, Rect},
    text::{Line, Span},
    widgets::{Paragraph, Widget},
};

/// What is selected and shown.
#[derive(Clone, Debug, Default)]
pub struct State {
    cursor: Cursor,
    form: Option<Form>,
    /// Whether the selected row is shown in full, and the lines scrolled back from its end.
    open: bool,
    back: usize,
}

/// A row of the list: jobs of this session, the newest first, then the runs of the records.
#[derive(Clone, Copy)]
enum Row<'a> {
    Job(&'a Job),
    Run(&'a RunHeader, bool),
}

fn count(world: &World) -> usize {
    world.jobs.list.len() + world.store.index.headers.len()
}

fn row(world: &World, at: usize) -> Option<Row<'_>> {
    let jobs = &world.jobs.list;
    if let Some(job) = jobs.len().checked_sub(at + 1).and_then(|i| jobs.get(i)) {
        return Some(Row::Job(job));
    }
    let index = &world.store.index;
    let at = index.headers.len().checked_sub(at - jobs.len() + 1)?;
    Some(Row::Run(index.headers.get(at)?, index.ended.get(at).copied().unwrap_or_default()))
}

/// The job of this session that writes a run.
fn writer<'a>(world: &'a World, run: &RunHeader) -> Option<&'a Job> {
    let short: String = run.run.chars().take(8).collect();
    let writes = |job: &&Job| !short.is_empty() && job.path.contains(&short);
    world.jobs.running().filter(writes)
}

impl State {
    fn selected<'a>(&self, world: &'a World) -> Option<Row<'a>> {
        row(world, self.cursor.at(count(world))?)
    }

    /// A key's action.
    pub fn update(&mut self, action: Action, world: &mut World) -> Vec<Effect> {
        match action {
            Action::Close => self.open = false,
            Action::Up if self.open => self.back = self.back.saturating_add(1),
            Action::Down if self.open => self.back = self.back.saturating_sub(1),
            Action::PageUp if self.open => self.back = self.back.saturating_add(10),
            Action::PageDown if self.open => self.back = self.back.saturating_sub(10),
            Action::First if self.open => self.back = usize::MAX,
            Action::Last if self.open => self.back = 0,
            Action::Open | Action::Log => {
                self.open = !self.open && self.selected(world).is_some();
                self.back = 0;
            }
            Action::Cancel => {
                let job = match self.selected(world) {
                    Some(Row::Job(job)) => Some(job.id),
                    Some(Row::Run(run, _)) => writer(world, run).map(|job| job.id),
                    None => None,
                };
                return job.map(|id| world.jobs.cancel(id, world.now_ms)).unwrap_or_default();
            }
            Action::New => return self.begin(world),
            action => {
                self.cursor.act(action, count(world));
            }
        }
        Vec::new()
    }

    /// Resumes the unfinished run that is selected, or opens the form.
    fn begin(&mut self, world: &mut World) -> Vec<Effect> {
        self.open = false;
        let resumed = match self.selected(world) {
            Some(Row::Run(run, false)) if writer(world, run).is_none() => form::again(&run.command),
            _ => None,
        };
        match resumed {
            Some(arguments) => self.start(arguments, world),
            None => {
                self.form = Some(Form::new(world));
                Vec::new()
            }
        }
    }

    fn start(&mut self, arguments: Vec<String>, world: &mut World) -> Vec<Effect> {
        let shown = arguments.iter().filter(|a| *a != "--feed").map(String::as_str);
        let title = shown.collect::<Vec<_>>().join(" ");
        // The newest job is the first row.
        self.cursor.set(0);
        world.jobs.add(title, arguments, world.now_ms)
    }

    /// The rows are made from the world as they are drawn.
    pub fn hear(&mut self, _msg: &Msg, _world: &mut World) -> Vec<Effect> {
        Vec::new()
    }

    /// The screen is now shown.
    pub fn enter(&mut self, _world: &mut World) -> Vec<Effect> {
        Vec::new()
    }

    /// Another screen is now shown.
    pub fn leave(&mut self, _world: &mut World) -> Vec<Effect> {
        self.open = false;
        Vec::new()
    }

    /// Whether keys are text for a form.
    pub fn typing(&self) -> bool {
        self.form.is_some()
    }

    /// A key while [`State::typing`].
    pub fn key(&mut self, key: KeyEvent, world: &mut World) -> Vec<Effect> {
        let Some(form) = &mut self.form else { return Vec::new() };
        match form.key(key, world) {
            Done::No => Vec::new(),
            Done::Cancelled => {
                self.form = None;
                Vec::new()
            }
            Done::Start(arguments) => {
                self.form = None;
                self.start(arguments, world)
            }
        }
    }

    /// Draws.
    pub fn view(&self, world: &World, area: Rect, buf: &mut Buffer) {
        let theme = world.theme;
        let count = count(world);
        if count == 0 {
            let text = if world.loaded { "no jobs, no runs: n starts one" } else { "reading ..." };
            Line::styled(text, theme.dim()).render(area, buf);
        } else if self.open && area.height < 10 {
            self.detail(world, area, buf);
        } else {
            let below = if self.open { area.height * 2 / 3 } else { 0 };
            let [above, below] =
                Layout::vertical([Constraint::Fill(1), Constraint::Length(below)]).areas(area);
            list(world, self.cursor.at(count), above, buf);
            self.detail(world, below, buf);
        }
        if let Some(form) = &self.form {
            draw_form(form, theme, area, buf);
        }
    }

    /// The selected row in full: what it is, then its log from the end.
    fn detail(&self, world: &World, area: Rect, buf: &mut Buffer) {
        let Some(row) = self.selected(world).filter(|_| !area.is_empty()) else { return };
        let theme = world.theme;
        let [rule, area] =
            Layout::vertical([Constraint::Length(1), Constraint::Fill(1)]).areas(area);
        Line::styled("─".repeat(rule.width.into()), theme.dim()).render(rule, buf);
        let (pairs, log) = match row {
            Row::Job(job) => (about_job(job, world), Some(&job.log)),
            Row::Run(run, ended) => (about_run(run, ended, world), None),
        };
        let mut lines = pane::lines(&pairs, area.width, theme);
        for entry in log.into_iter().flatten() {
            let wrapped = text::wrap(entry, usize::from(area.width).max(1));
            lines.extend(wrapped.into_iter().map(Line::from));
        }
        let most = lines.len().saturating_sub(area.height.into());
        let first = most - self.back.min(most);
        let shown: Vec<_> = lines.into_iter().skip(first).take(area.height.into()).collect();
        Paragraph::new(shown).render(area, buf);
    }
}

fn list(world: &World, selected: Option<usize>, area: Rect, buf: &mut Buffer) {
    let columns = [
        Column::words("run", 16),
        Column::words("state", 12).fixed(),
        Column::words("progress", 16).fixed().rank(2),
        Column::number("done", 9).rank(3),
        Column::number("left", 8).rank(1),
        Column::number("age", 6).rank(4),
        Column::words("machine", 9).fixed().rank(5),
    ];
    table::draw(&columns, count(world), selected, world.theme, area, buf, |at| {
        match row(world, at) {
            Some(Row::Job(job)) => job_cells(job, world),
            Some(Row::Run(run, ended)) => run_cells(run, ended, world),
            None => Vec::new(),
        }
    });
}

/// A sign and a word for how a job stands.
fn state(job: &Job, theme: Theme) -> Cell {
    match &job.state {
        JobState::Queued => Cell::styled("· queued", theme.neutral()),
        JobState::Running => Cell::styled("▶ running", theme.title()),
        JobState::Stopping => Cell::styled("■ stopping", theme.neutral()),
        JobState::Ended { code: Some(0), .. } => Cell::styled("✓ done", theme.good()),
        JobState::Ended { code: Some(1), .. } => Cell::styled("✗ check: 1", theme.bad()),
        JobState::Ended { code: Some(code), .. } => {
            Cell::styled(format!("✗ exit {code}"), theme.bad())
        }
        JobState::Ended { how, .. } if how.starts_with("cancelled") => {
            Cell::styled("- cancelled", theme.neutral())
        }
        JobState::Ended { .. } => Cell::styled("✗ died", theme.bad()),
    }
}

fn job_cells(job: &Job, world: &World) -> Vec<Cell> {
    let failed = matches!(&job.state, JobState::Ended { code, .. } if *code != Some(0));
    let began = if job.began_ms > 0 { format::age(world.now_ms, job.began_ms) } else { "-".into() };
    let done = match job.total {
        0 => String::new(),
        total => format!("{}/{}", job.done, total),
    };
    let left = job.left_ms(world.now_ms).map(format::clock).unwrap_or_default();
    let title = match last_words(job).filter(|_| failed) {
        Some(words) => format!("{}: {words}", job.title),
        None => job.title.clone(),
    };
    vec![
        title.into(),
        state(job, world.theme),
        if job.began_ms > 0 { bar::bar(job.done, job.total, 16).into() } else { "".into() },
        done.into(),
        left.into(),
        began.into(),
        "this".into(),
    ]
}

/// What a failed job said before the word on its end.
fn last_words(job: &Job) -> Option<&String> {
    job.log.iter().rev().nth(1)
}

fn run_cells(run: &RunHeader, ended: bool, world: &World) -> Vec<Cell> {
    let theme = world.theme;
    let state = match (ended, writer(world, run)) {
        (true, _) => Cell::styled("✓ complete", theme.good()),
        (false, Some(_)) => Cell::styled("▶ running", theme.title()),
        (false, None) => Cell::styled("… unfinished", theme.bad()),
    };
    let own = world.catalogue.as_ref().is_some_and(|c| c.machine == run.machine);
    let shard = if run.shard.is_empty() { String::new() } else { format!(" {}", run.shard) };
    vec![
        format!("{}{shard} {}", run.sweep, began(&run.time)).into(),
        state,
        "".into(),
        "".into(),
        "".into(),
        format::age_of(world.now_ms, &run.time).into(),
        if own { "this".into() } else { run.machine.as_str().into() },
    ]
}

/// Month, day, hour and minute: the age says the year.
fn began(time: &str) -> String {
    time.get(5..16).unwrap_or(time).replace('T', " ")
}

fn about_job(job: &Job, world: &World) -> Vec<Pair> {
    let words = match &job.state {
        JobState::Ended { how, .. } => how.clone(),
        JobState::Queued => "waits for the one before it".into(),
        JobState::Running => job.now.clone(),
        JobState::Stopping => "ends what it is at; x again kills it".into(),
    };
    let spent = match job.ended_ms {
        0 => world.now_ms.saturating_sub(job.began_ms),
        ended => ended.saturating_sub(job.began_ms),
    };
    let spent = if job.began_ms == 0 { 0 } else { spent };
    vec![
        pair("command", format!("dapple {}", job.title)),
        pair("state", words),
        pair("time", format::clock(spent)),
    ]
}

fn about_run(run: &RunHeader, ended: bool, world: &World) -> Vec<Pair> {
    let next = match (ended, writer(world, run), form::again(&run.command)) {
        (true, _, _) => "complete".into(),
        (false, Some(_), _) => "being written by the job above".into(),
        (false, None, Some(_)) => "unfinished: n starts its command again".into(),
        (false, None, None) => "unfinished; its command is not one of ours".to_string(),
    };
    let dirty = if run.dirty { ", with changes" } else { "" };
    let memory = if run.memory_bytes > 0 {
        format!(", {}", format::bytes(run.memory_bytes))
    } else {
        String::new()
    };
    vec![
        pair("command", run.command.clone()),
        pair("state", next),
        pair("time", run.time.clone()),
        pair("program", format!("{} {}{dirty}", run.version, run.revision)),
        pair(
            "machine",
            format!("{}: {}, {} threads{memory}, {}", run.machine, run.cpu, run.threads, run.os),
        ),
        pair("run", run.run.clone()),
    ]
}

fn draw_form(form: &Form, theme: Theme, area: Rect, buf: &mut Buffer) {
    let (verb, help) = form.verb();
    let height = form.fields.len() as u16 + 6;
    let inside = popup::draw("start", [76, height], theme, area, buf);
    let mut lines = Vec::new();
    let mut line = |at: usize, name: &str, value: String, hint: &str| {
        let here = form.at == at;
        let mark = if here { ">" } else { " " };
        let style = if here { theme.selected() } else { ratatui::style::Style::new() };
        let hint = if here || value.is_empty() { hint } else { "" };
        lines.push(Line::from(vec![
            Span::raw(format!("{mark}{name:<10}")),
            Span::styled(format!(" {value} "), style),
            Span::raw(" "),
            Span::styled(hint.to_string(), theme.dim()),
        ]));
    };
    line(0, "what", format!("< {verb} >"), help);
    for (i, field) in form.fields.iter().enumerate() {
        let here = form.at == i + 1;
        let value = match field.is_choice() {
            true => format!("< {} >", field.text()),
            false if here => format!("{}_", field.text()),
            false => field.text().to_string(),
        };
        line(i + 1, field.name, value, field.hint);
    }
    lines.push(Line::default());
    lines.push(Line::styled(
        "Enter start  Esc leave  Up, Down field  Left, Right choice",
        theme.dim(),
    ));
    // The field at hand is always seen.
    let first = (form.at + 1).saturating_sub(usize::from(inside.height).max(1));
    let shown: Vec<_> = lines.into_iter().skip(first).take(inside.height.into()).collect();
    Paragraph::new(shown).render(inside, buf);
}

/// The job that is selected, for tests.
#[cfg(test)]
fn selected_job(state: &State, world: &World) -> Option<crate::msg::JobId> {
    match state.selected(world)? {
        Row::Job(job) => Some(job.id),
        Row::Run(..) => None,
    }
}
