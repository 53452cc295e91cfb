//! Ground truth by rays: visibility, depth maps, item buffers, light visibility and the box
//! filtered shadow signal, all from one watertight `f64` ray caster. For what lets light through:
//! opacities, every surface along a light's or a camera's ray, and the light that reaches a point.
//! For volumes: exact chords through balls, and a march through voxels to judge them by.
//!
//! A BVH of f32 boxes finds candidates, conservatively; whether and where a ray meets a triangle is
//! decided in `f64` alone. So no result depends on the tree, the thread count, the scene's scale or
//! its distance from the origin, and a closed mesh has no gaps at its edges and vertices.

mod build;
mod camera_layers;
mod error;
mod filtered;
mod flat;
mod light;
mod light_cells;
mod light_fragments;
mod light_raster;
mod lists;
mod maps;
mod opacity;
mod sampling;
mod sheets;
mod space;
mod surface;
mod tracer;
mod transmittance;
mod volume;
mod volume_fragments;
mod voxels;
mod watertight;

pub use camera_layers::{
    CameraLayers, LEAST_CAMERA_TRANSMITTANCE, MAX_IMAGE_SIDE, MAX_LAYERS, camera_layers,
};
pub use error::TraceError;
pub use filtered::{
    PLANE_EPSILON, PlaneInMap, SURFACE_REACH, filtered_visibility, filtered_visibility_all,
    receiver,
};
pub use flat::{FlatNode, FlatTree, FlatTriangle, MAX_FLAT_M};
pub use light::{light_visibility, light_visibility_all, surface_light_visibility};
pub use light_fragments::{
    LightFragments, MAX_LIGHT_FRAGMENTS, MAX_MAP_SIDE, light_fragments, light_fragments_by_rays,
};
pub use maps::{depth_map, item_buffer, surfaces};
pub use opacity::Opacities;
pub use surface::Surface;
pub use tracer::{Hit, Ray, Tracer};
pub use transmittance::{
    Footprint, LEAST_TRANSMITTANCE, Law, LightPath, transmittance, transmittance_all,
};
pub use volume::{Ball, Profile, ball_bounds, optical_depth};
pub use volume_fragments::{VolumeFragments, volume_fragments};
pub use voxels::{MAX_VOXELS, Voxels};
