//! How the screen `compare` is drawn.

use super::{Outcome, State, runs};
use crate::{
    screens::World,
    widgets::{
        Cell, Column,
        format::{age_of, count, duration, plural, significant},
        pane::{self, pair},
        table, text,
    },
};
use dapple_records::compare::{Change, Pair, TimeChange, Verdict};
use ratatui::{
    buffer::Buffer,
    layout::{Constraint, Layout, Rect},
    style::Style,
    text::{Line, Span},
    widgets::{Paragraph, Widget},
};

impl State {
    /// Draws.
    pub fn view(&self, world: &World, area: Rect, buf: &mut Buffer) {
        let Some([old, new]) = self.runs else {
            return self.nothing(world, area, buf);
        };
        let mut lines = vec![
            self.run_line(world, "old", old, area.width),
            self.run_line(world, "new", new, area.width),
        ];
        match &self.outcome {
            _ if self.asked.is_some() => {
                lines.push(Line::styled("comparing ...", world.theme.dim()))
            }
            None => {}
            Some(Err(why)) => {
                let told = text::wrap(why, area.width.into());
                lines.extend(told.into_iter().map(|l| Line::styled(l, world.theme.bad())));
            }
            Some(Ok(outcome)) => lines.extend(summary(outcome, world, area.width)),
        }
        let [head, body] =
            Layout::vertical([Constraint::Length(lines.len() as u16), Constraint::Min(0)])
                .areas(area);
        Paragraph::new(lines).render(head, buf);
        if self.detail.is_some() {
            self.draw_detail(world, body, buf);
        } else if self.asked.is_none() && self.outcome().is_some() {
            self.table(world, body, buf);
        }
    }

    fn nothing(&self, world: &World, area: Rect, buf: &mut Buffer) {
        let has = match runs(world).len() {
            0 => format!("{}: no run has been recorded", world.problem),
            _ => format!("{}: one run only; a comparison needs two", world.problem),
        };
        let pairs = [
            pair("", has),
            pair("", format!("make another: dapple measure {}", world.problem)),
            pair("", "or press 8, then n"),
        ];
        pane::draw(&pairs, 0, world.theme, area, buf);
    }

    fn run_line(&self, world: &World, side: &str, run: usize, width: u16) -> Line<'static> {
        let index = &world.store.index;
        let Some(header) = index.headers.get(run) else { return Line::default() };
        let complete = index.ended.get(run).copied().unwrap_or_default();
        let dirty = if header.dirty { "+changes" } else { "" };
        let name = match header.sweep.as_str() {
            "" => header.command.clone(),
            sweep => format!("{sweep} {}", header.shard).trim_end().to_string(),
        };
        let told = format!(
            "{name} · {} ago · {}{dirty} · {} · {}{}",
            age_of(world.now_ms, &header.time),
            header.revision,
            header.cpu,
            header.machine,
            if complete { "" } else { " · UNFINISHED" },
        );
        let all = runs(world);
        let at = all.iter().position(|r| *r == run).unwrap_or_default() + 1;
        let key = format!("{side} {at}/{} ", all.len());
        let room = usize::from(width).saturating_sub(text::width(&key));
        Line::from(vec![Span::styled(key, world.theme.title()), Span::raw(text::fit(&told, room))])
    }

    fn table(&self, world: &World, area: Rect, buf: &mut Buffer) {
        let Some(outcome) = self.outcome() else { return };
        let listed = self.listed();
        if listed.is_empty() {
            let sentence = if outcome.comparison.pairs.is_empty() {
                "no row is in both runs"
            } else {
                "nothing changed beyond threshold and noise; d shows all rows"
            };
            return pane::draw(&[pair("", sentence)], 0, world.theme, area, buf);
        }
        let metric = outcome.metrics.get(self.metric).map_or("", String::as_str);
        let columns = [
            Column::words("what", 8).fixed(),
            Column::words("setting", 12),
            Column::words("form", 4).fixed().rank(3),
            Column::words("case", 12).rank(6),
            Column::number("old", 8).rank(4),
            Column::number("new", 8),
            Column::number("time", 7),
            Column::number("noise", 6).rank(2),
            Column::number(metric, 8),
            Column::number("was", 8).rank(1),
        ];
        let selected = self.cursor.at(listed.len());
        table::draw(&columns, listed.len(), selected, world.theme, area, buf, |i| {
            let (pair, line) = (&outcome.comparison.pairs[listed[i]], &outcome.lines[listed[i]]);
            let mut cells: Vec<Cell> = vec![
                what(pair, world),
                line.setting.clone().into(),
                line.form.clone().into(),
                line.case.clone().into(),
            ];
            cells.extend(time_cells(pair.time.as_ref(), world));
            cells.extend(error_cells(pair, metric, world));
            cells
        });
    }

    fn draw_detail(&self, world: &World, area: Rect, buf: &mut Buffer) {
        let theme = world.theme;
        let Some(detail) = &self.detail else { return };
        let title = self.selected().map(|(line, pair)| {
            let changes: Vec<&str> = pair.changes.iter().map(|c| c.name()).collect();
            let changes = if changes.is_empty() { "no change".into() } else { changes.join(", ") };
            format!("{} ({}), {}: {changes}", line.setting, line.form, line.case)
        });
        let [head, reason, body] =
            Layout::vertical([Constraint::Length(1), Constraint::Length(1), Constraint::Min(0)])
                .areas(area);
        Line::styled(title.unwrap_or_default(), theme.title()).render(head, buf);
        if let Some(time) = self.selected().and_then(|(_, pair)| pair.time.as_ref()) {
            let because = match time.because {
                "" => String::new(),
                because => format!("; not judged: {because}"),
            };
            let told = format!(
                "time x{:.3}, noise explains ±{:.1} %{because}",
                time.ratio,
                time.band * 100.0
            );
            Line::styled(told, theme.dim()).render(reason, buf);
        }
        match &detail.rows {
            None => Line::styled("reading the records ...", theme.dim()).render(body, buf),
            Some(Err(why)) => Line::styled(why.clone(), theme.bad()).render(body, buf),
            Some(Ok(_)) => {
                let lines = self.detail_lines(world);
                let columns = [
                    Column::words("", 16).fixed(),
                    Column::words("old", 16),
                    Column::words("new", 16),
                    Column::words("", 1).fixed(),
                ];
                let first = detail.scroll.min(lines.len().saturating_sub(1));
                let shown = &lines[first.min(lines.len())..];
                table::draw(&columns, shown.len(), None, theme, body, buf, |i| {
                    let line = &shown[i];
                    let style = if line.differs { Style::new() } else { theme.dim() };
                    let [old, new] = line.sides.clone();
                    let mark = if line.differs { "≠" } else { "" };
                    vec![
                        Cell::styled(line.what.clone(), theme.dim()),
                        Cell::styled(old, style),
                        Cell::styled(new, style),
                        Cell::styled(mark, theme.title()),
                    ]
                });
            }
        }
    }
}

