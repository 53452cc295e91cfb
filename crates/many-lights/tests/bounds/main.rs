//! Bounds and estimates of clusters of lights, and the formula that they refer to.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod exact;
mod properties;
mod support;
