//! Drawings in cells: pictures, a scatter plot with axes, curves.

pub mod picture;
