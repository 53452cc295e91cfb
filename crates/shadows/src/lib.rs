//! Shadow techniques as plain libraries: nothing here knows that it is measured.
//!
//! [`filtering`] antialiases a depth map: percentage-closer filtering and the pre-filtered
//! (statistical) estimators, in reference, CPU and GPU form. [`cascades`] splits the camera's view
//! into slices with a binary map each.

pub mod cascades;
pub mod filtering;
