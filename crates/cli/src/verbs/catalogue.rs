//! `dapple catalogue`.

use crate::Outcome;
use anyhow::Result;

/// Runs it.
pub fn run() -> Result<Outcome> {
    anyhow::bail!("not written yet")
}
