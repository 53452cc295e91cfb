//! What is refused, by name.

use dapple_many_lights::LightsError;
use dapple_occlusion::OcclusionError;
use thiserror::Error;

/// Why a city, settings or a device cannot be used.
#[derive(Debug, Error)]
pub enum NightError {
    /// A number that no computation survives, or beyond what is supported.
    #[error("{element}: {limit}")]
    Value {
        /// Which cell, setting or buffer.
        element: String,
        /// What is wrong, and what is allowed.
        limit: String,
    },
    /// What is seen.
    #[error(transparent)]
    Occlusion(#[from] OcclusionError),
    /// What lights it.
    #[error(transparent)]
    Lights(#[from] LightsError),
}

impl NightError {
    /// A refusal of `element` that says `limit`.
    pub fn value(element: impl Into<String>, limit: impl Into<String>) -> Self {
        Self::Value { element: element.into(), limit: limit.into() }
    }
}
