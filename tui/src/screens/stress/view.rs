//! Drawing of the stress screen: the map above, the selected cell below, or its points.

use super::{
    State, listed,
    map::{self, Kind, Map, Summary},
};
use crate::{
    screens::World,
    theme::Theme,
    widgets::{
        Cell, Column, cursor, format,
        pane::{self, pair},
        table, text,
    },
};
use dapple_records::{StressLine, safe_set::safe_set};
use ratatui::{
    buffer::Buffer,
    layout::{Constraint, Layout, Rect},
    style::Style,
    text::{Line, Span},
    widgets::Widget,
};

/// Columns of a cell, its gap included.
const CELL: u16 = 8;

/// Columns of the techniques' names.
const NAMES: u16 = 22;

/// Rows below the map.
const DETAIL: u16 = 9;

/// What the glyphs mean.
const LEGEND: &str = "■ all safe  ◧ part  ◫ holes  □ none  ✗ crashed or took bad input  · not run";

impl Kind {
    fn glyph(self) -> &'static str {
        match self {
            Self::Full => "■",
            Self::Part => "◧",
            Self::Holes => "◫",
            Self::None => "□",
            Self::Crashed => "✗",
            Self::NotRun => "·",
        }
    }

    fn style(self, theme: Theme) -> Style {
        match self {
            Self::Full => theme.good(),
            Self::Part | Self::Holes => theme.neutral(),
            Self::None | Self::Crashed => theme.bad(),
            Self::NotRun => theme.dim(),
        }
    }
}

/// Glyph and share of a cell; 100 % only where all of it is safe.
fn cell_text(summary: &Summary) -> String {
    let glyph = summary.kind.glyph();
    match (summary.share, summary.kind) {
        (None, _) => glyph.into(),
        (Some(_), Kind::Full) => format!("{glyph} 100%"),
        (Some(share), _) => format!("{glyph} {:>3.0}%", (100.0 * share).floor().min(99.0)),
    }
}

impl State {
    /// Draws.
    pub fn view(&self, world: &World, area: Rect, buf: &mut Buffer) {
        let theme = world.theme;
        let Some((form, place)) = self.shown(world) else {
            let text = format!(
                "no stress points of {}; `dapple stress {}` pushes every technique to its extremes",
                world.problem, world.problem
            );
            return put(&wrapped(&text, area.width, theme.dim()), area, buf);
        };
        let map = Map::of(world, &form, &place);
        let software = if place.device == "software" { " (software)" } else { "" };
        let title = format!(
            "{} from case {}, form {form}, adapter {}{software}, machine {}",
            world.problem, place.case, place.adapter, place.machine
        );
        let [heading, body] =
            Layout::vertical([Constraint::Length(1), Constraint::Fill(1)]).areas(area);
        Line::styled(text::fit(&title, area.width.into()), theme.title()).render(heading, buf);
        let Some((technique, variant, axis, points)) = self.cell(&map) else { return };
        let name = name(technique, variant);
        if let Some(cursor) = self.open {
            let listed = listed(&points);
            let head = format!("{name} along {axis}");
            return self.draw_points(world, &head, &listed, cursor.at(listed.len()), body, buf);
        }
        let rows = map.rows.len() as u16 + 1;
        let top = rows.min(body.height.saturating_sub(DETAIL + 1).max(2));
        let [grid, legend, detail] =
            Layout::vertical([Constraint::Length(top), Constraint::Length(1), Constraint::Fill(1)])
                .areas(body);
        self.draw_map(&map, theme, grid, buf);
        Line::styled(text::fit(LEGEND, legend.width.into()), theme.dim()).render(legend, buf);
        let detail = Rect {
            y: detail.y + u16::from(detail.height > DETAIL),
            height: detail.height.saturating_sub(u16::from(detail.height > DETAIL)),
            ..detail
        };
        put(&cell_lines(world, &name, axis, &points, detail.width), detail, buf);
    }

