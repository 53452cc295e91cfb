//! What can go wrong between a command line and a record.

use dapple_foliage::partition::PartitionError;
use dapple_gpu::GpuError;
use dapple_many_lights::LightsError;
use dapple_night_city::NightError;
use dapple_occlusion::OcclusionError;
use std::path::PathBuf;

/// Errors of the suite. [`SuiteError::exit_code`] sorts them for a shell.
#[derive(Debug, thiserror::Error)]
pub enum SuiteError {
    /// A name that nothing has: says what there is.
    #[error("no {what} `{name}`; there is: {known}")]
    Unknown {
        /// What kind of thing was named.
        what: &'static str,
        /// The name as given.
        name: String,
        /// The names there are.
        known: String,
    },
    /// A knob or parameter outside its range or of the wrong type.
    #[error("{what} `{name}` = {value}: {limit}")]
    Value {
        /// "knob" or "parameter".
        what: &'static str,
        /// Its name.
        name: String,
        /// The value as given.
        value: String,
        /// What is allowed.
        limit: String,
    },
    /// A sweep file that cannot be understood.
    #[error("{path}: {message}")]
    Sweep {
        /// The file.
        path: PathBuf,
        /// What is wrong, with the line where known.
        message: String,
    },
    /// A scene of the test data, which are not at hand. Sweeps pass over it.
    #[error("scene data:{path}: set {variable} to the folder that holds the test data")]
    MissingData {
        /// Path below that folder.
        path: String,
        /// The environment variable.
        variable: &'static str,
    },
    /// Input that does not fit together.
    #[error("{0}")]
    Usage(String),
    /// A scene that cannot be read or used.
    #[error(transparent)]
    Scene(#[from] dapple_scene::SceneError),
    /// A light that cannot be given a shadow map.
    #[error(transparent)]
    LightView(#[from] dapple_scene::LightViewError),
    /// Truth by rays refused its input.
    #[error(transparent)]
    Trace(#[from] dapple_trace::TraceError),
    /// A metric refused its input.
    #[error(transparent)]
    Metric(#[from] dapple_metrics::MetricError),
    /// The shadow filters refused their settings or input.
    #[error(transparent)]
    Filter(#[from] dapple_shadows::filtering::FilterError),
    /// The cascades refused their settings or input.
    #[error(transparent)]
    Cascade(#[from] dapple_shadows::cascades::CascadeError),
    /// The opacity maps refused their settings or input.
    #[error(transparent)]
    Opacity(#[from] dapple_opacity_maps::OpacityError),
    /// Occlusion culling refused its settings or input, or its device failed.
    #[error(transparent)]
    Occlusion(#[from] OcclusionError),
    /// Many lights refused their settings or input, or their device failed.
    #[error(transparent)]
    Lights(#[from] LightsError),
    /// A city at night refused its settings or input, or its device failed.
    #[error(transparent)]
    Night(#[from] NightError),
    /// The generator of cities refused its knobs.
    #[error(transparent)]
    City(#[from] dapple_scene::city::CityError),
    /// The partition refused its input.
    #[error(transparent)]
    Partition(#[from] PartitionError),
    /// The graphics device.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// Records could not be read or written.
    #[error(transparent)]
    Record(#[from] dapple_records::RecordError),
    /// Files and processes.
    #[error("{what}: {source}")]
    Io {
        /// What was being done, naming the path.
        what: String,
        /// The system's word.
        source: std::io::Error,
    },
    /// A sweep stopped by the user; finished rows are on disk.
    #[error("interrupted: {done} of {total} rows are recorded in {path}; the same command resumes")]
    Interrupted {
        /// Rows on disk.
        done: usize,
        /// Rows planned.
        total: usize,
        /// The record file.
        path: PathBuf,
    },
    /// A fault of the program itself, reported rather than panicking.
    #[error("internal: {0}")]
    Internal(String),
}

impl SuiteError {
    /// 2 for usage and bad input, 3 for the environment (no adapter, disk, interruption).
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Gpu(_) | Self::Record(_) | Self::Io { .. } | Self::Interrupted { .. } => 3,
            Self::Internal(_)
            | Self::Occlusion(OcclusionError::Gpu(_))
            | Self::Lights(LightsError::Gpu(_))
            | Self::Night(
                NightError::Lights(LightsError::Gpu(_))
                | NightError::Occlusion(OcclusionError::Gpu(_)),
            ) => 3,
            _ => 2,
        }
    }

    /// The graphics device's own error, where that is behind it.
    pub fn device(&self) -> Option<&GpuError> {
        match self {
            Self::Gpu(error)
            | Self::Partition(PartitionError::Gpu(error))
            | Self::Occlusion(OcclusionError::Gpu(error))
            | Self::Lights(LightsError::Gpu(error))
            | Self::Night(
                NightError::Lights(LightsError::Gpu(error))
                | NightError::Occlusion(OcclusionError::Gpu(error)),
            ) => Some(error),
            _ => None,
        }
    }

    /// An unknown name, with what there is.
    pub fn unknown<'a>(
        what: &'static str,
        name: &str,
        known: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        let known = known.into_iter().collect::<Vec<_>>().join(", ");
        Self::Unknown { what, name: name.into(), known }
    }

    /// An I/O error with what was being done.
    pub fn io(what: impl Into<String>) -> impl FnOnce(std::io::Error) -> Self {
        let what = what.into();
        move |source| Self::Io { what, source }
    }
}
