//! The screen `claims`: what the sources say, and how our figures judge it.

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
use dapple_records::ClaimLine;
use ratatui::{
    buffer::Buffer,
    layout::{Constraint, Layout, Rect},
    style::Style,
    text::Line,
    widgets::{Paragraph, Widget},
};

#[cfg(test)]
mod tests;

/// The word for a claim that is declared and has no record.
const NOT_JUDGED: &str = "not judged";

/// Verdicts with their glyphs, in the order that the filter goes through.
const VERDICTS: [(&str, &str); 6] = [
    ("reproduced", "✓"),
    ("refuted", "✗"),
    ("open", "?"),
    ("needs-hardware", "◇"),
    ("error", "!"),
    (NOT_JUDGED, "·"),
];

/// Columns at which the lines of a detail are counted for scrolling: no terminal of use is
/// narrower, so the end can always be reached.
const NARROW: u16 = 40;

/// What is selected and shown.
#[derive(Clone, Debug, Default)]
pub struct State {
    cursor: Cursor,
    /// Which of [`VERDICTS`] are shown; all if none.
    only: Option<usize>,
    open: bool,
    scroll: Cursor,
}

/// A claim, judged or not.
struct Claim<'a> {
    id: &'a str,
    statement: &'a str,
    /// The latest verdict first, one a machine and adapter.
    judged: Vec<&'a ClaimLine>,
}

impl Claim<'_> {
    fn verdict(&self) -> &str {
        self.judged.first().map_or(NOT_JUDGED, |line| line.verdict.as_str())
    }
}

/// Declared claims in their order, then what records hold beyond them.
fn claims(world: &World) -> Vec<Claim<'_>> {
    let of_problem = || world.store.index.claims.iter().filter(|c| c.problem == world.problem);
    let declared = world.info().map(|info| info.claims.as_slice()).unwrap_or_default();
    let mut all: Vec<Claim<'_>> = declared
        .iter()
        .map(|(id, statement)| Claim { id, statement, judged: Vec::new() })
        .collect();
    for line in of_problem() {
        match all.iter_mut().find(|claim| claim.id == line.id) {
            Some(claim) => claim.judged.push(line),
            None => {
                all.push(Claim { id: &line.id, statement: &line.statement, judged: vec![line] })
            }
        }
    }
    for claim in &mut all {
        // RFC 3339 in UTC sorts as text.
        claim.judged.sort_by(|a, b| b.time.cmp(&a.time));
    }
    all
}

impl State {
    fn shown<'a>(&self, world: &'a World) -> Vec<Claim<'a>> {
        let mut all = claims(world);
        if let Some((verdict, _)) = self.only.and_then(|at| VERDICTS.get(at)) {
            all.retain(|claim| claim.verdict() == *verdict);
        }
        all
    }

    /// A key's action. Effects of the screen's own; changes of `world` that others see.
    pub fn update(&mut self, action: Action, world: &mut World) -> Vec<Effect> {
        let shown = self.shown(world);
        let selected = self.cursor.at(shown.len());
        match action {
            Action::Open => {
                self.open = !self.open && selected.is_some();
                self.scroll = Cursor::default();
            }
            Action::Close => self.open = false,
            Action::Verdict => {
                let present = |at: &usize| {
                    let (verdict, _) = VERDICTS[*at];
                    claims(world).iter().any(|claim| claim.verdict() == verdict)
                };
                let from = self.only.map_or(0, |at| at + 1);
                self.only = (from..VERDICTS.len()).find(present);
                self.cursor = Cursor::default();
                self.open = false;
            }
            action if self.open => {
                let claim = selected.and_then(|at| shown.get(at));
                let theme = world.theme;
                let lines = claim.map_or(0, |claim| detail(claim, world, NARROW, theme).len());
                self.scroll.act(action, lines);
            }
            action => {
                self.cursor.act(action, shown.len());
            }
        }
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
        self.open = false;
        Vec::new()
    }

    /// Draws.
    pub fn view(&self, world: &World, area: Rect, buf: &mut Buffer) {
        let theme = world.theme;
        let shown = self.shown(world);
        let selected = self.cursor.at(shown.len());
        let [heading, body] =
            Layout::vertical([Constraint::Length(1), Constraint::Fill(1)]).areas(area);
        Line::styled(self.heading(world), theme.title()).render(heading, buf);
        let Some(claim) = selected.and_then(|at| shown.get(at)) else {
            let text = match world.info() {
                _ if self.only.is_some() => "none of this verdict; v shows others".into(),
                Some(info) => format!("{} declares no claims", info.id),
                None => format!("no claims; `dapple claims {}` judges them", world.problem),
            };
            return Paragraph::new(Line::styled(text, theme.dim())).render(body, buf);
        };
        if self.open {
            let lines = detail(claim, world, body.width, theme);
            let most = lines.len().saturating_sub(body.height.into());
            let first = self.scroll.at(lines.len()).unwrap_or_default().min(most);
            let seen: Vec<_> = lines.into_iter().skip(first).take(body.height.into()).collect();
            return Paragraph::new(seen).render(body, buf);
        }
        let columns = [
            Column::words("claim", 12).fixed(),
            Column::words("verdict", 16).fixed(),
            Column::words("statement", 20),
            Column::words("age", 6).fixed().rank(1),
        ];
        table::draw(&columns, shown.len(), selected, theme, body, buf, |at| {
            let claim = &shown[at];
            let age = claim.judged.first().map(|l| format::age_of(world.now_ms, &l.time));
            vec![
                claim.id.into(),
                verdict_cell(claim.verdict(), theme),
                claim.statement.into(),
                age.unwrap_or_default().into(),
            ]
        });
    }

    fn heading(&self, world: &World) -> String {
        let all = claims(world);
        let counts: Vec<String> = VERDICTS
            .iter()
            .filter_map(|(verdict, glyph)| {
                let n = all.iter().filter(|c| c.verdict() == *verdict).count();
                (n > 0).then(|| format!("{glyph} {n} {verdict}"))
            })
            .collect();
        let only = self.only.and_then(|at| VERDICTS.get(at));
        let only = only.map(|v| format!("only {}: ", v.0)).unwrap_or_default();
        // The problem comes last: it is the first to be cut off where it is narrow.
        format!("{only}{}  of {}", counts.join("  "), world.problem)
    }
}

