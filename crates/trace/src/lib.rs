//! Ground truth by rays: visibility, depth maps, item buffers, light visibility and the box
//! filtered shadow signal, all from one watertight `f64` ray caster.
//!
//! A BVH of f32 boxes finds candidates, conservatively; whether and where a ray meets a triangle is
//! decided in `f64` alone. So no result depends on the tree, the thread count, the scene's scale or
//! its distance from the origin, and a closed mesh has no gaps at its edges and vertices.

mod build;
mod error;
mod filtered;
mod light;
mod maps;
mod sampling;
mod sheets;
mod space;
mod surface;
mod tracer;
mod watertight;

pub use error::TraceError;
pub use filtered::{
    PLANE_EPSILON, PlaneInMap, SURFACE_REACH, filtered_visibility, filtered_visibility_all,
    receiver,
};
pub use light::{light_visibility, light_visibility_all, surface_light_visibility};
pub use maps::{depth_map, item_buffer, surfaces};
pub use surface::Surface;
pub use tracer::{Hit, Ray, Tracer};
