//! Keys with values, one below the other.

use super::text;
use crate::theme::Theme;
use ratatui::{
    buffer::Buffer,
    layout::Rect,
    style::Style,
    text::{Line, Span},
    widgets::{Paragraph, Widget},
};

/// One key with its value. An empty key continues the one above; both empty is an empty line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pair {
    /// What it is.
    pub key: String,
    /// The value; long ones wrap under themselves.
    pub value: String,
    /// The value's style.
    pub style: Style,
}

/// A pair in the plain style.
pub fn pair(key: impl Into<String>, value: impl Into<String>) -> Pair {
    Pair { key: key.into(), value: value.into(), style: Style::new() }
}

impl Pair {
    /// The same in a style.
    #[must_use]
    pub fn style(self, style: Style) -> Self {
        Self { style, ..self }
    }
}

/// The pairs as lines of at most `width` columns: keys in one column, values wrapped beside them.
pub fn lines(pairs: &[Pair], width: u16, theme: Theme) -> Vec<Line<'static>> {
    let width = usize::from(width);
    let widest = pairs.iter().map(|p| text::width(&p.key)).max().unwrap_or_default();
    // Keys take no more than a third: values are what is read.
    let keys = widest.min(width / 3);
    let gap = if keys > 0 { 2 } else { 0 };
    let mut lines = Vec::new();
    for pair in pairs {
        let mut key = text::fit(&pair.key, keys);
        let values = text::wrap(&pair.value, width.saturating_sub(keys + gap));
        for value in if values.is_empty() { vec![String::new()] } else { values } {
            let pad = " ".repeat(keys + gap - text::width(&key));
            lines.push(Line::from(vec![
                Span::styled(std::mem::take(&mut key), theme.dim()),
                Span::raw(pad),
                Span::styled(value, pair.style),
            ]));
        }
    }
    lines
}

/// Draws pairs from line `first` on.
pub fn draw(pairs: &[Pair], first: usize, theme: Theme, area: Rect, buf: &mut Buffer) {
    let shown: Vec<_> =
        lines(pairs, area.width, theme).into_iter().skip(first).take(area.height.into()).collect();
    Paragraph::new(shown).render(area, buf);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(pairs: &[Pair], width: u16) -> Vec<String> {
        let lines = lines(pairs, width, Theme { colour: false });
        lines.iter().map(|l| l.to_string().trim_end().to_string()).collect()
    }

    #[test]
    fn values_wrap_under_themselves() {
        let pairs =
            [pair("truth", "rays from every receiver"), pair("", "64 of them"), pair("", "")];
        assert_eq!(
            texts(&pairs, 18),
            ["truth  rays from", "       every", "       receiver", "       64 of them", ""]
        );
        assert_eq!(texts(&pairs, 0).len(), 3);
        assert!(texts(&[], 10).is_empty());
    }

    #[test]
    fn no_line_is_wider_than_the_pane() {
        let pairs = [pair("a very long key indeed", "some words"), pair("k", "x".repeat(50))];
        for width in 0..60 {
            for line in lines(&pairs, width, Theme { colour: false }) {
                // Below three columns a gap alone is wider; it is cut when drawn.
                assert!(line.width() <= usize::from(width).max(3), "{width}: {line}");
            }
        }
    }
}
