//! Lights that move, beside those of the world.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 6.1 (future work:
//! dynamic lights in a second tree).
//! Deviations: they are never culled: every pixel's walk ends with their whole tree, whatever its
//! object starts at.

use super::given::Given;
use crate::{
    Light, LightTree, LightsError, Point,
    tree::{Extent, MOST_LIGHTS},
};

/// Lights that move: in the order of the tree they come after the world's.
#[derive(Clone, Debug, Default)]
pub(crate) struct Moving {
    /// What the tree of the world's lights has.
    pub(crate) fixed: Extent,
    /// Roots of their trees, as nodes behind those of the world's.
    pub(crate) roots: Vec<u32>,
    /// Nodes of their trees.
    pub(crate) nodes: usize,
    lights: Vec<Light>,
}

impl Moving {
    /// None beside a tree.
    pub(super) fn none(tree: &LightTree) -> Self {
        Self { fixed: tree.extent(), ..Self::default() }
    }

    /// The nodes of their trees: from and to.
    pub(crate) fn range(&self) -> [u32; 2] {
        let from = self.fixed.nodes;
        [from as u32, (from + self.nodes) as u32]
    }

    /// The lights.
    pub(crate) fn lights(&self) -> &[Light] {
        &self.lights
    }
}

impl Given {
    /// Other lights move from here on; `tree` is over them alone.
    pub(crate) fn set_moving(
        &mut self,
        lights: &[Light],
        tree: &LightTree,
    ) -> Result<(), LightsError> {
        tree.check_number(lights)?;
        let moving = &mut self.moving;
        let all = moving.fixed.lights + lights.len();
        if all > MOST_LIGHTS {
            let limit = format!("{all} with those of the world, of at most {MOST_LIGHTS}");
            return Err(LightsError::value("moving lights", limit));
        }
        for (index, light) in lights.iter().enumerate() {
            light.check(moving.fixed.lights + index)?;
        }
        moving.nodes = tree.nodes.len();
        moving.lights.clear();
        moving.lights.extend_from_slice(lights);
        let behind = moving.fixed.nodes as u32;
        moving.roots.clear();
        moving.roots.extend(tree.roots.iter().map(|root| root + behind));
        Ok(())
    }

    /// Light `index` of the world's and those that move.
    fn light(&self, index: u32) -> &Light {
        let fixed = &self.world.lights;
        let index = index as usize;
        if index < fixed.len() { &fixed[index] } else { &self.moving.lights[index - fixed.len()] }
    }

    /// Whether nothing lies between a point and a light, the world's or one that moves.
    pub(super) fn sees(&self, point: &Point, light: u32) -> bool {
        self.world.sees(point, self.light(light))
    }

    /// Where objects of a range walk from: nodes, and the heights that these are hidden below.
    pub(super) fn entries(&self, range: [u32; 2]) -> impl Iterator<Item = (u32, f32)> + Clone {
        let moving = self.moving.roots.iter().map(|&root| (root, f32::NEG_INFINITY));
        self.starts.with_heights(range).chain(moving)
    }

    /// Where a point walks from.
    pub(super) fn entries_of(&self, point: &Point) -> impl Iterator<Item = u32> + Clone {
        let height = point.position.y;
        let all = self.entries(self.starts.range(point.object));
        all.filter(move |&(_, hidden_below)| height > hidden_below).map(|(node, _)| node)
    }
}
