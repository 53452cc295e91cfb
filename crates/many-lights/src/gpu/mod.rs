//! The same techniques on a device: WGSL kernels, one thread a pixel, one workgroup a tile.

mod brute;
mod capped;
mod cells;
mod clustered;
mod cut;
mod kernel;
mod lightcuts;
mod occluders;
mod reservoirs;
mod room;
mod sample;
mod scene;
mod tree;

pub use crate::light::PackedLight;
pub use occluders::{LIFT, Occluders};
pub use scene::{FrameParams, Output, Scene, TILE};
pub use tree::Tree;

pub(crate) use brute::brute_force;
pub(crate) use capped::OnDevice as OnDeviceCapped;
pub(crate) use clustered::OnDevice as OnDeviceClustered;
pub use cut::cut;
pub(crate) use reservoirs::OnDevice as OnDeviceReservoirs;
pub(crate) use sample::sampler;

use crate::{LightsError, World};
use std::sync::Arc;

/// The scene that the device's form of a technique without shadow rays is made from.
///
/// # Errors
/// As [`scene_with_shadows`]; a world with occluders.
pub(crate) fn scene_of<'a, 'g>(
    scene: Option<&'a Arc<Scene<'g>>>,
    world: &Arc<World>,
) -> Result<&'a Arc<Scene<'g>>, LightsError> {
    if world.occluders.is_some() {
        return Err(LightsError::value("gpu form", "traces no shadow rays for this technique"));
    }
    scene_with_shadows(scene, world)
}

/// The scene that a device's form is made from.
///
/// # Errors
/// None is given, or it is of another world.
pub(crate) fn scene_with_shadows<'a, 'g>(
    scene: Option<&'a Arc<Scene<'g>>>,
    world: &Arc<World>,
) -> Result<&'a Arc<Scene<'g>>, LightsError> {
    match scene {
        None => Err(LightsError::value("gpu form", "needs a scene on a device")),
        Some(scene) if !Arc::ptr_eq(&scene.world, world) => {
            Err(LightsError::value("gpu form", "the scene on the device is of another world"))
        }
        Some(scene) => Ok(scene),
    }
}

/// Holds a struct against the shader's, field by field.
#[cfg(test)]
fn mirror<T>(path: &str, name: &str, fields: &[(&str, u32)]) {
    let source = dapple_shaders::source(path).unwrap();
    let layout = dapple_shaders::struct_layout(&source, name).unwrap();
    let names: Vec<_> = layout.fields.iter().map(|f| (f.0.as_str(), f.1)).collect();
    assert_eq!(names, fields);
    assert_eq!(layout.size as usize, size_of::<T>());
}
