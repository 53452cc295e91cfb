//! The screen `overview`: one row a problem, and what stands behind the selected one.

mod summary;
#[cfg(test)]
mod tests;

use super::World;
use crate::{
    keys::Action,
    msg::{Effect, Msg},
    theme::Theme,
    widgets::{
        Cell, Column, Cursor, format,
        pane::{self, Pair, pair},
        table,
    },
};
use dapple_records::{Feed, FeedLine, catalogue::ProblemInfo};
use ratatui::{
    buffer::Buffer,
    layout::{Constraint, Layout, Rect},
    text::Line,
    widgets::Widget,
};
use summary::{Best, Cheapest, Summary};

/// What is selected and shown.
#[derive(Clone, Debug, Default)]
pub struct State {
    rows: Vec<Summary>,
    cursor: Cursor,
}

impl State {
    /// A key's action: moves the selection, which other screens follow.
    pub fn update(&mut self, action: Action, world: &mut World) -> Vec<Effect> {
        self.cursor.act(action, self.rows.len());
        if let Some(row) = self.selected().filter(|row| row.id != world.problem) {
            world.problem.clone_from(&row.id);
            world.technique.clear();
        }
        Vec::new()
    }

    /// New records or a new catalogue: the rows are made anew.
    pub fn hear(&mut self, msg: &Msg, world: &mut World) -> Vec<Effect> {
        let told = matches!(msg, Msg::Heard { line, .. }
            if matches!(&**line, FeedLine::Event(Feed::Catalogue(_))));
        if told || matches!(msg, Msg::Store(_)) {
            self.rows = summary::summaries(world);
            self.follow(world);
        }
        Vec::new()
    }

    /// The screen is now shown.
    pub fn enter(&mut self, world: &mut World) -> Vec<Effect> {
        self.follow(world);
        Vec::new()
    }

    /// Another screen is now shown.
    pub fn leave(&mut self, _world: &mut World) -> Vec<Effect> {
        Vec::new()
    }

    fn selected(&self) -> Option<&Summary> {
        self.rows.get(self.cursor.at(self.rows.len())?)
    }

    /// Selects the problem that the other screens are about.
    fn follow(&mut self, world: &World) {
        if let Some(at) = self.rows.iter().position(|row| row.id == world.problem) {
            self.cursor.set(at);
        }
    }

    /// Draws.
    pub fn view(&self, world: &World, area: Rect, buf: &mut Buffer) {
        if self.rows.is_empty() {
            let waiting = world.catalogue_trouble.is_none();
            let text = if waiting { "asking what there is ..." } else { "no problems, no records" };
            Line::styled(text, world.theme.dim()).render(area, buf);
            return;
        }
        // The table takes what it needs, but leaves half of the room to what is selected.
        let needs = self.rows.len() as u16 + 1;
        let table = if area.height < 8 { area.height } else { needs.min(area.height / 2) };
        let [above, rule, below] = Layout::vertical([
            Constraint::Length(table),
            Constraint::Length(u16::from(area.height > table)),
            Constraint::Fill(1),
        ])
        .areas(area);
        self.table(world, above, buf);
        let Some(row) = self.selected() else { return };
        let info = world.catalogue.as_ref();
        let info = info.and_then(|c| c.problems.iter().find(|p| p.id == row.id));
        Line::styled("─".repeat(rule.width.into()), world.theme.dim()).render(rule, buf);
        pane::draw(&details(row, info, world), 0, world.theme, below, buf);
    }

    fn table(&self, world: &World, area: Rect, buf: &mut Buffer) {
        let columns = [
            Column::words("problem", 17),
            Column::number("tech", 4).rank(6),
            Column::words("gates", 13).fixed(),
            Column::words("tight", 15).fixed().rank(7),
            Column::words("best", 17).fixed().rank(1),
            Column::words("loose", 15).fixed().rank(8),
            Column::words("claims", 11).fixed().rank(2),
            Column::number("stable", 6).rank(4),
            Column::number("age", 6).rank(3),
            Column::words("machine", 9).fixed().rank(9),
        ];
        let theme = world.theme;
        let selected = self.cursor.at(self.rows.len());
        table::draw(&columns, self.rows.len(), selected, theme, area, buf, |at| {
            let row = &self.rows[at];
            let best = |level: usize| {
                let found = row.best.first().and_then(|b| Some((b, b.at.get(level)?.as_ref()?)));
                let none = if row.best.is_empty() { "-" } else { "none" };
                found.map_or(none.into(), |(best, cheapest)| brief(best, cheapest))
            };
            vec![
                row.id.clone().into(),
                row.techniques.to_string().into(),
                gates(row, world),
                best(0).into(),
                best(1).into(),
                best(2).into(),
                claims(row, theme),
                stable(row).into(),
                row.newest_ms.map_or("-".into(), |then| format::age(world.now_ms, then)).into(),
                machine(row, world).into(),
            ]
        });
    }
}

/// `1.23 ms msm`, the figure first: what is cut where it is narrow is the name. Imitated hardware
/// is marked, as its times say little.
fn brief(best: &Best, cheapest: &Cheapest) -> String {
    let technique = cheapest.name.split('/').next().unwrap_or_default();
    let mark = if best.key.device == "software" { "sw " } else { "" };
    format!("{mark}{} {technique}", format::duration(cheapest.time_ns))
}

