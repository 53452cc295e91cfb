//! Cuts whose starts, and whose moving lights, are others from frame to frame.

use super::{Cpu, Given, Reference, Starts};
use crate::{Form, Light, LightTree, Lighting, LightsError, gpu};
use std::sync::Arc;

/// A technique that makes cuts, told before a frame where walks begin and which lights have moved.
/// Where it refuses, it is as before.
pub trait Starting: Lighting + Send {
    /// Walks begin there from the next frame on. Bytes that were sent to a device, 0 without one.
    ///
    /// # Errors
    /// A node that the tree of the world's lights does not have, by object; the device's.
    fn start(&mut self, starts: &Starts) -> Result<u64, LightsError>;

    /// Other lights move from the next frame on, in the place of those that did; `tree` is over them
    /// alone. Every pixel is lit by them, whatever it starts at. Bytes that were sent to a device.
    ///
    /// # Errors
    /// A tree of other lights, a light that [`Light::check`] refuses, numbered behind the world's;
    /// the device's.
    fn replace_moving(&mut self, lights: &[Light], tree: &LightTree) -> Result<u64, LightsError>;

    /// The starts that it holds, read back where that is on a device: there every node has a height
    /// as soon as one ever had.
    ///
    /// # Errors
    /// The device's.
    fn starts(&self) -> Result<Starts, LightsError>;
}

/// A form made ready from what is given; `scene` is used by the gpu form.
///
/// # Errors
/// A scene that is not there or of another world; a tree or cuts over a limit of the device, by name.
pub fn starting<'g>(
    form: Form,
    given: &Given,
    scene: Option<&Arc<gpu::Scene<'g>>>,
) -> Result<Box<dyn Starting + 'g>, LightsError> {
    Ok(match form {
        Form::Reference => Box::new(Reference::new(given.clone())),
        Form::Cpu => Box::new(Cpu::new(given.clone())),
        Form::Gpu => gpu::cut(gpu::scene_with_shadows(scene, &given.world)?, given)?,
    })
}
