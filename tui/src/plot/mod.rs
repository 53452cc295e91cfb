//! Drawings in cells: pictures, a scatter plot with axes, curves.

pub mod axis;
pub mod curve;
pub mod picture;
pub mod scatter;
