//! Two-pass culling with a hierarchical depth buffer.

pub mod pyramid;

pub use pyramid::{Level, Pixels, Pyramid};
