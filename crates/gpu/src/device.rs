//! An open device: features and limits, lost-device and error callbacks, waiting.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::adapter::{self, AdapterChoice, AdapterFacts};
use crate::frame::TimestampPool;
use crate::pipeline::PipelineKey;
use crate::probe::{self, Abilities};
use crate::{GpuError, buffer};

/// How long any wait may take before [`GpuError::Timeout`].
pub(crate) const WAIT: Duration = Duration::from_secs(120);

/// Optional features that techniques use; each is asked for where the adapter has it.
const WANTED: wgpu::Features = wgpu::Features::TIMESTAMP_QUERY
    .union(wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS)
    .union(wgpu::Features::SHADER_F16)
    .union(wgpu::Features::FLOAT32_FILTERABLE)
    .union(wgpu::Features::FLOAT32_BLENDABLE)
    .union(wgpu::Features::SUBGROUP)
    .union(wgpu::Features::INDIRECT_FIRST_INSTANCE)
    .union(wgpu::Features::MULTI_DRAW_INDIRECT_COUNT);

/// An open, probed device.
#[derive(Debug)]
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// What the adapter says of itself.
    pub facts: AdapterFacts,
    /// What the probes found, and which optional features there are.
    pub abilities: Abilities,
    pub(crate) pools: Mutex<Vec<TimestampPool>>,
    pub(crate) modules: Mutex<BTreeMap<String, wgpu::ShaderModule>>,
    pub(crate) pipelines: Mutex<BTreeMap<PipelineKey, wgpu::ComputePipeline>>,
    pub(crate) poison_source: Option<wgpu::Buffer>,
    state: Arc<State>,
}

/// What the callbacks of the device leave behind.
#[derive(Debug, Default)]
struct State {
    errors: Mutex<VecDeque<GpuError>>,
    lost: Mutex<Option<String>>,
}

/// A poisoned lock only means that another thread panicked while pushing a value.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Gpu {
    /// Opens the adapter that `choice` asks for, after its probes (which run once a process).
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`], [`GpuError::NotFound`], [`GpuError::Unsound`], or what the driver
    /// says when it refuses a device.
    pub fn open(choice: &AdapterChoice) -> Result<Gpu, GpuError> {
        let (adapter, facts) = adapter::choose(choice)?;
        let abilities = probe::abilities(&adapter, &facts)?;
        let mut gpu = Gpu::bare(&adapter, facts)?;
        gpu.abilities = abilities;
        gpu.poison_source = Some(buffer::poison_source(&gpu)?);
        Ok(gpu)
    }

    /// A device without probes: the probes' own.
    pub(crate) fn bare(adapter: &wgpu::Adapter, facts: AdapterFacts) -> Result<Gpu, GpuError> {
        let request = adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("dapple"),
            required_features: adapter.features() & WANTED,
            required_limits: adapter.limits(),
            ..Default::default()
        });
        let (device, queue) = pollster::block_on(request)
            .map_err(|e| GpuError::Validation { what: facts.line(), message: chain(&e) })?;
        let state = Arc::new(State::default());
        let errors = Arc::clone(&state);
        device.on_uncaptured_error(Arc::new(move |error| {
            lock(&errors.errors).push_back(typed("graphics device", error));
        }));
        let lost = Arc::clone(&state);
        device.set_device_lost_callback(move |reason, message| {
            lock(&lost.lost).get_or_insert(format!("{reason:?}: {message}"));
        });
        Ok(Gpu {
            device,
            queue,
            facts,
            abilities: Abilities::default(),
            pools: Mutex::default(),
            modules: Mutex::default(),
            pipelines: Mutex::default(),
            poison_source: None,
            state,
        })
    }

    /// Limits of the device: those of the adapter.
    pub fn limits(&self) -> wgpu::Limits {
        self.device.limits()
    }

    /// Reports a lost device (again at each call), or the oldest error that no other call
    /// reported (once).
    ///
    /// # Errors
    /// That error.
    pub fn check(&self) -> Result<(), GpuError> {
        // The lost-device callback runs inside poll. Its own result says nothing here: a poll
        // that does not wait has no reason to fail but a lost device.
        let _ = self.device.poll(wgpu::PollType::Poll);
        if let Some(message) = lock(&self.state.lost).clone() {
            return Err(GpuError::DeviceLost(message));
        }
        lock(&self.state.errors).pop_front().map_or(Ok(()), Err)
    }

    /// Runs `make` and reports what wgpu says about it as an error that names `what`.
    ///
    /// # Errors
    /// [`GpuError::Validation`], [`GpuError::OutOfMemory`], or [`GpuError::DeviceLost`]: a failed
    /// pipeline can lose the device without a word.
    pub fn scoped<T>(&self, what: &str, make: impl FnOnce() -> T) -> Result<T, GpuError> {
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let internal = self.device.push_error_scope(wgpu::ErrorFilter::Internal);
        let validation = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let made = make();
        let errors = [
            pollster::block_on(validation.pop()),
            pollster::block_on(internal.pop()),
            pollster::block_on(memory.pop()),
        ];
        match errors.into_iter().flatten().next() {
            Some(error) => Err(typed(what, error)),
            None => match lock(&self.state.lost).clone() {
                Some(message) => Err(GpuError::DeviceLost(message)),
                None => Ok(made),
            },
        }
    }

    /// Waits until `submission` is done.
    ///
    /// # Errors
    /// [`GpuError::Timeout`] or [`GpuError::DeviceLost`].
    pub fn wait(&self, what: &str, submission: wgpu::SubmissionIndex) -> Result<(), GpuError> {
        let poll = wgpu::PollType::Wait { submission_index: Some(submission), timeout: Some(WAIT) };
        match self.device.poll(poll) {
            Ok(_) => Ok(()),
            Err(error) => {
                self.check()?;
                Err(match error {
                    wgpu::PollError::Timeout => {
                        GpuError::Timeout { what: what.into(), seconds: WAIT.as_secs() }
                    }
                    other => GpuError::DeviceLost(format!("{what}: {other}")),
                })
            }
        }
    }
}

/// wgpu's error as ours.
fn typed(what: &str, error: wgpu::Error) -> GpuError {
    let what = what.to_string();
    match error {
        wgpu::Error::OutOfMemory { .. } => GpuError::OutOfMemory { what },
        wgpu::Error::Validation { description, .. } => {
            GpuError::Validation { what, message: description }
        }
        wgpu::Error::Internal { description, .. } => {
            GpuError::Validation { what, message: description }
        }
    }
}

/// An error with its causes.
fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text.push_str(": ");
        text.push_str(&error.to_string());
        cause = error.source();
    }
    text
}
