//! Techniques on the plain software renderer.

mod coverage;
mod extremes;
mod options;
mod properties;
pub(in crate::camera) mod world;
