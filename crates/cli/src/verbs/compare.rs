//! `dapple compare`.

use crate::{Outcome, args};
use anyhow::Result;

/// Runs it.
pub fn run(_: &args::Compare) -> Result<Outcome> {
    anyhow::bail!("not written yet")
}
