//! Light trees: shapes, sums, cones and what stands for clusters.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod builds;
mod changes;
mod cities;
mod nodes;
mod properties;
mod shapes;
mod support;
