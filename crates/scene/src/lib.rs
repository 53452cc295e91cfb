//! Scenes: what is rendered, by which light, seen from where.
//!
//! Conventions (`docs/conventions.md`): right-handed, y up, metres; geometry is stored in `f32`
//! relative to its mesh, placed in the world by an `f64` affine transform; colours are linear RGB.

mod light_view;
mod types;

pub use light_view::{LightView, LightViewError};
pub use types::{
    AlphaTest, Aabb, Camera, CameraPath, Instance, Light, Material, Mesh, Projection, Scene, Texture,
};
