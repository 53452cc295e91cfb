//! Which objects a camera sees: occlusion culling as a plain library.
//!
//! A *renderer* draws objects and answers how many pixels of a box would show against what has been
//! drawn; a *technique* decides what to draw and what to ask. So each technique is written once and
//! runs on the software renderer and on a graphics device alike.

pub mod camera;
mod error;

pub use error::OcclusionError;
