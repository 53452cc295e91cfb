//! A city's frame at night: what the camera sees, which lights may reach it, and what they give.
//!
//! Composes `dapple-occlusion` (what is seen, and view cells from its coverage), from-region visibility
//! of `dapple-many-lights` (a precut of the light tree for each cell) and its cuts (what each pixel
//! gets from its precut).

pub mod cells;
pub mod coherence;
pub mod decompose;
mod drawer;
mod error;
mod front;
mod heights;
pub mod lists;
mod pipeline;
mod settings;
mod surfaces;
mod town;

pub use drawer::{Device, Drawer};
pub use error::NightError;
pub use front::{CellLight, Front, Prepared};
pub use pipeline::{Counts, FrameTimes, Pipeline};
pub use settings::{Night, Part, TAU_IMAGE_PX};
pub use surfaces::Surfaces;
pub use town::{Given, Town, frame};
