//! Parallel-split shadow maps against closed forms, and the forms against each other.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

#[path = "../gpu_support/mod.rs"]
mod gpu_support;

mod compare;
mod device;
mod fitting;
mod ports;
mod scene;
mod splitting;
