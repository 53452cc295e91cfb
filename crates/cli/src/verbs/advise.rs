//! `dapple advise`.

use crate::{Outcome, args};
use anyhow::Result;

/// Runs it.
pub fn run(_: &args::Advise) -> Result<Outcome> {
    anyhow::bail!("not written yet")
}
