//! What can go wrong between here and the graphics device.

use dapple_shaders::ShaderError;

/// Every failure of this crate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GpuError {
    /// There is no adapter at all.
    #[error("no graphics adapter; {hint}")]
    NoAdapter {
        /// How to get one.
        hint: String,
    },
    /// The adapter asked for by name is not there.
    #[error("no adapter matches `{asked}`; there are: {have}")]
    NotFound {
        /// What was asked for.
        asked: String,
        /// The adapters there are, separated by semicolons.
        have: String,
    },
    /// A probe shows that this adapter computes wrong results.
    #[error("adapter `{adapter}` is unsound: probe `{probe}` expected {expected}, found {found}")]
    Unsound {
        /// Name and driver of the adapter.
        adapter: String,
        /// The probe.
        probe: String,
        /// What a sound adapter answers.
        expected: String,
        /// What this one answered.
        found: String,
    },
    /// A size over a limit of the device, or over the buffer that is read.
    #[error("{what}: {asked} exceeds {limit} = {max}")]
    TooLarge {
        /// What was to be made, with its label.
        what: String,
        /// The size asked for.
        asked: u64,
        /// Name of the limit.
        limit: &'static str,
        /// Value of the limit.
        max: u64,
    },
    /// The device has not got an optional feature.
    #[error("{what} needs the device feature {feature}, which this adapter has not got")]
    Missing {
        /// What needs it.
        what: String,
        /// The feature.
        feature: &'static str,
    },
    /// wgpu refused a call.
    #[error("{what}: {message}")]
    Validation {
        /// The resource or shader.
        what: String,
        /// wgpu's message.
        message: String,
    },
    /// An allocation failed.
    #[error("{what}: out of graphics memory")]
    OutOfMemory {
        /// What was being made.
        what: String,
    },
    /// The driver gave up; nothing made on this device can be used any more.
    #[error("graphics device lost: {0}")]
    DeviceLost(String),
    /// The device did not finish in time.
    #[error("{what}: the graphics device did not finish in {seconds} s")]
    Timeout {
        /// What was waited for.
        what: String,
        /// The time waited.
        seconds: u64,
    },
    /// A read-back buffer could not be mapped.
    #[error("reading {what}: {message}")]
    Map {
        /// The buffer.
        what: String,
        /// wgpu's message.
        message: String,
    },
    /// A shader file is unknown, does not parse, or is invalid.
    #[error(transparent)]
    Shader(#[from] ShaderError),
}