fn verdict_cell(verdict: &str, theme: Theme) -> Cell {
    let glyph = VERDICTS.iter().find(|v| v.0 == verdict).map_or("!", |v| v.1);
    Cell::styled(format!("{glyph} {verdict}"), verdict_style(verdict, theme))
}

fn verdict_style(verdict: &str, theme: Theme) -> Style {
    match verdict {
        "reproduced" => theme.good(),
        "refuted" | "error" => theme.bad(),
        NOT_JUDGED => theme.dim(),
        _ => theme.neutral(),
    }
}

/// Everything about a claim.
fn detail(claim: &Claim<'_>, world: &World, width: u16, theme: Theme) -> Vec<Line<'static>> {
    let mut pairs = vec![
        pair("claim", claim.id),
        pair("verdict", verdict_cell(claim.verdict(), theme).text)
            .style(verdict_style(claim.verdict(), theme)),
        pair("statement", claim.statement),
    ];
    let Some(line) = claim.judged.first() else {
        pairs.push(pair("", ""));
        pairs.push(pair("judge it", command(world, claim.id)));
        return pane::lines(&pairs, width, theme);
    };
    pairs.extend([
        pair("source", &*line.place),
        pair("method", &*line.method),
        pair("because", &*line.because),
        pair("", ""),
    ]);
    let mut lines = pane::lines(&pairs, width, theme);
    lines.extend(figures(line, width, theme));
    let mut pairs = vec![
        pair("", ""),
        pair("judged", format!("{} ago, {}", format::age_of(world.now_ms, &line.time), line.time)),
        pair("where", format!("{}, adapter {}", line.machine, line.adapter)),
        pair("revision", &*line.revision),
    ];
    // The same claim on other machines or adapters may have gone otherwise.
    pairs.extend(claim.judged.iter().skip(1).map(|other| {
        let verdict = verdict_cell(&other.verdict, theme);
        let place = format!("{} on {}, {}", verdict.text, other.machine, other.adapter);
        pair("elsewhere", place).style(verdict.style)
    }));
    pairs.push(pair("again", command(world, claim.id)));
    lines.extend(pane::lines(&pairs, width, theme));
    lines
}

fn command(world: &World, id: &str) -> String {
    format!("dapple claims {} --id {id}", world.problem)
}

/// The figures, values right-aligned under each other.
fn figures(line: &ClaimLine, width: u16, theme: Theme) -> Vec<Line<'static>> {
    let value = |f: &dapple_records::ClaimFigure| {
        let text = if f.value.is_finite() { format::significant(f.value) } else { "none".into() };
        if f.unit.is_empty() { text } else { format!("{text} {}", f.unit) }
    };
    let values: Vec<String> = line.figures.iter().map(value).collect();
    let widest = values.iter().map(|v| crate::widgets::text::width(v)).max().unwrap_or_default();
    let pairs: Vec<Pair> = values
        .iter()
        .zip(&line.figures)
        .map(|(value, figure)| pair(format!("{value:>widest$}"), &*figure.what))
        .collect();
    let mut lines = Vec::new();
    if !pairs.is_empty() {
        lines.push(Line::styled("figures", theme.title()));
    }
    lines.extend(pane::lines(&pairs, width, theme));
    lines
}
