//! Cells of the view as the kernels of clustered shading know them.

use crate::{
    Eye,
    clustered::{Grid, Hierarchy},
};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Words of a cell's box.
pub(super) const BOX_WORDS: u64 = 6;

/// Mirrors `CellParams` of `common/lights_cells.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(super) struct CellParams {
    eye: Vec3,
    scale: f32,
    forward: Vec3,
    near_m: f32,
    tile: u32,
    slices: u32,
    columns: u32,
    cells: u32,
    groups: u32,
    lights: u32,
    capacity: u32,
    growing: u32,
}

/// Cells of a grid.
pub(super) fn cells_of(grid: &Grid) -> u64 {
    grid.tiles() as u64 * u64::from(grid.slices)
}

/// What kernels are told of the cells of a frame, whose lists have room for `capacity` entries.
pub(super) fn params(eye: &Eye, grid: &Grid, hierarchy: &Hierarchy, capacity: u32) -> CellParams {
    CellParams {
        eye: eye.position.as_vec3(),
        scale: grid.scale as f32,
        forward: eye.forward.as_vec3(),
        near_m: grid.near_m as f32,
        tile: grid.tile,
        slices: grid.slices,
        columns: grid.columns,
        // Within the limit of the grid.
        cells: cells_of(grid) as u32,
        groups: hierarchy.levels.first().map_or(0, |level| level.len() as u32),
        lights: hierarchy.lights.len() as u32,
        capacity,
        growing: u32::from(grid.growing),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{clustered::Group, gpu::mirror};
    use std::mem::offset_of;

    macro_rules! at {
        ($type:ty: $($field:ident as $name:literal),* $(,)?) => {
            &[$(($name, offset_of!($type, $field) as u32)),*]
        };
    }

    #[test]
    fn structs_lie_as_on_the_device() {
        let path = "many-lights/clustered_list.wgsl";
        let params = at!(CellParams: eye as "eye", scale as "scale", forward as "forward",
            near_m as "near_m", tile as "tile", slices as "slices", columns as "columns",
            cells as "cells", groups as "groups", lights as "lights", capacity as "capacity",
            growing as "growing");
        mirror::<CellParams>(path, "CellParams", params);
        let group = at!(Group: min as "low", reach_squared as "reach_squared", max as "high",
            pad as "pad");
        mirror::<Group>(path, "Group", group);
        let source = dapple_shaders::source(path).unwrap();
        assert!(source.contains(&format!("const FAN = {}u;", crate::clustered::FAN)));
        assert!(source.contains(&format!("const BOX_WORDS = {BOX_WORDS}u;")));
    }
}
