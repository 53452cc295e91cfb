//! `dapple merge`.

use crate::{Outcome, args};
use anyhow::Result;

/// Runs it.
pub fn run(_: &args::Merge) -> Result<Outcome> {
    anyhow::bail!("not written yet")
}