fn gates(row: &Summary, world: &World) -> Cell {
    let gates = &row.gates;
    let theme = world.theme;
    let age = gates.time_ms.map(|then| format::age(world.now_ms, then)).unwrap_or_default();
    if gates.failed > 0 {
        return Cell::styled(format!("✗ {} broken", gates.failed), theme.bad());
    }
    if gates.passed == 0 {
        let text = if gates.not_run > 0 { "- not run" } else { "- never run" };
        return Cell::styled(text, theme.neutral());
    }
    Cell::styled(format!("✓ {} {age}", gates.passed), theme.good())
}

fn claims(row: &Summary, theme: Theme) -> Cell {
    let claims = &row.claims;
    if claims.total() == 0 {
        return Cell::styled("not judged", theme.neutral());
    }
    let errors = if claims.errors > 0 { format!(" {}!", claims.errors) } else { String::new() };
    let text = format!("{}✓ {}✗ {}?{errors}", claims.reproduced, claims.refuted, claims.open);
    text.into()
}

fn stable(row: &Summary) -> String {
    match row.stable {
        (_, 0) => "-".into(),
        (stable, all) => format!("{}%", stable * 100 / all),
    }
}

fn machine(row: &Summary, world: &World) -> String {
    let own = world.catalogue.as_ref().is_some_and(|c| c.machine == row.machine);
    match (row.machine.is_empty(), own) {
        (true, _) => "-".into(),
        (false, true) => "this".into(),
        (false, false) => row.machine.clone(),
    }
}

/// The selected problem in words: what was asked, what was found, what to run next.
fn details(row: &Summary, info: Option<&ProblemInfo>, world: &World) -> Vec<Pair> {
    let theme = world.theme;
    let mut pairs = Vec::new();
    if let Some(info) = info {
        pairs.push(pair("question", info.question.clone()));
    }
    for next in next(row, info) {
        let key = if pairs.iter().any(|p: &Pair| p.key == "next") { "" } else { "next" };
        pairs.push(pair(key, next).style(theme.title()));
    }
    pairs.extend(
        row.gates
            .broken
            .iter()
            .take(5)
            .map(|broken| pair("broken", broken.clone()).style(theme.bad())),
    );
    for best in &row.best {
        let key = &best.key;
        let device = if key.device == "cpu" { "" } else { &format!(" ({})", key.device) };
        let whose = world.catalogue.as_ref().is_some_and(|c| c.machine == key.machine);
        let machine = if whose { "this machine" } else { &key.machine };
        pairs.push(pair(
            "best",
            format!("{}{device}, {machine}: {} {}", key.adapter, key.case, key.size),
        ));
        for (at, level) in best.at.iter().zip(info.map(|i| i.levels.as_slice()).unwrap_or_default())
        {
            let metric = info.map(|i| i.axis.as_str()).unwrap_or_default();
            let found = at.as_ref().map_or("none".into(), |c| {
                format!(
                    "{} {} ± {} at {}",
                    c.name,
                    format::duration(c.time_ns),
                    format::duration(c.mad_ns),
                    format::significant(c.error)
                )
            });
            pairs.push(pair("", format!("{metric} ≤ {}: {found}", format::significant(*level))));
        }
    }
    if let Some(info) = info {
        pairs.push(pair("truth", info.truth.clone()));
        let metrics = info.metrics.iter().map(|(name, unit, help)| {
            let unit = if unit.is_empty() { String::new() } else { format!(" [{unit}]") };
            format!("{name}{unit}: {help}")
        });
        for (i, metric) in metrics.enumerate() {
            pairs.push(pair(if i == 0 { "metrics" } else { "" }, metric));
        }
    }
    let claims = &row.claims;
    pairs.push(pair(
        "claims",
        format!(
            "{} reproduced, {} refuted, {} open, {} could not be judged; {} declared",
            claims.reproduced,
            claims.refuted,
            claims.open,
            claims.errors,
            info.map_or(0, |i| i.claims.len())
        ),
    ));
    let (safe, all) = row.stable;
    pairs.push(pair(
        "stable",
        format!("{safe} of {all} pairs of technique and axis are safe throughout"),
    ));
    pairs
}

/// Commands for what is missing.
fn next(row: &Summary, info: Option<&ProblemInfo>) -> Vec<String> {
    let id = &row.id;
    let declared = |f: fn(&ProblemInfo) -> bool| info.is_none_or(f);
    let mut next = Vec::new();
    if row.best.is_empty() {
        next.push(format!("dapple measure {id}  # times and errors"));
    }
    if row.gates.time_ms.is_none() && declared(|i| !i.gates.is_empty()) {
        next.push(format!("dapple verify {id}  # correctness gates"));
    }
    if row.claims.total() == 0 && declared(|i| !i.claims.is_empty()) {
        next.push(format!("dapple claims {id}  # what the sources say, judged"));
    }
    if row.stable.1 == 0 && declared(|i| !i.extremes.is_empty()) {
        next.push(format!("dapple stress {id}  # where it breaks"));
    }
    if !next.is_empty() {
        next.push("8, then n, starts one from here".into());
    }
    next
}
