//! `dapple export`.

use crate::{Outcome, args};
use anyhow::Result;

/// Runs it.
pub fn run(_: &args::Export) -> Result<Outcome> {
    anyhow::bail!("not written yet")
}
