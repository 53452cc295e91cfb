//! What the graphics form refuses, by name.

use dapple_gpu::{GpuError, light_space::LightSpaceError};
use thiserror::Error;

/// Why maps cannot be made or read on a graphics device.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum OpacityGpuError {
    /// Settings or sizes out of range.
    #[error(transparent)]
    Opacity(#[from] crate::OpacityError),
    /// The mesh is not sound.
    #[error(transparent)]
    Mesh(#[from] LightSpaceError),
    /// The device refused, or a named limit of it is too small.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// A choice that has no graphics form.
    #[error("{what} has no graphics form: {why}")]
    NoForm {
        /// The choice.
        what: String,
        /// What stands against it.
        why: &'static str,
    },
}

impl OpacityGpuError {
    /// A size over a limit of the device.
    pub(super) fn too_large(what: &str, asked: u64, limit: &'static str, max: u64) -> Self {
        Self::Gpu(GpuError::TooLarge { what: what.into(), asked, limit, max })
    }
}
