//! Where a pixel's error comes from.
//!
//! With r the radiance of a light at the pixel's point and V whether that sees it, in f64:
//! result - truth = leak + cut - irradiance - cull - shadow, exactly.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, sections 5.2.2 and 5.3 (what is
//! lost and what is added, told apart by eye).
//! Deviations: by numbers, against all lights with shadow rays.

use dapple_many_lights::{
    Absolute, LightTree, Point, World, bound,
    cut::{Receiver, Rule, Starts, walk},
    radiance,
};
use glam::DVec3;

/// What precuts of a point's object are.
#[derive(Clone, Copy, Debug)]
pub struct PointStarts<'a> {
    /// As it is lit.
    pub used: &'a [u32],
    /// With a threshold of 0: less what is hidden, and nothing else.
    pub seen: &'a [u32],
    /// Taken for hidden at the point's height, and so not in `used`; may be in `seen`.
    pub hidden: &'a [u32],
}

/// What a point starts at, and what it does not for its height: `used` and `hidden` of
/// [`PointStarts`].
pub fn at_height(starts: &Starts, point: &Point) -> [Vec<u32>; 2] {
    let mut nodes = [Vec::new(), Vec::new()];
    for (node, hidden_below) in starts.with_heights(starts.range(point.object)) {
        nodes[usize::from(point.position.y <= hidden_below)].push(node);
    }
    nodes
}

/// Parts of a pixel's error, linear RGB.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Parts {
    /// All lights with shadow rays.
    pub truth: DVec3,
    /// What the cut gives.
    pub result: DVec3,
    /// Seen by the pixel and taken for hidden from its cell: 0 in sound modes.
    pub cull: DVec3,
    /// Seen by the pixel and taken for too weak for its cell.
    pub irradiance: DVec3,
    /// What the cut adds beyond its lights; may be negative.
    pub cut: DVec3,
    /// Hidden from the pixel and added all the same.
    pub leak: DVec3,
    /// Seen by the pixel, and dropped with the cluster whose shadow ray did not arrive.
    pub shadow: DVec3,
    /// Lights of `cull`.
    pub culled: u32,
    /// Lights of `leak`.
    pub leaked: u32,
}

/// Takes apart what a point gets by R4 from its precut. `lit` has what casts shadows; `shadow_rays` is
/// whether the cut asks it too.
pub fn decompose(
    lit: &World,
    tree: &LightTree,
    cut: &Absolute,
    shadow_rays: bool,
    point: &Point,
    starts: PointStarts<'_>,
) -> Parts {
    let mut parts = Parts::default();
    let mut state = vec![State::Hidden; lit.lights.len()];
    mark(tree, starts.seen, &mut state, State::Weak);
    // Whatever is used was not hidden: thresholds only take away.
    mark(tree, starts.used, &mut state, State::Added);
    mark(tree, starts.hidden, &mut state, State::Hidden);
    let receiver = Receiver { point, form: cut.bound, clamp_m: lit.clamp_m };
    let rule = Rule::Absolute(cut.threshold);
    let mut dropped: Vec<u32> = Vec::new();
    walk(tree, starts.used.iter().copied(), |index, node| {
        let look = rule.look(node, &receiver);
        if look.taken {
            let is_seen = !shadow_rays
                || look.estimate == DVec3::ZERO
                || lit.sees(point, &lit.lights[node.light as usize]);
            if is_seen {
                parts.result += bound::estimate(node, point, lit.clamp_m);
            } else {
                dropped.push(index);
            }
        }
        look.taken
    });
    mark(tree, &dropped, &mut state, State::Dropped);
    let mut added = DVec3::ZERO;
    for (light, state) in lit.lights.iter().zip(state) {
        let radiance = radiance(point, light, lit.clamp_m);
        if radiance == DVec3::ZERO {
            continue;
        }
        let is_seen = lit.sees(point, light);
        if is_seen {
            parts.truth += radiance;
        }
        if state == State::Added {
            added += radiance;
        }
        match (state, is_seen) {
            (State::Added, true) | (State::Hidden | State::Weak | State::Dropped, false) => {}
            (State::Added, false) => {
                parts.leak += radiance;
                parts.leaked += 1;
            }
            (State::Hidden, true) => {
                parts.cull += radiance;
                parts.culled += 1;
            }
            (State::Weak, true) => parts.irradiance += radiance,
            (State::Dropped, true) => parts.shadow += radiance,
        }
    }
    parts.cut = parts.result - added;
    parts
}

/// What became of a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// Taken for hidden.
    Hidden,
    /// Taken for too weak.
    Weak,
    /// In the cut's clusters.
    Added,
    /// In a cluster that a shadow ray dropped.
    Dropped,
}

fn mark(tree: &LightTree, nodes: &[u32], state: &mut [State], as_what: State) {
    for &node in nodes {
        let end = node + tree.nodes[node as usize].size;
        for below in &tree.nodes[node as usize..end as usize] {
            if below.is_leaf() {
                state[below.light as usize] = as_what;
            }
        }
    }
}
