//! What a cluster may give at most, and when that is too weak.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 5.3.2 (cull by
//! potential irradiance).
//! Deviations: radiance of a white surface, by the bound of cuts over a region.

use crate::{
    BoundForm, Node,
    bound::{self, Region},
};
use glam::DVec3;

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
