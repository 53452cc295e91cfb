//! What a cluster may give at most, and when that is too weak.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 5.3.2 (cull by
//! potential irradiance).
//! Deviations: radiance of a white surface, by the bound of cuts over a region.

use crate::{
    BoundForm, Node,
    bound::{self, GUARD, Region},
};
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// The exact form: it costs more than the cheap one and culls more, and every test that follows costs
/// more than either.
const BOUND: BoundForm = BoundForm::Walter;

/// A face whose surfaces are white.
pub(super) fn white(region: &Region) -> Region {
    Region { albedo: DVec3::ONE, ..*region }
}

/// The most that any channel of any point of `white` may get from a node.
pub(super) fn potential(node: &Node, white: &Region, clamp_m: f64) -> f64 {
    bound::region(BOUND, node, white, clamp_m)
}

/// Whether so little is left out: what gives nothing, and what gives less than the threshold.
pub(super) fn is_weak(potential: f64, threshold: f64) -> bool {
    potential < threshold || potential == 0.0
}

/// The same of a node's [`potential`], mostly without it: nothing gives more than it does straight on,
/// and most clusters of a city are too far away even so.
pub(super) fn is_too_weak(node: &Node, white: &Region, clamp_m: f64, threshold: f64) -> bool {
    let greatest = GUARD * FRAC_1_PI * node.intensity.max_element();
    let apart = (node.min - white.max).max(white.min - node.max).max(DVec3::ZERO);
    // In the order of the bound's own roundings, so that it is never below the bound.
    let straight_on = greatest / apart.length_squared().max(clamp_m * clamp_m);
    straight_on < threshold || is_weak(potential(node, white, clamp_m), threshold)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        LightTree, Point,
        worlds::{self, CLAMP_M, Cloud},
    };
    use glam::Vec3;

    #[test]
    fn what_is_too_weak_straight_on_is_too_weak_by_its_bound() {
        let (mut culled, mut kept) = (0, 0);
        for (seed, emissions) in worlds::emissions().into_iter().enumerate() {
            let cloud = Cloud { lights: 200, emissions, seed: seed as u32, ..Cloud::default() };
            let tree = LightTree::median(&worlds::cloud(&cloud).world.lights).unwrap();
            let places = [0.0, 300.0, -70.0].map(|at| {
                let point = Point { normal: Vec3::Z, ..Point::default() };
                let at = DVec3::splat(at);
                white(&Region { min: at, max: at + 2.0, ..Region::at(&point) })
            });
            for (node, place) in tree.nodes.iter().flat_map(|n| places.map(|p| (n, p))) {
                // Parallel light is never asked for.
                if node.kind == crate::Emission::Directional.code() {
                    continue;
                }
                let bound = potential(node, &place, CLAMP_M);
                for threshold in [0.0, bound, bound.next_up(), 0.5 * bound, 1e-3, 1e-1] {
                    let weak = is_too_weak(node, &place, CLAMP_M, threshold);
                    assert_eq!(weak, is_weak(bound, threshold), "{node:?} {threshold}");
                    *(if weak { &mut culled } else { &mut kept }) += 1;
                }
            }
        }
        assert!(culled > 1000 && kept > 1000, "{culled} {kept}");
    }
}
