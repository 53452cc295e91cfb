//! The form on a graphics device: objects are drawn to a G-buffer (ids, normal, albedo, reversed
//! depth), and boxes are asked about by occlusion queries.
//!
//! [`Scene`] holds the objects, uploaded once, for whatever draws or culls them on the device.
//! [`Renderer`] draws and answers: what is drawn between two batches of queries is one pass, a
//! batch is another, and both are submitted as soon as the batch is asked. Nothing is made on the
//! device once the frames' largest batch and longest list have been seen.

mod batch;
mod draws;
mod pipelines;
mod renderer;
mod scene;
mod settings;
mod targets;
mod times;

pub(crate) use pipelines::{Pipelines, ViewParams};
pub use renderer::{Counters, Renderer};
pub use scene::Scene;
pub(crate) use scene::upload;
pub use settings::{Counting, Drawing, Fault, Settings};
pub use targets::Surface;
pub(crate) use targets::Targets;

/// Holds a struct against the shader's, field by field.
#[cfg(test)]
pub(crate) fn mirror<T>(path: &str, name: &str, fields: &[(&str, u32)]) {
    let source = dapple_shaders::source(path).unwrap();
    let layout = dapple_shaders::struct_layout(&source, name).unwrap();
    let names: Vec<_> = layout.fields.iter().map(|f| (f.0.as_str(), f.1)).collect();
    assert_eq!(names, fields);
    assert_eq!(layout.size as usize, size_of::<T>());
}
