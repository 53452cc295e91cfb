//! Opacity, deep and bounding opacity maps: against the reference, by their properties, and where
//! little is left to go right.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod extremes;
mod port;
mod properties;
mod rows;
mod support;
