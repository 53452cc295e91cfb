//! One figure against the settings of one knob, which stand side by side in order.

use crate::{theme::Theme, widgets::text};
use ratatui::{buffer::Buffer, layout::Rect, style::Style};

/// One setting and its figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// The knob's value.
    pub label: String,
    /// The figure; 0 stands at the bottom.
    pub value: f64,
    /// Whether it is the setting that is selected.
    pub current: bool,
}

/// A curve.
#[derive(Clone, Copy)]
pub struct Curve<'a> {
    /// In the knob's order.
    pub steps: &'a [Step],
    /// What the figure is.
    pub title: &'a str,
    /// How figures are written.
    pub format: fn(f64) -> String,
    /// Of the line.
    pub style: Style,
}

impl Curve<'_> {
    /// Draws into any area: the greatest figure at the top, the least at the bottom, each at its
    /// value's height by its logarithm.
    pub fn draw(&self, theme: Theme, area: Rect, buf: &mut Buffer) {
        let area = area.intersection(buf.area);
        if area.is_empty() {
            return;
        }
        buf.set_stringn(area.x, area.y, self.title, area.width.into(), theme.dim());
        let steps: Vec<&Step> = self.steps.iter().filter(|s| s.value.is_finite()).collect();
        let least = steps.iter().map(|s| s.value).fold(f64::INFINITY, f64::min);
        let most = steps.iter().map(|s| s.value).fold(f64::NEG_INFINITY, f64::max);
        let left = text::width(&(self.format)(least)).max(text::width(&(self.format)(most))) + 1;
        let left = left as u16;
        if steps.is_empty() || area.height < 4 || area.width < left + 6 {
            return;
        }
        let plot = Rect {
            x: area.x + left,
            y: area.y + 1,
            width: area.width - left,
            height: area.height - 2,
        };
        let heights: Vec<u16> =
            steps.iter().map(|s| height(s.value, &steps, plot.height)).collect();
        let column = |i: usize| {
            // The middle of the setting's share of the width.
            let at = (2 * i + 1) * usize::from(plot.width) / (2 * steps.len());
            plot.x + at.min(usize::from(plot.width) - 1) as u16
        };
        for y in plot.y..plot.bottom() {
            buf.set_string(plot.x - 1, y, "│", theme.dim());
        }
        let label = |buf: &mut Buffer, value: f64, up: u16| {
            let y = plot.bottom() - 1 - up;
            let figure = (self.format)(value);
            let x = plot.x - 1 - text::width(&figure) as u16;
            buf.set_string(x, y, figure, theme.dim());
            buf.set_string(plot.x - 1, y, "┤", theme.dim());
        };
        label(buf, least, height(least, &steps, plot.height));
        label(buf, most, height(most, &steps, plot.height));
        for (i, pair) in heights.windows(2).enumerate() {
            let (from, to) = (column(i), column(i + 1));
            for x in from + 1..to {
                let share = f64::from(x - from) / f64::from(to - from);
                let up = f64::from(pair[0]) + (f64::from(pair[1]) - f64::from(pair[0])) * share;
                buf.set_string(x, plot.bottom() - 1 - up.round() as u16, "·", self.style);
            }
        }
        let mut free = area.x;
        for (i, step) in steps.iter().enumerate() {
            let (x, y) = (column(i), plot.bottom() - 1 - heights[i]);
            let (symbol, style) =
                if step.current { ("◆", theme.title()) } else { ("●", self.style) };
            buf.set_string(x, y, symbol, style);
            let width = text::width(&step.label) as u16;
            let begin = x.saturating_sub(width / 2).min(area.right().saturating_sub(width));
            if begin >= free && begin + width <= area.right() {
                let style = if step.current { theme.title() } else { theme.dim() };
                buf.set_string(begin, plot.bottom(), &step.label, style);
                free = begin + width + 1;
            }
        }
    }
}

/// Rows above the bottom.
fn height(value: f64, steps: &[&Step], rows: u16) -> u16 {
    let positive = steps.iter().map(|s| s.value).filter(|v| *v > 0.0);
    let (low, high) =
        positive.clone().fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
    let zero = steps.iter().any(|s| s.value <= 0.0);
    // 0 has the lowest row for itself.
    let floor = u16::from(zero);
    let room = rows.saturating_sub(floor);
    if value <= 0.0 || room == 0 {
        return 0;
    }
    if low >= high {
        return floor + (room - 1) / 2;
    }
    let share = (value / low).ln() / (high / low).ln();
    floor + (share.clamp(0.0, 1.0) * f64::from(room - 1)).round() as u16
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{drawn, has_colour, sizes, text_of};

    const PLAIN: Theme = Theme { colour: false };

    fn lines(values: &[(&str, f64)], width: u16, height: u16) -> Vec<String> {
        let steps: Vec<Step> = values
            .iter()
            .enumerate()
            .map(|(i, (label, value))| Step {
                label: label.to_string(),
                value: *value,
                current: i == 1,
            })
            .collect();
        let format = |v: f64| format!("{v}");
        let style = PLAIN.good();
        let curve = Curve { steps: &steps, title: "rmse", format, style };
        let buf = drawn(width, height, |area, buf| curve.draw(PLAIN, area, buf));
        assert!(!has_colour(&buf));
        text_of(&buf)
    }

    #[test]
    fn figures_stand_at_their_heights_above_their_settings() {
        assert_eq!(
            lines(&[("256", 1.0), ("512", 10.0), ("1024", 100.0)], 24, 7),
            [
                "rmse",
                "100┤               ·●",
                "   │            ···",
                "   │         ·◆·",
                "   │     ····",
                "  1┤   ●·",
                "      256    512  1024",
            ]
            .map(str::to_string)
        );
    }

    #[test]
    fn no_error_stands_at_the_bottom_and_what_is_no_number_nowhere() {
        let zero = lines(&[("a", 0.0), ("b", 1.0)], 20, 6);
        assert!(zero[4].contains('●') && zero[1..4].iter().any(|l| l.contains('◆')), "{zero:?}");
        let nan = lines(&[("a", f64::NAN), ("b", 1.0)], 20, 6).join("");
        assert_eq!(nan.matches(['●', '◆']).count(), 1, "{nan}");
        assert!(!lines(&[("a", f64::NAN)], 20, 6).join("").contains('●'));
        assert_eq!(lines(&[], 20, 6)[0], "rmse");
    }

    #[test]
    fn no_size_panics() {
        for (width, height) in sizes() {
            lines(&[("a", 1e-300), ("b", 0.0), ("c", 1e300)], width, height);
        }
    }
}
