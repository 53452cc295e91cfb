//! Drawing of the live screen: what can be turned on the left; picture, errors and times beside.

use super::{
    Answer, Face, State,
    choice::{self, Row},
};
use crate::{
    plot::picture::{Picture, Triplet},
    screens::World,
    theme::Theme,
    widgets::{Cell, Column, format, table, text},
};
use dapple_records::catalogue::ProblemInfo;
use ratatui::{
    buffer::Buffer,
    layout::{Constraint, Layout, Rect},
    style::Style,
    text::{Line, Span},
    widgets::Widget,
};

/// Columns of the list of what can be turned.
const LIST: u16 = 30;

/// Rows that a picture gets at least before figures take the rest.
const LEAST_PICTURE: u16 = 9;

/// Changes of less than this share are none.
const NOTABLE: f64 = 0.005;

/// Waits shorter than this are not worth a word, milliseconds.
const PATIENCE_MS: i64 = 500;

impl State {
    /// Draws.
    pub fn view(&self, world: &World, area: Rect, buf: &mut Buffer) {
        let theme = world.theme;
        let Some(info) = world.info() else {
            let why = world.catalogue_trouble.clone();
            let why = why.map(|why| format!("the program did not say what there is: {why}"));
            let text = why.unwrap_or_else(|| "waiting for what the program declares".into());
            return lines(&plain_lines(&text, area.width, theme.dim()), area, buf);
        };
        let list = LIST.min(area.width / 2);
        let [left, _, right] = Layout::horizontal([
            Constraint::Length(list),
            Constraint::Length(1),
            Constraint::Fill(1),
        ])
        .areas(area);
        self.draw_list(world, info, left, buf);
        let figures = self.figures(world, info, right.width);
        if !info.pictures {
            return lines(&figures, right, buf);
        }
        // Pictures keep their shape: what they leave over is for figures.
        let wanted = (figures.len() as u16).min(right.height / 2);
        let most = right.height.saturating_sub(wanted).max(LEAST_PICTURE).min(right.height);
        let [pictures, below] =
            Layout::vertical([Constraint::Length(most), Constraint::Fill(1)]).areas(right);
        let used = self.draw_pictures(world, pictures, buf);
        let spare = pictures.height.saturating_sub(used);
        let below = Rect { y: below.y - spare, height: below.height + spare, ..below };
        lines(&figures, below, buf);
    }

    fn draw_list(&self, world: &World, info: &ProblemInfo, area: Rect, buf: &mut Buffer) {
        let theme = world.theme;
        let rows = self.choice.rows(info);
        let selected = self.cursor.at(rows.len());
        let help: Vec<_> = selected
            .and_then(|at| rows.get(at))
            .map(|row| plain_lines(&self.choice.help(info, row), area.width, theme.dim()))
            .unwrap_or_default();
        // The help of the selected row stands below, where there is room for it.
        let free = area.height.saturating_sub(rows.len() as u16 + 2);
        let help: Vec<_> = help.into_iter().take(free.into()).collect();
        let [list, below] =
            Layout::vertical([Constraint::Fill(1), Constraint::Length(help.len() as u16)])
                .areas(area);
        let columns = [Column::words("turn ←→", 10), Column::words("value", 8)];
        table::draw(&columns, rows.len(), selected, theme, list, buf, |at| {
            let Some(row) = rows.get(at) else { return Vec::new() };
            let (name, value, turned) = self.choice.text(info, row);
            let style = if turned { theme.title() } else { Style::new() };
            // A star for what is not at its default, as colour alone would not do.
            let mark = if turned { "*" } else { "" };
            let name = match row {
                Row::Parameter(_) | Row::Scene => format!("case {name}"),
                _ => name,
            };
            vec![Cell::from(name), Cell::styled(format!("{value}{mark}"), style)]
        });
        lines(&help, below, buf);
    }

    /// Draws one picture, or result and error map where both fit. Returns the rows taken.
    fn draw_pictures(&self, world: &World, area: Rect, buf: &mut Buffer) -> u16 {
        let theme = world.theme;
        let Some(triplet) = &self.picture else {
            let text = if self.trouble.is_some() { "" } else { "the picture is on its way" };
            Line::styled(text, theme.dim()).render(area, buf);
            return area.height.min(1);
        };
        let waits = self.asked.as_ref().is_some_and(|a| !a.answered);
        let faces = match self.face {
            Face::Error => [Face::Error, Face::Result],
            face => [face, Face::Error],
        };
        let parts = arrange(area);
        let mut bottom = area.y;
        for (part, face) in parts.iter().copied().zip(faces) {
            let [title, inside] =
                Layout::vertical([Constraint::Length(1), Constraint::Fill(1)]).areas(part);
            // Here rather than on a line of its own, which would move all others.
            let late = self.waiting(world).filter(|_| part == parts[0]);
            let note = match late {
                Some(late) => format!(" {late}"),
                None if waits => " (before the change)".into(),
                None => String::new(),
            };
            let style = if waits { theme.dim() } else { theme.title() };
            Line::styled(format!("{}{note}", face.title()), style).render(title, buf);
            let drawn = face.of(triplet).draw(&world.picker, theme, inside, buf);
            bottom = bottom.max(drawn.bottom());
        }
        bottom.saturating_sub(area.y)
    }

