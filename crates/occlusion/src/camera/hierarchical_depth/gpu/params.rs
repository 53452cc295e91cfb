//! What the kernels know of a frame.

use crate::camera::View;
use crate::camera::hierarchical_depth::Level;
use bytemuck::{Pod, Zeroable};
use glam::{DVec3, DVec4};

/// Most levels of a pyramid, the image among them: those of the longest side that a view has.
pub(super) const LEVELS: usize = 16;

/// Mirrors `Params` of `common/occlusion_cull.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(super) struct Params {
    right: [f32; 4],
    up: [f32; 4],
    forward: [f32; 4],
    planes: [[f32; 4]; 5],
    eye: [f32; 3],
    near: f32,
    pixel: f32,
    secant: f32,
    range: f32,
    parallel: u32,
    size: [u32; 2],
    across: u32,
    levels: u32,
    pub items: u32,
    pub groups: u32,
    pub slots: u32,
    pad: u32,
    level: [[u32; 4]; LEVELS],
}

impl Params {
    /// For `view`; `levels` are those of its image.
    pub fn of(view: &View, levels: &[Level], across: u32, counts: Counts) -> Self {
        // What rounding the eye lost is made good in f64.
        let eye = view.eye_f32.as_dvec3();
        let axis = |axis: DVec3| row(axis.extend(axis.dot(eye - view.eye)));
        let plane = |p: DVec4| row(p.truncate().extend(p.w + p.truncate().dot(eye)));
        let mut level = [[0; 4]; LEVELS];
        // The image itself is not among the texels.
        let image = view.width * view.height;
        for (entry, at) in level.iter_mut().zip(levels) {
            *entry = [at.width, at.height, at.start.saturating_sub(image), 0];
        }
        Self {
            right: axis(view.right / view.half_extent.x),
            up: axis(view.up / view.half_extent.y),
            forward: axis(view.forward),
            planes: view.planes.map(plane),
            eye: view.eye_f32.into(),
            near: view.near_m as f32,
            pixel: view.pixel_m(1.0) as f32,
            secant: (1.0 + view.half_extent.length_squared()).sqrt() as f32,
            range: if view.parallel { view.range_m as f32 } else { 1.0 },
            parallel: u32::from(view.parallel),
            size: [view.width, view.height],
            across,
            levels: levels.len().min(LEVELS) as u32,
            items: counts.items,
            groups: counts.groups,
            slots: counts.slots,
            pad: 0,
            level,
        }
    }
}

/// How much the kernels go over.
#[derive(Clone, Copy, Debug)]
pub(super) struct Counts {
    pub items: u32,
    pub groups: u32,
    pub slots: u32,
}

fn row(v: DVec4) -> [f32; 4] {
    v.as_vec4().into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::hierarchical_depth::pyramid::levels;

    #[test]
    fn parameters_have_the_layout_of_the_shader() {
        let fields = [
            ("right", 0),
            ("up", 16),
            ("forward", 32),
            ("planes", 48),
            ("eye", 128),
            ("near", 140),
            ("pixel", 144),
            ("secant", 148),
            ("range", 152),
            ("parallel", 156),
            ("size", 160),
            ("across", 168),
            ("levels", 172),
            ("items", 176),
            ("groups", 180),
            ("slots", 184),
            ("pad", 188),
            ("level", 192),
        ];
        let path = "occlusion/hierarchical_cull.wgsl";
        crate::camera::gpu::mirror::<Params>(path, "Params", &fields);
    }

    #[test]
    fn the_largest_image_has_a_place_for_every_level() {
        let side = dapple_scene::MAX_TEXTURE_SIDE;
        assert!(levels(side, side).len() <= LEVELS);
        assert!(levels(side, 1).len() <= LEVELS);
    }
}
