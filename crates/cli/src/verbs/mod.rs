//! One module a verb.

pub mod advise;
pub mod catalogue;
pub mod claims;
pub mod compare;
pub mod dashboard;
pub mod doctor;
pub mod export;
pub mod front;
pub mod list;
pub mod live;
pub mod measure;
pub mod merge;
pub mod render;
pub mod report;
pub mod scene;
pub mod status;
pub mod stress;
pub mod verify;

use crate::output::note;
use dapple_gpu::{AdapterChoice, Gpu, GpuError};
use dapple_suite::environment::requires_gpu;

/// The adapter a flag names, or the best.
pub fn choice(adapter: Option<&String>) -> AdapterChoice {
    adapter.map_or(AdapterChoice::Auto, |name| AdapterChoice::Named(name.clone()))
}

/// Opens the adapter. Without one, says so on standard error and goes on without, unless one was
/// asked for by name or the environment demands one.
pub fn open_gpu(adapter: Option<&String>) -> Result<Option<Gpu>, dapple_suite::SuiteError> {
    match Gpu::open(&choice(adapter)) {
        Ok(gpu) => Ok(Some(gpu)),
        Err(error @ (GpuError::NoAdapter { .. } | GpuError::Unsound { .. }))
            if adapter.is_none() && !requires_gpu() =>
        {
            note!("gpu forms are not run: {error}");
            Ok(None)
        }
        Err(error) => Err(error.into()),
    }
}
