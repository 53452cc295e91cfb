//! A table with a selected row: numbers stay whole and right-aligned, columns that matter least go
//! first where it is narrow, only the rows that are seen are made.

use super::{cursor::first_shown, text};
use crate::theme::Theme;
use ratatui::{
    buffer::Buffer,
    layout::Rect,
    style::Style,
    text::{Line, Span},
    widgets::Widget,
};

/// Columns between two columns.
const GAP: u16 = 1;
/// The mark of the selected row, which does not need colour.
const MARK: &str = ">";

/// One column.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Its heading.
    pub title: String,
    /// Least columns on the terminal.
    pub width: u16,
    /// Whether it is a number: right-aligned, never cut.
    pub number: bool,
    /// Whether it takes a share of the room that is left.
    pub grows: bool,
    /// 0 always stays; of the others the highest goes first.
    pub rank: u8,
}

impl Column {
    /// A column of words that grows.
    pub fn words(title: &str, width: u16) -> Self {
        Self { title: title.into(), width, number: false, grows: true, rank: 0 }
    }

    /// A column of numbers of a fixed width.
    pub fn number(title: &str, width: u16) -> Self {
        Self { title: title.into(), width, number: true, grows: false, rank: 0 }
    }

    /// The same, of a fixed width.
    #[must_use]
    pub fn fixed(self) -> Self {
        Self { grows: false, ..self }
    }

    /// The same, left out where it is narrow: the highest rank first.
    #[must_use]
    pub fn rank(self, rank: u8) -> Self {
        Self { rank, ..self }
    }
}

/// One cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cell {
    /// Its text.
    pub text: String,
    /// Its style.
    pub style: Style,
}

impl Cell {
    /// A cell in a style.
    pub fn styled(text: impl Into<String>, style: Style) -> Self {
        Self { text: text.into(), style }
    }
}

impl<T: Into<String>> From<T> for Cell {
    fn from(text: T) -> Self {
        Self { text: text.into(), style: Style::new() }
    }
}

/// Draws a heading and rows. `row` makes the cells of one row, in the order of `columns`; it is
/// called for the rows that are seen.
pub fn draw(
    columns: &[Column],
    count: usize,
    selected: Option<usize>,
    theme: Theme,
    area: Rect,
    buf: &mut Buffer,
    mut row: impl FnMut(usize) -> Vec<Cell>,
) {
    if area.is_empty() {
        return;
    }
    let height = usize::from(area.height - 1);
    // The mark stands left of the first column, the place in the list right of the last.
    let scrolls = count > height && height > 0;
    let room = area.width.saturating_sub(1 + u16::from(scrolls) * 2);
    let widths = widths(columns, room);
    let line = |cells: &mut dyn FnMut(usize, &Column) -> Cell, mark: &str| {
        let mut spans = vec![Span::raw(format!("{mark:1}"))];
        let mut first = true;
        for (i, column) in columns.iter().enumerate() {
            let Some(width) = widths[i] else { continue };
            if !std::mem::take(&mut first) {
                spans.push(Span::raw(" ".repeat(GAP.into())));
            }
            let cell = cells(i, column);
            spans.push(Span::styled(aligned(&cell.text, column.number, width), cell.style));
        }
        Line::from(spans)
    };
    line(&mut |_, column| Cell::styled(column.title.clone(), theme.dim()), "")
        .render(Rect { height: 1, ..area }, buf);
    let first = first_shown(selected, count, height);
    for (y, at) in (first..count).take(height).enumerate() {
        let cells = row(at);
        let here = Rect { y: area.y + 1 + y as u16, height: 1, ..area };
        let mark = if selected == Some(at) { MARK } else { "" };
        line(&mut |i, _| cells.get(i).cloned().unwrap_or_default(), mark).render(here, buf);
        if selected == Some(at) {
            buf.set_style(Rect { width: area.width.min(room + 1), ..here }, theme.selected());
        }
    }
    if scrolls {
        scrollbar(first, count, height, theme, area, buf);
    }
}

/// A thumb as long as the share that is seen, in the last column below the heading.
fn scrollbar(
    first: usize,
    count: usize,
    height: usize,
    theme: Theme,
    area: Rect,
    buf: &mut Buffer,
) {
    let thumb = (height * height / count).max(1);
    let free = height - thumb;
    // At the end only when the last row is seen.
    let at = if first + height >= count { free } else { first * free / (count - height) };
    let x = area.right().saturating_sub(1);
    for y in 0..height {
        let symbol = if (at..at + thumb).contains(&y) { "█" } else { "│" };
        buf.set_string(x, area.y + 1 + y as u16, symbol, theme.dim());
    }
}

