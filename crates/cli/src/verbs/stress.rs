//! `dapple stress`.

use crate::{Outcome, args};
use anyhow::Result;

/// Runs it.
pub fn run(_: &args::Stress) -> Result<Outcome> {
    anyhow::bail!("not written yet")
}

/// The child's side.
pub fn serve() -> Result<Outcome> {
    anyhow::bail!("not written yet")
}
