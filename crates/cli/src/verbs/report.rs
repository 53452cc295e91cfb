//! `dapple report`.

use crate::{Outcome, args};
use anyhow::Result;

/// Runs it.
pub fn run(_: &args::Report) -> Result<Outcome> {
    anyhow::bail!("not written yet")
}
