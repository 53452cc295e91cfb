//! Probes.

use serde::Serialize;

use crate::{AdapterFacts, GpuError};

/// What the device can do, as found by probes and features.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Abilities {
    /// Timestamps of passes are there and sound; else `gpu_ns` is `None`.
    pub timestamps: bool,
}

pub(crate) fn abilities(
    adapter: &wgpu::Adapter,
    _facts: &AdapterFacts,
) -> Result<Abilities, GpuError> {
    Ok(Abilities { timestamps: adapter.features().contains(wgpu::Features::TIMESTAMP_QUERY) })
}