    /// Everything that is said in words, the most important first.
    fn figures(&self, world: &World, info: &ProblemInfo, width: u16) -> Vec<Line<'static>> {
        let theme = world.theme;
        let mut out = Vec::new();
        if let Some(trouble) = &self.trouble {
            out.extend(plain_lines(&format!("! {trouble}"), width, theme.bad()));
            if self.child.is_none() {
                out.push(Line::styled("Enter starts it again", theme.bad()));
            }
        }
        // Beside a picture, its title says so.
        let waiting = self.waiting(world).filter(|_| self.picture.is_none());
        out.extend(waiting.map(|text| Line::styled(text, theme.dim())));
        if let Some(answer) = &self.answer {
            for violation in &answer.violations {
                out.extend(plain_lines(&format!("! broken: {violation}"), width, theme.bad()));
            }
            out.extend(self.time_lines(world, width));
            out.extend(self.error_lines(info, answer, theme, width));
        }
        if let Some(asked) = &self.asked {
            let technique = self.choice.info(info);
            let default = technique.and_then(|t| t.variants.first()).map(|v| v.0.as_str());
            let command = choice::command(&asked.show, default.unwrap_or_default());
            out.extend(plain_lines(&command, width, theme.dim()));
        }
        if let Some(answer) = &self.answer {
            let memory = format!("memory {}", format::bytes(answer.memory_bytes));
            let counters = answer.counters.iter();
            let counters =
                counters.map(|(name, n)| format!(", {name} {}", format::count(*n as usize)));
            out.extend(plain_lines(&(memory + &counters.collect::<String>()), width, Style::new()));
            out.extend(plain_lines(&format!("truth: {}", self.truth), width, theme.dim()));
        }
        out
    }

    /// What the child is at, where that takes long enough to be asked.
    fn waiting(&self, world: &World) -> Option<String> {
        let asked = self.asked.as_ref().filter(|a| !a.answered)?;
        let ms = world.now_ms.saturating_sub(asked.at_ms);
        let what = match self.stage.as_str() {
            "prepare" => "preparing scene and truth",
            "check" => "checking against truth",
            _ => "starting",
        };
        (ms >= PATIENCE_MS || self.answer.is_none())
            .then(|| format!("… {what}, {} s", ms.max(0) / 1000))
    }

    fn time_lines(&self, world: &World, width: u16) -> Vec<Line<'static>> {
        let theme = world.theme;
        let shown = self.answer.as_ref().map(|a| a.show.form.clone()).unwrap_or_default();
        let device = device(world, &shown);
        let mut out = Vec::new();
        if let (Some(p50), Some(p99)) = (self.times.quantile(0.5), self.times.quantile(0.99)) {
            let time = |ns: u64| format::duration(ns as f64);
            let software = if shown == "gpu" && device.1 { ", software adapter" } else { "" };
            out.push(Line::from(vec![
                Span::styled(format!("frame {}", time(p50)), theme.title()),
                Span::raw(format!(
                    " p50, {} p99 ({} clock{software})",
                    time(p99),
                    self.times.clock
                )),
            ]));
            let count = format!(" {} frames", self.times.count());
            let columns = usize::from(width).saturating_sub(text::width(&count));
            out.push(Line::from(vec![
                Span::styled(self.times.sparkline(columns), theme.good()),
                Span::styled(count, theme.dim()),
            ]));
        } else if shown == "reference" {
            out.push(Line::styled(
                "frame: the reference is an oracle and is not timed",
                theme.dim(),
            ));
        }
        out.push(Line::styled(format!("device: {}", device.0), theme.dim()));
        out
    }

    /// Errors with their change against the setting before, the chosen metric first, as many on a
    /// line as fit.
    fn error_lines(
        &self,
        info: &ProblemInfo,
        answer: &Answer,
        theme: Theme,
        width: u16,
    ) -> Vec<Line<'static>> {
        let declared: Vec<&str> = info
            .metrics
            .iter()
            .map(|m| m.0.as_str())
            .filter(|m| answer.errors.contains_key(*m))
            .collect();
        let axis = declared.iter().position(|m| *m == info.axis).unwrap_or_default();
        let first = (axis + self.metric) % declared.len().max(1);
        let order = declared.iter().cycle().skip(first).take(declared.len());
        let mut out: Vec<Line<'static>> = Vec::new();
        let mut line: Vec<Span<'static>> = Vec::new();
        let mut used = 0;
        for (i, metric) in order.enumerate() {
            let Some(value) = answer.errors.get(*metric) else { continue };
            let old = self.before.as_ref().and_then(|b| b.errors.get(*metric));
            let (change, style) = change(*value, old.copied(), theme);
            let name = if i == 0 { theme.title() } else { Style::new() };
            let figure = format!("{metric} {}", format::significant(*value));
            let wide = text::width(&figure) + text::width(&change) + 1;
            if used > 0 && used + 2 + wide > usize::from(width) {
                out.push(Line::from(std::mem::take(&mut line)));
                used = 0;
            }
            if used > 0 {
                line.push(Span::raw("  "));
                used += 2;
            }
            line.push(Span::styled(figure, name));
            line.push(Span::styled(format!(" {change}"), style));
            used += wide;
        }
        out.push(Line::from(line));
        if let Some(before) = &self.before {
            let since = choice::difference(&before.show, &answer.show);
            if !since.is_empty() {
                out.extend(plain_lines(&format!("change: {since}"), width, theme.dim()));
            }
        }
        out
    }
}

