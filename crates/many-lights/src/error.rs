//! What is refused, by name.

use thiserror::Error;

/// Why lights, settings or a device cannot be used.
#[derive(Debug, Error)]
pub enum LightsError {
    /// A number that no computation survives, or beyond what is supported.
    #[error("{element}: {limit}")]
    Value {
        /// Which light, setting or buffer.
        element: String,
        /// What is wrong, and what is allowed.
        limit: String,
    },
    /// The device's.
    #[error(transparent)]
    Gpu(#[from] dapple_gpu::GpuError),
}

impl LightsError {
    /// A refusal of `element` that says `limit`.
    pub fn value(element: impl Into<String>, limit: impl Into<String>) -> Self {
        Self::Value { element: element.into(), limit: limit.into() }
    }
}
