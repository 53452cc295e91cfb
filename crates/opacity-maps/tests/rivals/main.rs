//! The codes that are no layers: range, ends, order, exact cases, ports, extremes.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod exact_cases;
mod extremes;
mod filters;
mod knobs;
mod port;
mod properties;
mod random;
mod support;
