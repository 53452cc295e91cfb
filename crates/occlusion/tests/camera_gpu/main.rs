//! The renderer on a graphics device: what it draws, what it counts, and what it refuses.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod extremes;
mod image;
mod oracle;
mod queries;
mod support;
