//! Colours that stay apart for the colour-blind; meaning is never in the colour alone.

use ratatui::style::{Color, Modifier, Style};

/// The styles of all screens. Without colour only modifiers remain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Theme {
    /// Whether colours are used.
    pub colour: bool,
}

impl Theme {
    fn of(self, colour: Color) -> Style {
        if self.colour { Style::new().fg(colour) } else { Style::new() }
    }

    /// Headings and the current tab.
    pub fn title(self) -> Style {
        self.of(Color::Cyan).add_modifier(Modifier::BOLD)
    }

    /// The selected row.
    pub fn selected(self) -> Style {
        Style::new().add_modifier(Modifier::REVERSED)
    }

    /// What matters less.
    pub fn dim(self) -> Style {
        Style::new().add_modifier(Modifier::DIM)
    }

    /// Good: on the front, passed, reproduced, faster. Blue, as in the error maps.
    pub fn good(self) -> Style {
        self.of(Color::Rgb(86, 160, 233))
    }

    /// Bad: failed, refuted, broken, slower. Orange, bold.
    pub fn bad(self) -> Style {
        self.of(Color::Rgb(230, 130, 0)).add_modifier(Modifier::BOLD)
    }

    /// Neither: open, not run, within noise.
    pub fn neutral(self) -> Style {
        self.of(Color::Gray)
    }

    /// A colour for the nth technique of a plot (Okabe and Ito's palette); the marker says it too.
    pub fn series(self, n: usize) -> Style {
        const PALETTE: [Color; 7] = [
            Color::Rgb(230, 159, 0),
            Color::Rgb(86, 180, 233),
            Color::Rgb(0, 158, 115),
            Color::Rgb(240, 228, 66),
            Color::Rgb(0, 114, 178),
            Color::Rgb(213, 94, 0),
            Color::Rgb(204, 121, 167),
        ];
        self.of(PALETTE[n % PALETTE.len()])
    }
}
