//! How the screen `technique` is drawn.

use super::{State, told};
use crate::{
    plot::{curve::Curve, picture::Triplet},
    screens::World,
    widgets::{
        Cell, Column,
        format::{bytes, duration, plural, significant},
        pane::{self, Pair, pair},
        table, text,
    },
};
use ratatui::{
    buffer::Buffer,
    layout::{Constraint, Layout, Rect},
    text::{Line, Span},
    widgets::{Paragraph, Widget},
};

/// From this width on the documentation stands beside the rest.
const WIDE: u16 = 110;
/// A picture narrower than this shows too little: one at a time then.
const NARROWEST: u16 = 18;

impl State {
    /// Draws.
    pub fn view(&self, world: &World, area: Rect, buf: &mut Buffer) {
        let heading = self.heading(world, area.width);
        let [head, body] =
            Layout::vertical([Constraint::Length(heading.len() as u16), Constraint::Min(0)])
                .areas(area);
        Paragraph::new(heading).render(head, buf);
        if self.docs && area.width < WIDE {
            return pane::draw(&self.documentation(world), 0, world.theme, body, buf);
        }
        let main = if area.width >= WIDE {
            let [main, _, docs] = Layout::horizontal([
                Constraint::Percentage(66),
                Constraint::Length(2),
                Constraint::Min(0),
            ])
            .areas(body);
            pane::draw(&self.documentation(world), 0, world.theme, docs, buf);
            main
        } else {
            body
        };
        let pictures = world.info().is_some_and(|i| i.pictures);
        let high = if pictures { main.height * 9 / 20 } else { 0 };
        let [top, below] =
            Layout::vertical([Constraint::Length(high), Constraint::Min(0)]).areas(main);
        if pictures {
            self.pictures(world, top, buf);
        }
        let knobs = self.knobs(world).len() as u16 + 1;
        // Curves keep at least six lines: what a knob does is what is asked here.
        let list = knobs.min(below.height.saturating_sub(6)).max(3.min(below.height));
        if area.width >= WIDE {
            let [list, curves] =
                Layout::vertical([Constraint::Length(list), Constraint::Min(0)]).areas(below);
            self.knob_table(world, list, buf);
            self.curve_pair(world, curves, buf);
        } else {
            let [list, _, curves] = Layout::horizontal([
                Constraint::Percentage(50),
                Constraint::Length(1),
                Constraint::Min(0),
            ])
            .areas(below);
            self.knob_table(world, list, buf);
            self.curve_pair(world, curves, buf);
        }
    }