/// Widths of the columns that fit into `room`, `None` for those left out.
fn widths(columns: &[Column], room: u16) -> Vec<Option<u16>> {
    let mut widths: Vec<Option<u16>> = columns.iter().map(|c| Some(c.width)).collect();
    let used = |widths: &[Option<u16>]| {
        let kept: Vec<u16> = widths.iter().flatten().copied().collect();
        let gaps = GAP * (kept.len().saturating_sub(1)) as u16;
        kept.iter().fold(gaps, |sum, w| sum.saturating_add(*w))
    };
    while used(&widths) > room {
        let kept = columns.iter().enumerate().filter(|(i, c)| c.rank > 0 && widths[*i].is_some());
        match kept.max_by_key(|(i, c)| (c.rank, *i)) {
            Some((i, _)) => widths[i] = None,
            None => break,
        }
    }
    // Not even what always stays fits: words give way to numbers.
    let excess = used(&widths).saturating_sub(room);
    let first_word = columns.iter().position(|c| c.grows && c.rank == 0);
    if let Some(i) = first_word.filter(|_| excess > 0) {
        widths[i] = widths[i].map(|w| w.saturating_sub(excess).max(4.min(w)));
    }
    let mut left = room.saturating_sub(used(&widths));
    let growing: Vec<usize> =
        (0..columns.len()).filter(|&i| columns[i].grows && widths[i].is_some()).collect();
    for (n, &i) in growing.iter().enumerate() {
        let share = left / (growing.len() - n) as u16;
        widths[i] = widths[i].map(|w| w + share);
        left -= share;
    }
    widths
}

/// A number that does not fit is not shown in part: half a number would be misread.
fn aligned(content: &str, number: bool, width: u16) -> String {
    let width = usize::from(width);
    let fitted = match number && text::width(content) > width && content.starts_with(numeric) {
        true => text::fit("…", width),
        false => text::fit(content, width),
    };
    let pad = " ".repeat(width - text::width(&fitted));
    if number { pad + &fitted } else { fitted + &pad }
}

fn numeric(c: char) -> bool {
    c.is_ascii_digit() || "-+±.".contains(c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::text_of;

    fn columns() -> Vec<Column> {
        vec![
            Column::words("technique", 6),
            Column::number("time", 8),
            Column::number("memory", 8).rank(2),
            Column::words("form", 4).fixed().rank(1),
        ]
    }

    fn drawn(width: u16, height: u16, count: usize, selected: usize) -> Buffer {
        let area = Rect::new(0, 0, width, height);
        let mut buf = Buffer::empty(area);
        let theme = Theme { colour: false };
        draw(&columns(), count, Some(selected), theme, area, &mut buf, |i| {
            vec![
                format!("t{i}").into(),
                "12.3 ms".into(),
                "1.0 MiB".into(),
                Cell::styled("gpu", theme.bad()),
            ]
        });
        buf
    }

    #[test]
    fn numbers_are_right_aligned_and_the_selected_row_is_marked_in_text_too() {
        assert_eq!(
            text_of(&drawn(34, 3, 2, 1)),
            [
                " technique      time   memory form",
                " t0          12.3 ms  1.0 MiB gpu",
                ">t1          12.3 ms  1.0 MiB gpu",
            ]
        );
        let row = drawn(34, 3, 2, 1);
        assert!(row[(0, 2)].modifier.contains(ratatui::style::Modifier::REVERSED));
        assert!(!row[(0, 1)].modifier.contains(ratatui::style::Modifier::REVERSED));
    }

    #[test]
    fn what_matters_least_goes_first_and_numbers_are_never_cut() {
        assert_eq!(text_of(&drawn(24, 2, 1, 0))[1], ">t0         12.3 ms gpu");
        assert_eq!(text_of(&drawn(16, 2, 1, 0))[1], ">t0      12.3 ms");
        let narrow = &text_of(&drawn(11, 2, 1, 0))[1];
        assert!(!narrow.contains("12.3 m") || narrow.contains("12.3 ms"), "{narrow}");
        assert_eq!(aligned("12.3 ms", true, 5), "    …");
        assert_eq!(aligned("passed", true, 5), "pass…");
    }

    #[test]
    fn long_lists_scroll_with_a_bar_that_says_where() {
        let at = |selected| text_of(&drawn(36, 5, 100, selected));
        assert!(at(0)[1].starts_with(">t0") && at(0)[1].ends_with('█'), "{:?}", at(0));
        assert!(at(99)[4].starts_with(">t99") && at(99)[4].ends_with('█'), "{:?}", at(99));
        assert!(at(50)[3].starts_with(">t50"), "{:?}", at(50));
    }

    #[test]
    fn only_rows_that_are_seen_are_made_and_no_size_panics() {
        for width in 0..50 {
            for height in 0..6 {
                let area = Rect::new(0, 0, width, height);
                let mut buf = Buffer::empty(area);
                let mut made = 0;
                draw(
                    &columns(),
                    1_000_000,
                    Some(7),
                    Theme { colour: true },
                    area,
                    &mut buf,
                    |_| {
                        made += 1;
                        Vec::new()
                    },
                );
                assert!(made <= height);
            }
        }
    }
}
