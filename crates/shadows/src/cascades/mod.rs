//! Parallel-split shadow maps: one binary depth map for each slice of the camera's view depth.
//!
//! Based on: Zhang, Sun, Xu and Lun, "Parallel-split shadow maps for large-scale virtual
//! environments", VRCIA 2006 (`zhang2006`); the baseline of Voicu's thesis (`voicu2011`), section
//! 2.2.
//!
//! Steps of a frame, with the names that all forms share: **depth-0**, **depth-1**, ... (the
//! triangles into the map of each cascade, cropped to its region) and **shade** (one cascade a
//! receiver, then percentage-closer filtering in it). [`splits`] cuts the camera's depths, [`fit`]
//! chooses the regions.
//!
//! Coordinates are those of one *base map* of the light (u, v in 0..=1, v down; linear depth); a
//! [`Cascade`] is a square of it. Depth is the base map's in all cascades. Which cascade and which
//! texels a receiver reads is decided in f32 in every form ([`lookup`]); comparisons are f32 in
//! the ports and f64 in the reference, and [`reference::port_bounds`] says how far that may move a
//! result.
//!
//! Base map coordinates are f32 for triangles and receivers alike: a region of 1/1000 of the map has
//! steps of 1/16,000 of its own side left, which maps of 2048 texels show as 1/8 texel.
//!
//! Deviations: slices are fitted as squares, so that texels stay square; blending between
//! cascades and snapping to texels under a moving camera are left out.

pub mod cpu;
mod error;
pub mod faults;
mod fit;
pub mod gpu;
pub mod lookup;
pub mod reference;
mod splits;
mod types;

pub use error::CascadeError;
pub use fit::{Cascade, CasterBox, Fit, fit};
pub use splits::{logarithmic_split, splits, uniform_split};
pub use types::{CascadeReceiver, Counters, MAX_CASCADES, MAX_SIDE, Settings, Taps};

use crate::filtering::DepthMap;

/// Checks maps, cascades and settings; the side of the maps.
fn check_input(
    maps: &[DepthMap],
    cascades: &[Cascade],
    settings: &Settings,
) -> Result<u32, CascadeError> {
    let side = maps.first().map_or(0, |map| map.width);
    check_maps(maps, cascades.len(), side)?;
    check_settings(side, cascades, settings)?;
    for (cascade, map) in maps.iter().enumerate() {
        map.check().map_err(|error| CascadeError::Map { cascade, error })?;
    }
    Ok(side)
}

fn check_settings(
    side: u32,
    cascades: &[Cascade],
    settings: &Settings,
) -> Result<(), CascadeError> {
    settings.check()?;
    if !(1..=MAX_SIDE).contains(&side) {
        let limit = "within 1..=32768 texels";
        return Err(CascadeError::Knob { name: "side", value: side.into(), limit });
    }
    fit::check(cascades)
}

/// Checks number and size of the maps, without looking at depths.
fn check_maps(maps: &[DepthMap], expected: usize, side: u32) -> Result<(), CascadeError> {
    if maps.len() != expected {
        return Err(CascadeError::Length { what: "maps", expected, actual: maps.len() });
    }
    for (cascade, map) in maps.iter().enumerate() {
        map.check_size(side, side).map_err(|error| CascadeError::Map { cascade, error })?;
    }
    Ok(())
}
