//! How the screen `front` is drawn.

use super::{State, letter};
use crate::{
    plot::scatter::{Mark, Scatter},
    screens::World,
    widgets::{
        Cell, Column,
        format::{bytes, count, duration, plural, significant},
        pane::{self, Pair, pair},
        table, text,
    },
};
use dapple_records::{Row, front::Point};
use ratatui::{
    buffer::Buffer,
    layout::{Constraint, Layout, Rect},
    text::{Line, Span},
    widgets::{Paragraph, Widget},
};

/// From this width on the table stands beside the plot.
const WIDE: u16 = 110;

impl State {
    /// Draws.
    pub fn view(&self, world: &World, area: Rect, buf: &mut Buffer) {
        if self.model.cases.is_empty() {
            return nothing(world, area, buf);
        }
        let heading = self.heading(world, area.width);
        let [head, body] =
            Layout::vertical([Constraint::Length(heading.len() as u16), Constraint::Min(0)])
                .areas(area);
        Paragraph::new(heading).render(head, buf);
        let details = self.details(world);
        if area.width >= WIDE {
            let [left, _, right] = Layout::horizontal([
                Constraint::Percentage(54),
                Constraint::Length(1),
                Constraint::Min(0),
            ])
            .areas(body);
            let lines = pane::lines(&details, left.width, world.theme).len() as u16;
            let below = lines.min(left.height / 2);
            let [plot, _, detail] = Layout::vertical([
                Constraint::Min(0),
                Constraint::Length(1),
                Constraint::Length(below),
            ])
            .areas(left);
            self.plot(world, plot, buf);
            pane::draw(&details, 0, world.theme, detail, buf);
            self.table(world, right, buf);
        } else {
            // The plot is what cannot be told in words: it keeps most of the room.
            let [plot, list, detail] = Layout::vertical([
                Constraint::Percentage(48),
                Constraint::Min(3),
                Constraint::Length(if body.height >= 18 { 4 } else { 0 }),
            ])
            .areas(body);
            self.plot(world, plot, buf);
            self.table(world, list, buf);
            pane::draw(&details, 0, world.theme, detail, buf);
        }
    }

    fn heading(&self, world: &World, width: u16) -> Vec<Line<'static>> {
        let (theme, model) = (world.theme, &self.model);
        let of = |at: usize, list: usize| {
            if list > 1 { format!(" {}/{list}", at + 1) } else { String::new() }
        };
        let on_front = model.points.iter().filter(|p| p.on_front).count();
        let facts = format!(" {}, {on_front} on the front", plural(model.points.len(), "setting"));
        let title = format!("{}: {} against time.", world.problem, model.metric);
        let mut left_out = String::new();
        if !model.left_out.is_empty() {
            let reasons: Vec<String> =
                model.left_out.iter().map(|(why, n)| format!("{} {why}", count(*n))).collect();
            left_out = format!("; left out: {}", reasons.join(", "));
        }
        let room = usize::from(width).saturating_sub(text::width(&title) + text::width(&facts));
        let mut lines = vec![Line::from(vec![
            Span::styled(title, theme.title()),
            Span::raw(facts),
            Span::raw(text::fit(&left_out, room)),
        ])];
        let case = model.cases.get(model.case).cloned().unwrap_or_default();
        let place = model.places.get(model.place).cloned().unwrap_or_default();
        let software = place.device == "software";
        let style = if software { theme.bad() } else { ratatui::style::Style::new() };
        lines.push(Line::from(vec![
            Span::styled(format!("case{} ", of(model.case, model.cases.len())), theme.dim()),
            Span::raw(case.label()),
            Span::styled(format!("   on{} ", of(model.place, model.places.len())), theme.dim()),
            Span::styled(place.label(world), style),
        ]));
        let told = text::wrap(&format!("truth {}", case.truth), width.into());
        lines.extend(told.into_iter().take(2).map(|line| Line::styled(line, theme.dim())));
        lines
    }

    fn plot(&self, world: &World, area: Rect, buf: &mut Buffer) {
        let index = &world.store.index;
        let marks: Vec<Mark> = self
            .listed
            .iter()
            .map(|&at| {
                let point = &self.model.points[at];
                let series = self.model.series_of(index.setting(&index.entries[point.index]));
                Mark {
                    x: point.time_ns,
                    y: point.error,
                    letter: letter(series),
                    style: world.theme.series(series),
                    on_front: point.on_front,
                }
            })
            .collect();
        let unit = world.info().and_then(|info| {
            info.metrics.iter().find(|(name, ..)| *name == self.model.metric).map(|m| m.1.clone())
        });
        let y_title = match unit.filter(|u| !u.is_empty()) {
            Some(unit) => format!("{} ({unit})", self.model.metric),
            None => self.model.metric.clone(),
        };
        let selected = self.cursor.at(self.listed.len());
        let x_title =
            if self.model.gpu_clock { "median time, gpu clock" } else { "median time, wall clock" };
        Scatter { marks: &marks, selected, x_title, y_title: &y_title }.draw(
            world.theme,
            area,
            buf,
        );
    }

    fn table(&self, world: &World, area: Rect, buf: &mut Buffer) {
        let columns = [
            Column::words("setting", 14),
            Column::words("form", 4).fixed().rank(4),
            Column::number("time", 8),
            Column::number("spread", 6).rank(2),
            Column::number(&self.model.metric, 9),
            Column::number("p99", 8).rank(5),
            Column::number("memory", 9).rank(6),
            Column::words("", 8).fixed().rank(1),
        ];
        let selected = self.cursor.at(self.listed.len());
        table::draw(&columns, self.listed.len(), selected, world.theme, area, buf, |i| {
            self.cells(world, &self.model.points[self.listed[i]])
        });
    }

    fn cells(&self, world: &World, point: &Point) -> Vec<Cell> {
        let (index, theme) = (&world.store.index, world.theme);
        let entry = &index.entries[point.index];
        let setting = index.setting(entry);
        let series = self.model.series_of(setting);
        let standing = match point.dominated_by.and_then(|at| self.model.points.get(at)) {
            None => Cell::styled("on front", theme.good()),
            Some(by) => {
                let by = index.setting(&index.entries[by.index]);
                format!("under {}", letter(self.model.series_of(by))).into()
            }
        };
        vec![
            Cell::styled(format!("{} {}", letter(series), name(setting)), theme.series(series)),
            setting.form.clone().into(),
            duration(point.time_ns).into(),
            spread(point.mad_ns, point.time_ns).into(),
            significant(point.error).into(),
            duration(f64::from(entry.p99_ns)).into(),
            bytes(entry.memory_bytes).into(),
            standing,
        ]
    }

    /// The selected setting in full.
    fn details(&self, world: &World) -> Vec<Pair> {
        let Some(point) = self.point() else {
            return vec![pair("", "no setting was timed and checked by this metric and clock")];
        };
        let index = &world.store.index;
        let entry = &index.entries[point.index];
        let setting = index.setting(entry);
        let mut pairs = vec![
            pair(
                format!("{}", letter(self.model.series_of(setting))),
                format!(
                    "{} ({}): {} ± {}, p99 {}, {} {}",
                    name(setting),
                    setting.form,
                    duration(point.time_ns),
                    duration(point.mad_ns),
                    duration(f64::from(entry.p99_ns)),
                    self.model.metric,
                    significant(point.error),
                ),
            )
            .style(world.theme.title()),
        ];
        if let Some(by) = point.dominated_by.and_then(|at| self.model.points.get(at)) {
            let winner = index.setting(&index.entries[by.index]);
            pairs.push(pair(
                "under",
                format!(
                    "{} {}: {}, {} {}",
                    letter(self.model.series_of(winner)),
                    name(winner),
                    duration(by.time_ns),
                    self.model.metric,
                    significant(by.error)
                ),
            ));
        }
        match self.row() {
            None => pairs.push(pair("", "reading the record ...")),
            Some(Err(why)) => pairs.push(pair("record", why.clone()).style(world.theme.bad())),
            Some(Ok(row)) => pairs.extend(told(row)),
        }
        pairs
    }
}

