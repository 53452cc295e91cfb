//! The problems, one folder each.

use crate::{SuiteError, problem::Problem};

pub mod camera_visibility;
pub mod many_lights;
pub mod night_city;
pub mod partition_offsets;
pub mod region_light_visibility;
pub mod shadow_filtering;
pub mod translucent_shadow;

/// Every problem.
pub const ALL: &[&dyn Problem] = &[
    &shadow_filtering::ShadowFiltering,
    &partition_offsets::PartitionOffsets,
    &translucent_shadow::TranslucentShadow,
    &camera_visibility::CameraVisibility,
    &many_lights::ManyLights,
    &region_light_visibility::RegionLightVisibility,
    &night_city::NightCity,
];

/// The problem of that name.
///
/// # Errors
/// [`SuiteError::Unknown`] with the names there are.
pub fn find(id: &str) -> Result<&'static dyn Problem, SuiteError> {
    ALL.iter()
        .copied()
        .find(|p| p.spec().id == id)
        .ok_or_else(|| SuiteError::unknown("problem", id, ALL.iter().map(|p| p.spec().id)))
}
