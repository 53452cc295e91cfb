//! Points on two logarithmic axes, less being better on both, with the front as a step line.

use super::axis::{LogAxis, Tick};
use crate::{theme::Theme, widgets::text};
use ratatui::{
    buffer::Buffer,
    layout::Rect,
    style::{Modifier, Style},
};

/// One point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Along the lower edge; positive.
    pub x: f64,
    /// Upwards; 0 has a band of its own at the bottom.
    pub y: f64,
    /// What it is drawn as.
    pub letter: char,
    /// Its colour.
    pub style: Style,
    /// Whether the line goes through it.
    pub on_front: bool,
}

/// The points and what stands at the axes.
#[derive(Clone, Copy, Debug)]
pub struct Scatter<'a> {
    /// In the order of `x`, as fronts are.
    pub marks: &'a [Mark],
    /// Which of the marks is selected.
    pub selected: Option<usize>,
    /// What `x` is, for the right end of the top line; its values are nanoseconds.
    pub x_title: &'a str,
    /// What `y` is, for the left end.
    pub y_title: &'a str,
}

/// Where points fall.
struct Frame {
    /// The points' cells.
    plot: Rect,
    x: LogAxis,
    /// None if every error is 0.
    y: Option<LogAxis>,
    /// The row of error 0, if any point has it.
    zero: Option<u16>,
}

impl Frame {
    fn cell(&self, mark: &Mark) -> Option<(u16, u16)> {
        let x = self.plot.x + self.x.at(mark.x, self.plot.width)?;
        if mark.y == 0.0 {
            return self.zero.map(|y| (x, y));
        }
        let up = self.y?.at(mark.y, self.plot.height)?;
        Some((x, self.plot.bottom() - 1 - up))
    }

    /// The lowest row of the plot, the band of 0 included.
    fn bottom(&self) -> u16 {
        self.zero.unwrap_or_else(|| self.plot.bottom().saturating_sub(1))
    }
}