    fn draw_map(&self, map: &Map<'_>, theme: Theme, area: Rect, buf: &mut Buffer) {
        let names = NAMES.min(area.width / 3);
        let fit = usize::from(area.width.saturating_sub(names) / CELL).max(1);
        let column = self.column.min(map.axes.len().saturating_sub(1));
        let first_axis = cursor::first_shown(Some(column), map.axes.len(), fit);
        let selected = self.row.at(map.rows.len());
        let height = usize::from(area.height.saturating_sub(1));
        let first_row = cursor::first_shown(selected, map.rows.len(), height);
        let mut heading = vec![Span::raw(" ".repeat(names.into()))];
        for (i, axis) in map.axes.iter().enumerate().skip(first_axis).take(fit) {
            let style = if i == column { theme.title() } else { theme.dim() };
            let title = text::fit(axis, usize::from(CELL) - 1);
            heading
                .push(Span::styled(format!("{title:<width$}", width = usize::from(CELL)), style));
        }
        put(&[Line::from(heading)], area, buf);
        let below =
            Rect { y: area.y.saturating_add(1), height: area.height.saturating_sub(1), ..area };
        for (y, (at, row)) in map.rows.iter().enumerate().skip(first_row).take(height).enumerate() {
            let here = Rect { y: below.y + y as u16, height: 1, ..below };
            let chosen = selected == Some(at);
            let mark = if chosen { ">" } else { " " };
            let width = usize::from(names.saturating_sub(2));
            let name = text::fit(&name(row.0, row.1), width);
            let mut spans = vec![Span::raw(format!("{mark}{name:<width$} "))];
            for (i, axis) in map.axes.iter().enumerate().skip(first_axis).take(fit) {
                let summary = summary_of(map, *row, axis);
                let here = chosen && i == column;
                let style = summary.kind.style(theme);
                let style = if here { style.patch(theme.selected()) } else { style };
                // Brackets mark the selected cell where nothing is reversed.
                let content = cell_text(&summary);
                let content = if here { format!("[{content}]") } else { format!(" {content} ") };
                let pad = usize::from(CELL).saturating_sub(text::width(&content));
                spans.push(Span::styled(content, style));
                spans.push(Span::raw(" ".repeat(pad)));
            }
            put(&[Line::from(spans)], here, buf);
        }
    }

    fn draw_points(
        &self,
        world: &World,
        head: &str,
        points: &[&StressLine],
        selected: Option<usize>,
        area: Rect,
        buf: &mut Buffer,
    ) {
        let theme = world.theme;
        let [heading, list, below] = Layout::vertical([
            Constraint::Length(1),
            Constraint::Max(points.len() as u16 + 1),
            Constraint::Min(area.height / 2),
        ])
        .areas(area);
        let failing = points.iter().filter(|p| !p.is_safe()).count();
        let what = match failing {
            0 => "all safe".into(),
            n => format!(
                "{} not safe; Enter makes the picture, Esc goes back",
                format::plural(n, "point")
            ),
        };
        Line::styled(text::fit(&format!("{head}: {what}"), area.width.into()), theme.title())
            .render(heading, buf);
        let columns = [
            Column::number("at", 10),
            Column::words("verdict", 9).fixed(),
            Column::number("error", 9),
            Column::number("limit", 9).rank(1),
            Column::words("reason", 10),
        ];
        table::draw(&columns, points.len(), selected, theme, list, buf, |at| {
            let point = points[at];
            let figure = |x: Option<f64>| x.map(format::significant).unwrap_or_default();
            vec![
                point.label.as_str().into(),
                Cell::styled(point.verdict.as_str(), verdict_style(point, theme)),
                figure(point.error).into(),
                figure(point.limit).into(),
                point.reason.as_str().into(),
            ]
        });
        let Some(point) = selected.and_then(|at| points.get(at)) else { return };
        let mut pairs = vec![pair("why", reason(point)), pair("command", &*point.command)];
        if self.image.works() {
            pairs.push(pair("picture", "is being made"));
        }
        if let Some(ended) = &self.image.ended {
            pairs.push(pair("picture", format!("! {ended}")).style(theme.bad()));
        }
        pairs.extend(self.image.said.iter().map(|said| pair("", &**said)));
        let words = pane::lines(&pairs, below.width, theme);
        let [facts, pictures] = Layout::vertical([
            Constraint::Length((words.len() as u16).min(below.height)),
            Constraint::Fill(1),
        ])
        .areas(below);
        put(&words, facts, buf);
        let Some(triplet) = &self.image.picture else { return };
        let parts = Layout::horizontal([Constraint::Fill(1); 3]).spacing(1).split(pictures);
        let faces =
            [("truth", &triplet.truth), ("result", &triplet.result), ("error", &triplet.error)];
        for (part, (title, picture)) in parts.iter().zip(faces) {
            let [title_row, inside] =
                Layout::vertical([Constraint::Length(1), Constraint::Fill(1)]).areas(*part);
            Line::styled(title, theme.dim()).render(title_row, buf);
            picture.draw(&world.picker, theme, inside, buf);
        }
    }
}

fn summary_of(map: &Map<'_>, row: (&str, &str), axis: &str) -> Summary {
    map::summary(&map.cell(row, axis))
}

