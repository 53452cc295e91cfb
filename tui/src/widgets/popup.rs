//! A box above a screen.

use crate::theme::Theme;
use ratatui::{
    buffer::Buffer,
    layout::Rect,
    text::Line,
    widgets::{Block, Clear, Widget},
};

/// Clears the middle of `area`, frames it with a title and returns what is inside: at most
/// `width` by `height` with the frame.
pub fn draw(
    title: &str,
    [width, height]: [u16; 2],
    theme: Theme,
    area: Rect,
    buf: &mut Buffer,
) -> Rect {
    let (width, height) = (width.min(area.width), height.min(area.height));
    let popup = Rect {
        x: area.x + (area.width - width) / 2,
        y: area.y + (area.height - height) / 2,
        width,
        height,
    };
    Clear.render(popup, buf);
    // On a tiny terminal a frame would leave nothing inside.
    if height < 5 || width < 20 {
        return popup;
    }
    let block = Block::bordered().title(Line::styled(format!(" {title} "), theme.title()));
    let inside = block.inner(popup);
    block.render(popup, buf);
    inside
}
