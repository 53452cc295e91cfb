//! The selected row of a list, and how keys move it.

use crate::keys::Action;

/// Rows that a page key moves: half a screen of 24 rows.
const PAGE: usize = 10;

/// The selected row, from 0. A list may shrink under it: read it with [`Cursor::at`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cursor(usize);

impl Cursor {
    /// At a row.
    pub fn new(at: usize) -> Self {
        Self(at)
    }

    /// The selected row of `count`, `None` of an empty list.
    pub fn at(self, count: usize) -> Option<usize> {
        count.checked_sub(1).map(|last| self.0.min(last))
    }

    /// Selects a row.
    pub fn set(&mut self, at: usize) {
        self.0 = at;
    }

    /// Moves by a key. True if the key was one that moves, whether or not there was room.
    pub fn act(&mut self, action: Action, count: usize) -> bool {
        let last = count.saturating_sub(1);
        let at = self.0.min(last);
        self.0 = match action {
            Action::Up => at.saturating_sub(1),
            Action::Down => (at + 1).min(last),
            Action::PageUp => at.saturating_sub(PAGE),
            Action::PageDown => (at + PAGE).min(last),
            Action::First => 0,
            Action::Last => last,
            _ => return false,
        };
        true
    }
}

/// The first row shown of `count` when `height` rows fit: the selected one stays in the middle
/// where it can. Derived rather than kept, so that drawing changes nothing.
pub fn first_shown(selected: Option<usize>, count: usize, height: usize) -> usize {
    let most = count.saturating_sub(height);
    selected.unwrap_or_default().saturating_sub(height / 2).min(most)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_move_within_the_list() {
        let walk = |from, action, count| {
            let mut cursor = Cursor::new(from);
            assert!(cursor.act(action, count));
            cursor.at(count)
        };
        for (from, action, count, expect) in [
            (0, Action::Up, 5, Some(0)),
            (0, Action::Down, 5, Some(1)),
            (4, Action::Down, 5, Some(4)),
            (0, Action::PageDown, 50, Some(10)),
            (3, Action::PageUp, 50, Some(0)),
            (3, Action::Last, 50, Some(49)),
            (3, Action::First, 50, Some(0)),
            // The list shrank: the next key counts from what was seen.
            (40, Action::Up, 5, Some(3)),
            (40, Action::Down, 0, None),
        ] {
            assert_eq!(walk(from, action, count), expect, "{from} {action:?} of {count}");
        }
        assert!(!Cursor::default().act(Action::Open, 5));
    }

    #[test]
    fn the_selected_row_is_always_shown() {
        for count in 0..30 {
            for height in 1..12 {
                for selected in 0..count {
                    let first = first_shown(Some(selected), count, height);
                    assert!((first..first + height).contains(&selected));
                    assert!(first + height <= count.max(height), "no empty rows at the end");
                }
            }
        }
        assert_eq!(first_shown(None, 9, 3), 0);
        assert_eq!(first_shown(Some(0), 0, 0), 0);
    }
}