impl Face {
    fn title(self) -> &'static str {
        match self {
            Self::Result => "result",
            Self::Truth => "truth",
            Self::Error => "error: orange o too light, blue x too dark",
        }
    }

    fn of(self, triplet: &Triplet) -> &Picture {
        match self {
            Self::Result => &triplet.result,
            Self::Truth => &triplet.truth,
            Self::Error => &triplet.error,
        }
    }
}

/// A change in words and its style: less error is good. Arrows tell what colour would.
fn change(new: f64, old: Option<f64>, theme: Theme) -> (String, Style) {
    let Some(old) = old else { return (String::new(), Style::new()) };
    if new == old || (old != 0.0 && (new / old - 1.0).abs() < NOTABLE) {
        return ("=".into(), theme.dim());
    }
    let (arrow, style) = if new > old { ("▲", theme.bad()) } else { ("▼", theme.good()) };
    if old == 0.0 {
        return (format!("{arrow}from 0"), style);
    }
    let ratio = new / old;
    let text = match ratio {
        r if r >= 10.0 => format!("{arrow}x{}", format::count(r.min(1e9) as usize)),
        r => format!("{arrow}{:+.0}%", 100.0 * (r - 1.0)),
    };
    (text, style)
}

/// The device of a form, and whether it is the processor playing an adapter.
fn device(world: &World, form: &str) -> (String, bool) {
    let Some(catalogue) = &world.catalogue else { return ("?".into(), false) };
    let software = catalogue.device == "software";
    match form {
        "gpu" => {
            let mark = if software { " (software)" } else { "" };
            (format!("{}{mark}", catalogue.adapter), software)
        }
        _ => (catalogue.cpu.clone(), false),
    }
}

/// One part of the area, or two: side by side or one below the other, whichever shows larger
/// pictures; two only where each is still of use.
fn arrange(area: Rect) -> Vec<Rect> {
    /// Least columns of a picture that is shown beside another.
    const LEAST: u16 = 30;
    // A cell is about twice as high as wide, a picture 16:9, and a title takes a row.
    let columns = |width: u16, height: u16| {
        width.min((u32::from(height.saturating_sub(1)) * 32 / 9).min(u32::from(u16::MAX)) as u16)
    };
    let beside = columns(area.width.saturating_sub(1) / 2, area.height);
    let below = columns(area.width, area.height / 2);
    if beside.max(below) < LEAST {
        return vec![area];
    }
    let half = |constraints| Layout::default().constraints(constraints);
    let halves = [Constraint::Fill(1), Constraint::Fill(1)];
    if beside >= below {
        half(halves)
            .direction(ratatui::layout::Direction::Horizontal)
            .spacing(1)
            .split(area)
            .to_vec()
    } else {
        half(halves).split(area).to_vec()
    }
}

fn plain_lines(content: &str, width: u16, style: Style) -> Vec<Line<'static>> {
    let wrapped = text::wrap(content, width.into());
    wrapped.into_iter().map(|line| Line::styled(line, style)).collect()
}

fn lines(lines: &[Line<'static>], area: Rect, buf: &mut Buffer) {
    for (line, y) in lines.iter().zip(area.y..area.bottom()) {
        line.render(Rect { y, height: 1, ..area }, buf);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_say_better_or_worse_without_colour() {
        let theme = Theme { colour: false };
        for (new, old, text) in [
            (0.02, Some(0.01), "▲+100%"),
            (0.005, Some(0.01), "▼-50%"),
            (0.01, Some(0.01), "="),
            (0.010_01, Some(0.01), "="),
            (0.0, Some(0.0), "="),
            (0.1, Some(0.0), "▲from 0"),
            (0.0, Some(0.1), "▼-100%"),
            (0.5, Some(0.01), "▲x50"),
            (0.5, None, ""),
        ] {
            assert_eq!(change(new, old, theme).0, text, "{new} {old:?}");
        }
    }

    #[test]
    fn two_pictures_are_shown_where_both_are_of_use() {
        let parts = |w, h| arrange(Rect::new(0, 0, w, h)).len();
        assert_eq!(parts(49, 14), 1);
        assert_eq!(parts(84, 30), 2);
        assert_eq!(parts(120, 14), 2);
        assert_eq!(parts(0, 0), 1);
        for (w, h) in [(84, 30), (120, 14), (300, 10)] {
            let parts = arrange(Rect::new(3, 5, w, h));
            assert!(parts.iter().all(|p| Rect::new(3, 5, w, h).union(*p) == Rect::new(3, 5, w, h)));
            assert!(!parts[0].intersects(parts[1]));
        }
    }
}