impl Scatter<'_> {
    /// Draws into any area; what is too small shows a sentence instead.
    pub fn draw(&self, theme: Theme, area: Rect, buf: &mut Buffer) {
        let area = area.intersection(buf.area);
        if area.is_empty() {
            return;
        }
        let Some(frame) = self.frame(area) else {
            let sentence = if self.marks.is_empty() { "no points" } else { "too small to draw" };
            buf.set_stringn(area.x, area.y, sentence, area.width.into(), theme.dim());
            return;
        };
        self.axes(&frame, theme, area, buf);
        self.line(&frame, theme, buf);
        self.points(&frame, theme, buf);
    }

    fn frame(&self, area: Rect) -> Option<Frame> {
        let x = LogAxis::over(self.marks.iter().map(|m| m.x))?;
        let y = LogAxis::over(self.marks.iter().map(|m| m.y));
        let zero = self.marks.iter().any(|m| m.y == 0.0);
        let left = self.labels(y, zero).iter().map(|l| text::width(l)).max()? as u16 + 1;
        // A title above, the axis and its labels below.
        let band = if zero { 2 } else { 0 };
        let plot = Rect {
            x: area.x + left,
            y: area.y + 1,
            width: area.width.checked_sub(left)?,
            height: area.height.checked_sub(3 + band)?,
        };
        let seen = plot.width >= 8 && plot.height >= 3;
        seen.then(|| Frame { plot, x, y, zero: zero.then(|| plot.bottom() + 1) })
    }

    /// All labels that the left axis might have: its width must not depend on its height.
    fn labels(&self, y: Option<LogAxis>, zero: bool) -> Vec<String> {
        let mut labels: Vec<String> =
            y.map_or(Vec::new(), |y| y.ticks(12).into_iter().map(Tick::plain).collect());
        if zero || labels.is_empty() {
            labels.push("0".into());
        }
        labels
    }

    fn axes(&self, frame: &Frame, theme: Theme, area: Rect, buf: &mut Buffer) {
        let (plot, dim) = (frame.plot, theme.dim());
        buf.set_stringn(area.x, area.y, self.y_title, area.width.into(), dim);
        let end = text::width(self.x_title) as u16;
        if text::width(self.y_title) as u16 + end + 2 <= area.width {
            buf.set_string(area.right() - end, area.y, self.x_title, dim);
        }
        let edge = plot.x - 1;
        let floor = frame.bottom() + 1;
        for y in plot.y..floor {
            buf.set_string(edge, y, "│", dim);
        }
        buf.set_string(edge, floor, "└", dim);
        for x in plot.x..plot.right() {
            buf.set_string(x, floor, "─", dim);
        }
        let label = |buf: &mut Buffer, y: u16, content: &str| {
            let room = usize::from(edge - area.x);
            let label = text::fit(content, room);
            let x = edge.saturating_sub(text::width(&label) as u16);
            buf.set_string(x, y, label, dim);
            buf.set_string(edge, y, "┤", dim);
        };
        if let Some(axis) = frame.y {
            for tick in axis.ticks((usize::from(plot.height) / 2).clamp(1, 12)) {
                if let Some(up) = axis.at(tick.value(), plot.height) {
                    label(buf, plot.bottom() - 1 - up, &tick.plain());
                }
            }
        }
        if let Some(zero) = frame.zero {
            for x in plot.x..plot.right() {
                buf.set_string(x, zero - 1, "╌", dim);
            }
            label(buf, zero, "0");
        }
        self.x_labels(frame, floor, theme, buf);
    }

    fn x_labels(&self, frame: &Frame, floor: u16, theme: Theme, buf: &mut Buffer) {
        let plot = frame.plot;
        let mut free = plot.x.saturating_sub(2);
        for tick in frame.x.ticks((usize::from(plot.width) / 9).clamp(1, 12)) {
            let Some(at) = frame.x.at(tick.value(), plot.width) else { continue };
            let label = tick.duration();
            let width = text::width(&label) as u16;
            let x = plot.x + at;
            let begin =
                x.saturating_sub(width / 2).min(plot.right().saturating_sub(width)).max(free);
            buf.set_string(x, floor, "┴", theme.dim());
            if begin + width <= plot.right() {
                buf.set_string(begin, floor + 1, &label, theme.dim());
                free = begin + width + 1;
            }
        }
    }

    /// What is attainable: from each point of the front level to the right, then down to the next.
    fn line(&self, frame: &Frame, theme: Theme, buf: &mut Buffer) {
        let style = theme.good();
        let mut before: Option<(u16, u16)> = None;
        let front = self.marks.iter().filter(|m| m.on_front).filter_map(|m| frame.cell(m));
        for (x, y) in front {
            match before {
                None => {
                    for above in frame.plot.y..y {
                        buf.set_string(x, above, "│", style);
                    }
                }
                Some((from, level)) => {
                    for x in from + 1..x {
                        buf.set_string(x, level, "─", style);
                    }
                    if level < y && from < x {
                        buf.set_string(x, level, "┐", style);
                    }
                    for down in level + 1..y {
                        buf.set_string(x, down, "│", style);
                    }
                }
            }
            before = Some((x, y));
        }
        if let Some((from, level)) = before {
            for x in from + 1..frame.plot.right() {
                buf.set_string(x, level, "─", style);
            }
        }
    }

    fn points(&self, frame: &Frame, theme: Theme, buf: &mut Buffer) {
        // What matters most is drawn last: the others, the front, the selected one.
        for front in [false, true] {
            for mark in self.marks.iter().filter(|m| m.on_front == front) {
                if let Some((x, y)) = frame.cell(mark) {
                    let bold = if front { Modifier::BOLD } else { Modifier::empty() };
                    put(buf, x, y, mark.letter, mark.style.add_modifier(bold));
                }
            }
        }
        let selected = self.selected.and_then(|i| self.marks.get(i));
        if let Some((mark, (x, y))) = selected.and_then(|m| Some((m, frame.cell(m)?))) {
            put(buf, x, y, mark.letter, theme.selected().add_modifier(Modifier::BOLD));
            // Brackets say it without a style too.
            if x > frame.plot.x {
                put(buf, x - 1, y, '[', theme.title());
            }
            if x + 1 < frame.plot.right() {
                put(buf, x + 1, y, ']', theme.title());
            }
        }
    }
}

