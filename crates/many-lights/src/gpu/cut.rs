//! R3 and R4 on a device: a walk a pixel, or one a tile.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, sections 3.1 (skip counts) and
//! 3.2 (rules).
//! Deviations: the cut of a tile is ours.

use super::{
    kernel::{Kernel, Parts},
    lightcuts::lightcuts,
    scene::Scene,
    tree::Tree,
};
use crate::{
    BoundForm, Lighting, LightsError,
    cut::{Given, Method, Rule},
};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

/// Mirrors `RuleParams` of `common/lights_rule.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct RuleParams {
    limit: f32,
    pad: [u32; 3],
}

/// Cuts as `given` says, from its starts.
///
/// # Errors
/// A tree or a cut over a limit of the device, by name; lights other than the scene's.
pub fn cut<'g>(
    scene: &Arc<Scene<'g>>,
    given: &Given,
) -> Result<Box<dyn Lighting + 'g>, LightsError> {
    let scene = super::scene_with_shadows(Some(scene), &given.world)?;
    let tree = Tree::new(scene.gpu, &given.tree.pack(), &given.starts)?;
    let (path, limit, form, relative) = match given.method {
        Method::Worst(settings) => return lightcuts(scene, given, &tree, &settings),
        Method::Tile { threshold, form } => ("many-lights/cut_tile.wgsl", threshold, form, false),
        Method::Rule(Rule::Absolute(threshold), form) => {
            ("many-lights/cut.wgsl", threshold, form, false)
        }
        Method::Rule(Rule::Relative(epsilon), form) => {
            ("many-lights/cut.wgsl", epsilon, form, true)
        }
    };
    let params = RuleParams { limit: finite(limit), ..RuleParams::default() };
    let params = scene.gpu.uniform("rule", &params)?;
    let parts = Parts {
        pass: "cut",
        path,
        constants: &[form_constant(form), ("RELATIVE", f64::from(u8::from(relative)))],
        buffers: &[&tree.nodes, &tree.starts, &tree.ranges, &params],
        evaluates_all: relative,
        most_groups: None,
    };
    Ok(Box::new(Kernel::new(scene, &parts)?))
}

/// The constant `FORM` of `common/lights_tree.wgsl`.
pub(super) fn form_constant(form: BoundForm) -> (&'static str, f64) {
    ("FORM", if form == BoundForm::Walter { 0.0 } else { 1.0 })
}

/// In f32, and the greatest number in place of an infinite one, which shaders need not know.
pub(super) fn finite(limit: f64) -> f32 {
    (limit as f32).min(f32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_has_the_layout_of_the_shaders() {
        for path in ["many-lights/cut.wgsl", "many-lights/cut_tile.wgsl"] {
            let fields = [("limit", 0), ("pad0", 4), ("pad1", 8), ("pad2", 12)];
            crate::gpu::mirror::<RuleParams>(path, "RuleParams", &fields);
        }
    }
}
