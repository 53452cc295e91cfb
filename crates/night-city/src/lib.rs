//! A city's frame at night: what the camera sees, which lights may reach it, and what they give.
//!
//! Composes `dapple-occlusion` (what is seen, and view cells from its coverage), from-region visibility
//! of `dapple-many-lights` (a precut of the light tree for each cell) and its cuts (what each pixel
//! gets from its precut).

mod error;

pub use error::NightError;