fn name(technique: &str, variant: &str) -> String {
    if variant.is_empty() { technique.into() } else { format!("{technique}/{variant}") }
}

fn verdict_style(point: &StressLine, theme: Theme) -> Style {
    match point.verdict.as_str() {
        "not-run" => theme.dim(),
        _ if point.is_safe() => theme.good(),
        _ => theme.bad(),
    }
}

/// Why a point has its verdict, with its figures.
fn reason(point: &StressLine) -> String {
    let figures = match (point.error, point.limit) {
        // Most reasons name the figures themselves.
        (Some(error), _) if point.reason.contains(&format::significant(error)) => String::new(),
        (Some(error), Some(limit)) => format!(
            "{} {}, limit {}",
            point.metric,
            format::significant(error),
            format::significant(limit)
        ),
        (Some(error), None) => format!("{} {}", point.metric, format::significant(error)),
        _ => String::new(),
    };
    let duty = if point.must_refuse { "must be refused" } else { "" };
    let parts = [point.verdict.as_str(), duty, &figures, &point.reason];
    parts.into_iter().filter(|p| !p.is_empty()).collect::<Vec<_>>().join("; ")
}

/// The selected cell in words: the axis drawn, its safe intervals, what lies beyond their ends.
fn cell_lines(
    world: &World,
    name: &str,
    axis: &str,
    points: &[&StressLine],
    width: u16,
) -> Vec<Line<'static>> {
    let theme = world.theme;
    let declared = world.info().and_then(|i| i.extremes.iter().find(|e| e.0 == axis));
    let unit = declared.map(|e| e.1.clone()).unwrap_or_default();
    let unit = if unit.is_empty() { unit } else { format!(" [{unit}]") };
    let help = declared.map(|e| format!(": {}", e.2)).unwrap_or_default();
    let head = format!("{name} along {axis}{unit}{help}");
    let mut out = vec![Line::styled(text::fit(&head, width.into()), theme.title())];
    let run: Vec<_> = points.iter().copied().filter(|p| p.verdict != "not-run").collect();
    let (Some(first), Some(last)) = (run.first(), run.last()) else {
        let reasons: Vec<_> = points.first().iter().map(|p| p.reason.clone()).collect();
        let text = match points.is_empty() {
            true => "no points: not pushed along this axis yet, or it means nothing here".into(),
            false => format!("not run: {}", reasons.join("")),
        };
        out.extend(wrapped(&text, width, theme.dim()));
        return out;
    };
    let drawn = map::bar(&run, width.into());
    if drawn.is_empty() {
        // Words: each with its outcome.
        let words =
            run.iter().map(|p| format!("{} {}", if p.is_safe() { "✓" } else { "✗" }, p.label));
        out.extend(wrapped(&words.collect::<Vec<_>>().join("  "), width, Style::new()));
    } else {
        out.push(Line::styled(drawn, theme.good()));
        let gap =
            usize::from(width).saturating_sub(text::width(&first.label) + text::width(&last.label));
        let ends = format!("{}{}{}", first.label, " ".repeat(gap), last.label);
        out.push(Line::styled(ends, theme.dim()));
    }
    let set = safe_set(&run);
    if map::Scale::of(&run).is_some() {
        let intervals: Vec<_> = set.iter().map(map::interval).collect();
        let refined = if run.iter().any(|p| p.refined) { ", ends refined" } else { "" };
        let text = match intervals.len() {
            0 => "safe nowhere".into(),
            _ => format!("safe in {}{refined}", intervals.join(" and ")),
        };
        out.extend(wrapped(&text, width, Style::new()));
    }
    // The failures next to what is safe say most; they stand in the order of the axis.
    let bordering = |i: &usize| {
        let at = *i;
        let safe = |j: usize| run.get(j).is_some_and(|p| p.is_safe());
        !run[at].is_safe() && (set.is_empty() || (at > 0 && safe(at - 1)) || safe(at + 1))
    };
    for i in (0..run.len()).filter(bordering) {
        let text = format!("✗ at {}: {}", run[i].label, reason(run[i]));
        out.push(Line::styled(text::fit(&text, width.into()), theme.bad()));
    }
    out
}

fn wrapped(content: &str, width: u16, style: Style) -> Vec<Line<'static>> {
    let lines = text::wrap(content, width.into());
    lines.into_iter().map(|line| Line::styled(line, style)).collect()
}

fn put(lines: &[Line<'_>], area: Rect, buf: &mut Buffer) {
    for (line, y) in lines.iter().zip(area.y..area.bottom()) {
        line.render(Rect { y, height: 1, ..area }, buf);
    }
}