/// What happened to a pair: the worst, and how much else.
fn what(pair: &Pair, world: &World) -> Cell {
    let Some(worst) = pair.changes.first() else {
        return Cell::styled("same", world.theme.dim());
    };
    let more = match pair.changes.len() {
        1 => String::new(),
        n => format!("+{}", n - 1),
    };
    Cell::styled(format!("{}{more}", worst.name()), style(*worst, world))
}

fn style(change: Change, world: &World) -> Style {
    match change {
        Change::Failed | Change::Gone | Change::Slower | Change::Worse => world.theme.bad(),
        Change::Counters | Change::NotRun | Change::New => world.theme.neutral(),
        Change::Fixed | Change::Better | Change::Faster => world.theme.good(),
    }
}

fn time_cells(time: Option<&TimeChange>, world: &World) -> [Cell; 4] {
    let Some(time) = time else { return Default::default() };
    let ratio = match time.verdict {
        Verdict::Worse => Cell::styled(format!("x{:.2} ▲", time.ratio), world.theme.bad()),
        Verdict::Better => Cell::styled(format!("x{:.2} ▼", time.ratio), world.theme.good()),
        Verdict::NotJudged => format!("x{:.2} ?", time.ratio).into(),
        _ => Cell::styled(format!("x{:.2}  ", time.ratio), world.theme.dim()),
    };
    let noise = format!("±{:.0} %", time.band * 100.0);
    [duration(time.old_ns).into(), duration(time.new_ns).into(), ratio, noise.into()]
}

fn error_cells(pair: &Pair, metric: &str, world: &World) -> [Cell; 2] {
    let Some(error) = pair.errors.iter().find(|e| e.metric == metric) else {
        return Default::default();
    };
    let told = |value: Option<f64>| value.map_or("-".into(), significant);
    let new = match error.verdict {
        Verdict::Worse => Cell::styled(format!("{}▲", told(error.new)), world.theme.bad()),
        Verdict::Better => Cell::styled(format!("{}▼", told(error.new)), world.theme.good()),
        _ => format!("{} ", told(error.new)).into(),
    };
    [new, told(error.old).into()]
}

fn summary(outcome: &Outcome, world: &World, width: u16) -> Vec<Line<'static>> {
    let comparison = &outcome.comparison;
    let mut text = format!("{} in both", plural(comparison.joined(), "row"));
    let counts = comparison.counts();
    for change in Change::ALL {
        if let Some(n) = counts.get(&change) {
            text += &format!(", {} {}", count(*n), change.name());
        }
    }
    if let Some(times) = comparison.times() {
        let (mean, spread) = (times.geometric_mean, times.spread);
        text += &format!("; times x{mean:.3} in the geometric mean, spread x{spread:.2}");
    }
    if outcome.left_out > 0 {
        text += &format!("; {} not read: too many at once", plural(outcome.left_out, "row"));
    }
    let wrapped = |text: &str| text::wrap(text, width.into());
    let mut lines: Vec<Line<'static>> = wrapped(&text).into_iter().map(Line::from).collect();
    for refused in &comparison.refused {
        lines.extend(wrapped(refused).into_iter().map(|l| Line::styled(l, world.theme.bad())));
    }
    lines
}