    fn heading(&self, world: &World, width: u16) -> Vec<Line<'static>> {
        let theme = world.theme;
        let title = self.info(world).map_or("", |i| i.title.as_str());
        let id = if world.technique.is_empty() { "no technique" } else { &world.technique };
        let mut lines = vec![Line::from(vec![
            Span::styled(id.to_string(), theme.title()),
            Span::raw(format!("  {title}")),
            Span::styled(if width < WIDE { "  PgDn: documentation" } else { "" }, theme.dim()),
        ])];
        let index = &world.store.index;
        let Some(entry) = self.selected().and_then(|at| index.entries.get(at)) else {
            let command = format!("dapple measure {} --technique {id}", world.problem);
            lines.push(Line::raw(format!("not recorded yet; {command}")));
            return lines;
        };
        let setting = index.setting(entry);
        let (case, place) = self.keys.get(self.key).cloned().unwrap_or_default();
        let of = if self.keys.len() > 1 {
            format!(" {}/{}", self.key + 1, self.keys.len())
        } else {
            String::new()
        };
        lines.push(Line::from(vec![
            Span::styled(format!("case{of} "), theme.dim()),
            Span::raw(format!("{} on {}", case.label(), place.label(world))),
        ]));
        let metric = self.metric(world);
        let error = index.error(entry, &metric).map_or("-".into(), significant);
        let variant = match setting.variant.as_str() {
            "" => String::new(),
            variant => format!("{variant} "),
        };
        let figures = format!(
            "{variant}({}): {} ± {}, {metric} {error}, {}",
            setting.form,
            duration(entry.median_ns),
            duration(entry.mad_ns),
            bytes(entry.memory_bytes),
        );
        lines.push(Line::from(vec![
            Span::styled(
                format!("setting {}/{} ◂▸ ", self.setting + 1, self.settings.len()),
                theme.dim(),
            ),
            Span::raw(figures),
        ]));
        if let Some(trouble) = &self.trouble {
            lines.push(Line::styled(text::fit(trouble, width.into()), theme.bad()));
        }
        lines
    }

    fn pictures(&self, world: &World, area: Rect, buf: &mut Buffer) {
        let theme = world.theme;
        match &self.pictures.shown {
            Some(Ok(triplet)) => self.triplet(triplet, world, area, buf),
            Some(Err(why)) => {
                let pairs = [pair("pictures", why.clone()).style(theme.bad())];
                pane::draw(&pairs, 0, theme, area, buf);
            }
            None => {
                let sentence = if self.pictures.busy() {
                    "rendering truth and result ..."
                } else {
                    "no pictures yet"
                };
                Line::styled(sentence, theme.dim()).render(area, buf);
            }
        }
    }

    fn triplet(&self, triplet: &Triplet, world: &World, area: Rect, buf: &mut Buffer) {
        let theme = world.theme;
        let faces = [
            ("truth", &triplet.truth),
            ("result", &triplet.result),
            ("error: orange (o) too light, blue (x) too dark", &triplet.error),
        ];
        let side = area.width / 3;
        let one = side < NARROWEST;
        for (i, (title, picture)) in faces.into_iter().enumerate() {
            if one && i != self.pictures.face {
                continue;
            }
            let x = area.x + if one { 0 } else { side * i as u16 };
            let width = if one { area.width } else { side.saturating_sub(1) };
            let place = Rect { x, width, ..area };
            let style = if i == self.pictures.face { theme.title() } else { theme.dim() };
            let title = text::fit(title, width.into());
            Line::styled(title, style).render(Rect { height: 1.min(area.height), ..place }, buf);
            let below = Rect {
                y: area.y + 1,
                height: area.height.saturating_sub(if self.pictures.note.is_empty() {
                    1
                } else {
                    2
                }),
                ..place
            };
            picture.draw(&world.picker, theme, below, buf);
        }
        if !self.pictures.note.is_empty() && area.height > 2 {
            let last = Rect { y: area.bottom() - 1, height: 1, ..area };
            let note = text::fit(&self.pictures.note, area.width.into());
            Line::styled(note, theme.dim()).render(last, buf);
        }
    }

    fn knob_table(&self, world: &World, area: Rect, buf: &mut Buffer) {
        let knobs = self.knobs(world);
        if knobs.is_empty() {
            return Line::styled("no knobs", world.theme.dim()).render(area, buf);
        }
        let row = self.row();
        let columns = [
            Column::words("knob", 10),
            Column::number("value", 8),
            Column::number("default", 8),
            Column::words("range", 12).rank(2),
            Column::words("accuracy", 8).fixed().rank(1),
        ];
        let selected = Some(self.knob.min(knobs.len() - 1));
        table::draw(&columns, knobs.len(), selected, world.theme, area, buf, |i| {
            let knob = &knobs[i];
            let value = row.and_then(|r| r.knobs.get(&knob.name));
            let set = value.map_or("-".into(), told);
            let default = if knob.default.is_null() { "-".into() } else { told(&knob.default) };
            let unit = if knob.unit.is_empty() { String::new() } else { format!(" {}", knob.unit) };
            vec![
                knob.name.clone().into(),
                // What was turned stands out.
                match set == default || set == "-" {
                    true => set.into(),
                    false => Cell::styled(set, world.theme.title()),
                },
                default.into(),
                format!("{}{unit}", knob.limit).into(),
                knob.accuracy.clone().into(),
            ]
        });
    }

    fn curve_pair(&self, world: &World, area: Rect, buf: &mut Buffer) {
        let theme = world.theme;
        let knobs = self.knobs(world);
        let Some(knob) = knobs.get(self.knob.min(knobs.len().saturating_sub(1))) else { return };
        let metric = self.metric(world);
        let [errors, times] = self.curves(knob, &metric);
        let mut about = format!("{}: {}", knob.name, knob.help);
        if self.left_out > 0 {
            about += &format!(" ({} more not read)", plural(self.left_out, "row"));
        }
        let help = text::wrap(&about, area.width.into());
        let lines = help.len().min(usize::from(area.height) / 3).max(1) as u16;
        let [head, rest] =
            Layout::vertical([Constraint::Length(lines), Constraint::Min(0)]).areas(area);
        let told: Vec<Line<'_>> = help.into_iter().map(|l| Line::styled(l, theme.dim())).collect();
        Paragraph::new(told).render(head, buf);
        if errors.len() < 2 {
            let command = format!(
                "one value recorded; for a curve: dapple measure {} --technique {} --knob {}=A,B,C",
                world.problem, world.technique, knob.name
            );
            return pane::draw(&[pair("", command)], 0, theme, rest, buf);
        }
        let [left, _, right] = Layout::horizontal([
            Constraint::Percentage(50),
            Constraint::Length(1),
            Constraint::Min(0),
        ])
        .areas(rest);
        let draw = |steps, title: &str, format, style, area, buf: &mut Buffer| {
            Curve { steps, title, format, style }.draw(theme, area, buf);
        };
        draw(&errors, &metric, significant, theme.bad(), left, buf);
        draw(&times, "median time", duration, theme.good(), right, buf);
    }

    /// Question, source, variants, metrics of the setting.
    fn documentation(&self, world: &World) -> Vec<Pair> {
        let mut pairs = Vec::new();
        if let Some(problem) = world.info() {
            pairs.push(pair("question", problem.question.clone()));
            pairs.push(pair("truth", problem.truth.clone()));
        }
        if let Some(info) = self.info(world) {
            pairs.push(pair("source", info.source.clone()));
            pairs.push(pair("forms", info.forms.join(", ")));
            let mut key = "variants";
            for (id, help) in &info.variants {
                pairs.push(pair(key, format!("{id}: {help}")));
                key = "";
            }
        }
        let Some(entry) = self.selected().and_then(|at| world.store.index.entries.get(at)) else {
            return pairs;
        };
        pairs.push(Pair::default());
        let chosen = self.metric(world);
        for metric in self.metrics(world) {
            let value = world.store.index.error(entry, &metric).map_or("-".into(), significant);
            let declared = world.info().and_then(|i| i.metrics.iter().find(|m| m.0 == metric));
            let (unit, help) = declared.map_or(("", ""), |m| (m.1.as_str(), m.2.as_str()));
            let style = if metric == chosen { world.theme.title() } else { Default::default() };
            let value = format!("{value} {unit}");
            let value = format!("{}  {help}", value.trim_end());
            pairs.push(pair(metric, value.trim_end()).style(style));
        }
        if let Some(row) = self.row() {
            let counters: Vec<String> =
                row.counters.iter().map(|(name, n)| format!("{name} {n}")).collect();
            pairs.push(pair("counters", counters.join("  ")));
        }
        pairs.retain(|p| !p.value.is_empty() || p.key.is_empty());
        pairs
    }
}
