//! R0 on a device.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 1.1 (every light for
//! every pixel).
//! Deviations: sums are of blocks of 1024 lights. Lights are an array of 48 bytes each rather than
//! leaves of a tree of 80: nothing but what is computed with is read.

use super::{
    kernel::{Kernel, Parts},
    scene::Scene,
};
use crate::{Lighting, LightsError};
use std::sync::Arc;

/// Every light at every pixel.
///
/// # Errors
/// The device's.
pub(crate) fn brute_force<'g>(
    scene: &Arc<Scene<'g>>,
) -> Result<Box<dyn Lighting + 'g>, LightsError> {
    let parts = Parts {
        pass: "brute force",
        path: "many-lights/brute_force.wgsl",
        constants: &[],
        buffers: &[scene.lights()],
        evaluates_all: false,
        most_groups: None,
    };
    Ok(Box::new(Kernel::new(scene, &parts)?))
}
