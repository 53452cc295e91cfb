//! From-region visibility by rays between points of a cell and the lights: what most renderers would
//! do, and not sound. Lights that no ray meets are left out although some point may see them.
//!
//! Based on: P. Wonka et al., "Guided visibility sampling", 2006, section 1 (visibility by samples is
//! aggressive: it errs to the hidden side, and less so with more rays).
//! Deviations: rays are not guided; they go to lights, which are points, rather than to whatever they
//! meet first, and none to lights that give the cell nothing anyway; points are spread evenly by
//! additive recurrences.

use super::potential::{is_weak, potential, white};
use super::{Cuboid, Direction, Precuts, Sampled, Steps, ViewCell};
use crate::sample::{Random, hash};
use crate::{Emission, LightTree, Node, World, bound::Region, cut::children};
use std::sync::Arc;

/// The rival, made ready for one light tree.
pub struct Rays {
    tree: Arc<LightTree>,
    world: Arc<World>,
    settings: Sampled,
    /// By node: whether all its lights were found visible.
    whole: Vec<bool>,
    steps: Steps,
}

/// Steps of the evenly spread sequence in three dimensions: powers of the inverse of the real root of
/// x⁴ = x + 1 (Roberts 2018).
const STEPS: [f64; 3] = [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_3];

impl Rays {
    /// Rays are traced against what casts shadows in the world; all lights are visible where nothing
    /// does. `settings` are those that [`super::RegionTechnique::check`] lets pass.
    pub fn new(tree: Arc<LightTree>, world: Arc<World>, settings: Sampled) -> Self {
        let whole = vec![false; tree.nodes.len()];
        Self { tree, world, settings, whole, steps: Steps::default() }
    }

    /// Whether a light gives no point of a region anything: no ray is spent on it.
    fn is_dark(&mut self, node: &Node, white: &Region) -> bool {
        let is_dark = is_weak(potential(node, white, self.world.clamp_m), 0.0);
        self.steps.potential += 1;
        self.steps.potential_culled += u64::from(is_dark);
        is_dark
    }

    /// Whether any of the rays to a light arrives; stops at the first that does.
    fn is_seen(
        &mut self,
        cell: &ViewCell,
        direction: Direction,
        face: &Cuboid,
        light: u32,
    ) -> bool {
        self.steps.last += 1;
        let Some(of) = self.world.lights.get(light as usize) else { return false };
        let key = place_key(face) ^ direction.index() as u32;
        let mut draws = Random::new(self.settings.seed, key, light);
        let start = [0, 1, 2].map(|_| f64::from(draws.unit()));
        for ray in 0..self.settings.rays {
            let share = |axis: usize| (start[axis] + STEPS[axis] * f64::from(ray)).fract();
            let along = |[low, high]: [f64; 2], share: f64| {
                ((1.0 - share) * low + share * high).clamp(low, high)
            };
            let (u, w, h) = (share(0), share(2), share(1));
            let at = direction.turned(along(face.u, u), along(face.w, w), along(face.h, h));
            self.steps.rays += 1;
            if self.world.sees_from(cell.turn.from(at), of) {
                return true;
            }
        }
        self.steps.last_culled += 1;
        false
    }
}

/// Another number for another place, the same for the same: cells draw on their own.
fn place_key(face: &Cuboid) -> u32 {
    [face.u, face.w, face.h].as_flattened().iter().fold(0, |key, side| {
        let bits = side.to_bits();
        hash(key ^ bits as u32 ^ hash((bits >> 32) as u32))
    })
}

impl Precuts for Rays {
    fn precut(&mut self, cell: &ViewCell, direction: Direction, nodes: &mut Vec<u32>) {
        nodes.clear();
        let Some(face) = cell.face(direction) else { return };
        let (face, region) = (face.cuboid(direction), white(&face.region));
        self.steps.evaluations += 1;
        let tree = Arc::clone(&self.tree);
        let size = |node: u32| tree.nodes[node as usize].size;
        // Children lie behind their parents.
        for index in (0..tree.nodes.len() as u32).rev() {
            let node = &tree.nodes[index as usize];
            self.whole[index as usize] = if node.kind == Emission::Directional.code() {
                true
            } else if node.is_leaf() {
                let (min, max) = cell.turn.around(node.min, node.max);
                direction.cuboid(min, max).w[1] > face.w[0]
                    && !self.is_dark(node, &region)
                    && self.is_seen(cell, direction, &face, node.light)
            } else {
                children(index, size).all(|child| self.whole[child as usize])
            };
        }
        let mut index = 0;
        while let Some(node) = tree.nodes.get(index as usize) {
            if self.whole[index as usize] {
                nodes.push(index);
                index += node.size;
            } else {
                index += 1;
            }
        }
        self.steps.output += nodes.len() as u64;
    }

    fn steps(&self) -> &Steps {
        &self.steps
    }

    fn bytes(&self) -> u64 {
        self.whole.len() as u64
    }
}