fn put(buf: &mut Buffer, x: u16, y: u16, symbol: char, style: Style) {
    if let Some(cell) = buf.cell_mut((x, y)) {
        cell.reset();
        cell.set_char(symbol).set_style(style);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{drawn, has_colour, sizes, text_of};

    const PLAIN: Theme = Theme { colour: false };

    fn mark(x: f64, y: f64, letter: char, on_front: bool) -> Mark {
        Mark { x, y, letter, style: PLAIN.series(0), on_front }
    }

    fn of(marks: &[Mark], selected: Option<usize>, width: u16, height: u16) -> Buffer {
        let scatter = Scatter { marks, selected, x_title: "time", y_title: "rmse" };
        drawn(width, height, |area, buf| scatter.draw(PLAIN, area, buf))
    }

    fn known() -> [Mark; 3] {
        [mark(1e5, 0.1, 'A', true), mark(1e6, 0.1, 'B', false), mark(1e6, 0.001, 'C', true)]
    }

    #[test]
    fn a_known_front_stands_at_known_cells() {
        assert_eq!(
            text_of(&of(&known(), None, 40, 10)),
            [
                "rmse                                time",
                "  0.1┤ A──────────────────────────────B",
                "     │                                │",
                "     │                                │",
                " 0.01┤                                │",
                "     │                                │",
                "     │                                │",
                "0.001┤                                C─",
                "     └─┴──────────────────────────────┴─",
                "    100 µs                          1 ms",
            ]
            .map(str::to_string)
        );
    }

    #[test]
    fn the_selected_point_is_bracketed_and_reversed() {
        let buf = of(&known(), Some(2), 60, 12);
        let lines = text_of(&buf);
        assert!(lines.iter().any(|l| l.contains("[C]")), "{lines:?}");
        let reversed = |c: &ratatui::buffer::Cell| c.modifier.contains(Modifier::REVERSED);
        assert_eq!(buf.content.iter().filter(|c| reversed(c)).count(), 1);
        assert!(!text_of(&of(&known(), None, 60, 12)).iter().any(|l| l.contains("[C]")));
    }

    #[test]
    fn no_error_at_all_has_a_band_below() {
        let marks = [mark(1e5, 0.1, 'A', true), mark(1e6, 0.0, 'B', true)];
        let lines = text_of(&of(&marks, None, 40, 12));
        assert!(lines[8].contains('╌'), "{lines:?}");
        assert!(lines[9].trim_start().starts_with("0┤") && lines[9].contains('B'), "{lines:?}");
        // Nothing but zeros still is a plot.
        let zeros = text_of(&of(&[mark(1e6, 0.0, 'B', true)], None, 40, 12));
        assert!(zeros[9].contains('B'), "{zeros:?}");
    }

    #[test]
    fn one_point_no_points_and_what_is_no_number() {
        let one = text_of(&of(&[mark(2e6, 0.02, 'A', true)], None, 40, 10));
        assert_eq!(one.iter().filter(|l| l.contains('A')).count(), 1, "{one:?}");
        assert_eq!(text_of(&of(&[], None, 40, 10))[0], "no points");
        let odd = [
            mark(f64::NAN, 0.1, 'N', false),
            mark(1e6, f64::NAN, 'N', false),
            mark(1e6, f64::INFINITY, 'N', false),
            mark(0.0, 1.0, 'N', false),
            mark(1e6, 0.1, 'A', true),
        ];
        let lines = text_of(&of(&odd, Some(0), 40, 10)).concat();
        assert!(lines.contains('A') && !lines.contains('N'), "{lines}");
        assert_eq!(text_of(&of(&[odd[0]], None, 40, 10))[0], "too small to draw");
    }

    #[test]
    fn twenty_four_decades_fit_with_labels() {
        let marks = [mark(1.0, 1e12, 'A', true), mark(1e12, 1e-12, 'B', true)];
        let lines = text_of(&of(&marks, None, 80, 20));
        let all = lines.join("\n");
        for label in ["1e-12┤", "1e12┤", "1 ns", "1 ms"] {
            assert!(all.contains(label), "{label}: {all}");
        }
    }

    #[test]
    fn any_size_will_do_and_nothing_is_coloured_without_colour() {
        let zero = [mark(1e5, 0.1, 'A', true), mark(1e6, 0.0, 'B', true)];
        for (width, height) in sizes() {
            for marks in [&known()[..], &zero] {
                assert!(!has_colour(&of(marks, Some(1), width, height)));
            }
        }
    }
}
