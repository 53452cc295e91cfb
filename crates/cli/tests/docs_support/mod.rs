//! What the tests of the pages share.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail as tests do")]

pub mod blocks;
pub mod commands;
pub mod links;
pub mod pages;
pub mod pictures;
mod views;

use std::path::Path;

/// Root of the repository.
pub fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}