/// Technique and variant.
fn name(setting: &dapple_records::index::SettingName) -> String {
    if setting.variant.is_empty() {
        return setting.technique.clone();
    }
    format!("{}/{}", setting.technique, setting.variant)
}

/// A spread in percent of the time.
fn spread(mad_ns: f64, time_ns: f64) -> String {
    if time_ns > 0.0 { format!("±{:.0} %", mad_ns / time_ns * 100.0) } else { "?".into() }
}

/// What only the whole row has.
fn told(row: &Row) -> Vec<Pair> {
    let list = |items: Vec<String>| items.join("  ");
    let knobs = row.knobs.iter().map(|(name, value)| {
        // Text without the quotes of JSON.
        let value = value.as_str().map_or_else(|| value.to_string(), str::to_string);
        format!("{name}={value}")
    });
    let errors = row.errors.iter().map(|(name, value)| format!("{name} {}", significant(*value)));
    let passes = row.passes_ns.iter().map(|(name, ns)| format!("{name} {}", duration(*ns as f64)));
    let counters = row.counters.iter().map(|(name, n)| format!("{name} {}", count(*n as usize)));
    let times: Vec<f64> = row.samples_ns.iter().flatten().map(|ns| *ns as f64).collect();
    let least = times.iter().copied().fold(f64::INFINITY, f64::min);
    let most = times.iter().copied().fold(0.0, f64::max);
    let mut pairs = vec![pair("knobs", list(knobs.collect()))];
    if !times.is_empty() {
        let what = plural(row.samples_ns.len(), "repeat");
        let samples = format!("{what}, {} to {}", duration(least), duration(most));
        let ratio = row.ratio.filter(|_| !row.baseline.is_empty());
        let ratio = ratio.map(|r| format!("; x{} of {}", significant(r), row.baseline));
        pairs.push(pair("samples", samples + &ratio.unwrap_or_default()));
    }
    pairs.push(pair("errors", list(errors.collect())));
    pairs.push(pair("passes", list(passes.collect())));
    pairs.push(pair("counters", list(counters.collect())));
    let dirty = if row.dirty { " with changes" } else { "" };
    pairs.push(pair("from", format!("{}, revision {}{dirty}", row.time, row.revision)));
    pairs.retain(|p| !p.value.is_empty());
    pairs
}

/// What to do when there is nothing to draw.
fn nothing(world: &World, area: Rect, buf: &mut Buffer) {
    let mut pairs = Vec::new();
    if let Some(trouble) = &world.store.trouble {
        pairs.push(pair("", trouble.clone()).style(world.theme.bad()));
    }
    if world.problem.is_empty() {
        pairs.push(pair("", "no problem is known yet"));
    } else {
        pairs.push(pair("", format!("{}: no records yet", world.problem)));
        pairs.push(pair("", format!("make some: dapple measure {}", world.problem)));
        pairs.push(pair("", "or press 8, then n"));
    }
    pane::draw(&pairs, 0, world.theme, area, buf);
}
