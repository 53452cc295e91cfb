//! Boxes of gap-free runs: as high as their lowest member.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 4.2.2 (occluders
//! that touch are grouped first).
//! Deviations: the thesis's groups are bounding boxes, which fill what is open. These lie within
//! what stands there: a run is as wide as its members together, as deep as what they share, as high as
//! its lowest; each member begins the longest run of those at least as high. Members stay besides.

use super::gaps::{Placed, Plan, followers, shared};
use crate::region::Solid;
use std::collections::BTreeSet;

/// A run shares at least so much of the depth of its lowest member.
const LEAST_DEPTH: f64 = 0.5;

/// Boxes of the longest runs along turned x and z of which a member is the lowest.
pub fn runs(placed: &[Placed], plan: &Plan) -> Vec<Solid> {
    let mut known = BTreeSet::new();
    let mut solids = vec![];
    for axis in [0, 2] {
        let after = followers(placed, axis);
        let mut before: Vec<Vec<u32>> = vec![vec![]; placed.len()];
        for (i, list) in (0..).zip(&after) {
            list.iter().for_each(|&j| before[j as usize].push(i));
        }
        for lowest in 0..placed.len() {
            let mut run = Run::of(placed, lowest, axis);
            while run.grow(placed, plan, &after, true) {}
            while run.grow(placed, plan, &before, false) {}
            let solid = run.solid;
            let bits = [solid.min, solid.max].map(|v| v.to_array().map(f64::to_bits));
            if run.ends[0] != run.ends[1] && known.insert(bits) {
                solids.push(solid);
            }
        }
    }
    solids
}

/// A run while it grows.
struct Run {
    axis: usize,
    /// The first and the last member.
    ends: [usize; 2],
    solid: Solid,
    top: f64,
    least_depth: f64,
}

impl Run {
    fn of(placed: &[Placed], lowest: usize, axis: usize) -> Self {
        let solid = placed[lowest].solid;
        let [near, far] = placed[lowest].side(2 - axis);
        let least_depth = LEAST_DEPTH * (far - near);
        Self { axis, ends: [lowest; 2], solid, top: solid.max.y, least_depth }
    }

    /// Takes in the neighbour beyond one end that shares most depth, of several the first.
    fn grow(
        &mut self,
        placed: &[Placed],
        plan: &Plan,
        neighbours: &[Vec<u32>],
        onwards: bool,
    ) -> bool {
        let (axis, across) = (self.axis, 2 - self.axis);
        let own = [self.solid.min[across], self.solid.max[across]];
        let end = self.ends[usize::from(onwards)];
        let mut best: Option<(f64, usize, [f64; 2])> = None;
        for &next in &neighbours[end] {
            let next = next as usize;
            let (a, b) = if onwards { (end, next) } else { (next, end) };
            let range = shared(own, placed[next].side(across));
            let depth = range[1] - range[0];
            let enough = depth >= self.least_depth && best.is_none_or(|(most, ..)| depth > most);
            let high = placed[next].solid.max.y >= self.top;
            let stands = placed[next].solid.min.y.max(self.solid.min.y) < self.top;
            if enough && high && stands && plan.is_solid(&placed[a], &placed[b], axis, range) {
                best = Some((depth, next, range));
            }
        }
        let Some((_, next, range)) = best else { return false };
        self.ends[usize::from(onwards)] = next;
        let other = &placed[next].solid;
        self.solid.min[across] = range[0];
        self.solid.max[across] = range[1];
        self.solid.min.y = self.solid.min.y.max(other.min.y);
        if onwards {
            self.solid.max[axis] = self.solid.max[axis].max(other.max[axis]);
        } else {
            self.solid.min[axis] = self.solid.min[axis].min(other.min[axis]);
        }
        true
    }
}
