//! `dapple live`.

use crate::{Outcome, args};
use anyhow::Result;

/// Runs it.
pub fn run(_: &args::Live) -> Result<Outcome> {
    anyhow::bail!("not written yet")
}
