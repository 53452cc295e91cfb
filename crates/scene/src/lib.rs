//! Scenes: what is rendered, by which light, seen from where.
//!
//! Conventions (`docs/conventions.md`): right-handed, y up, metres; geometry is stored in `f32`
//! relative to its mesh, placed in the world by an `f64` affine transform; colours are linear RGB.

pub mod city;
mod crop;
mod defaults;
mod error;
pub mod eye;
pub mod generate;
mod hash;
pub mod import;
pub mod inspect;
mod light_view;
pub mod orbit;
mod path;
pub mod strands;
mod types;
mod validate;
mod write;

pub use crop::Crop;
pub use defaults::{GROUND, add_ground};
pub use error::SceneError;
pub use eye::{Eye, EyeError};
pub use light_view::{LightView, LightViewError};
pub use orbit::{Orbit, OrbitError};
pub use strands::{Facing, Ribbons, Strands};
pub use types::{
    Aabb, AlphaTest, Camera, CameraPath, Instance, Light, Material, Mesh, Projection, Scene,
    Texture,
};
pub use validate::{MAX_COORDINATE_M, MAX_TEXTURE_SIDE, MAX_TRIANGLES, is_degenerate};
pub use write::write_glb;
