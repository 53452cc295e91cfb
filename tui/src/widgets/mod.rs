//! What several screens draw: tables, panes of keys and values, bars, figures.

pub mod bar;
pub mod cursor;
pub mod format;
pub mod pane;
pub mod popup;
pub mod table;
pub mod text;

pub use cursor::Cursor;
pub use table::{Cell, Column};
