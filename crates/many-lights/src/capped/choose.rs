//! The strongest lights: bounds of all groups at once, then of the lights of those groups that may
//! matter, the largest bound first.
//!
//! A group's bound is at least the bound of each of its lights. So when as many lights as are wanted are
//! known with bounds of at least some limit, groups below the limit are of no interest, whatever the
//! limit came from; here it comes from the lights that were chosen before, of the tile next to this
//! one, and rises while lights are looked at. Which lights are chosen depends on neither limit nor
//! groups. Cones of clusters are of no use for that: what bounds the light that a cluster gives may lie
//! below the bound of one of its lights by its own axis.

use super::{FAN, Groups};
use crate::{
    BoundForm,
    bound::packed::{PackedRegion, region},
};

/// Lights chosen, and what a choice needs while it is made; it keeps its memory.
#[derive(Clone, Debug, Default)]
pub struct Choice {
    /// Indices of lights, in increasing order.
    pub lights: Vec<u32>,
    /// Bounds that were evaluated, of groups and of lights.
    pub bounds: u64,
    /// Whether the cap left out a light or group that may give something.
    pub ended: bool,
    /// Bounds of the groups.
    groups: Vec<f32>,
    /// Groups that may matter: the bound's bits above, the number below.
    open: Vec<u64>,
    /// Lights: the bound's bits above, the index below, counted down: the largest is the strongest.
    found: Vec<u64>,
}

impl Choice {
    /// The bound of the weakest of the lights chosen before, over this region: 0 where there were fewer.
    fn known(
        &mut self,
        groups: &Groups,
        over: &PackedRegion,
        most: usize,
        clamp_squared: f32,
    ) -> f32 {
        let earlier = std::mem::take(&mut self.lights);
        let mut least = if earlier.len() == most { f32::INFINITY } else { 0.0 };
        for &light in &earlier {
            if least == 0.0 {
                break;
            }
            let Some(&place) = groups.places.get(light as usize) else { return 0.0 };
            let leaf = &groups.lights[place as usize];
            least = least.min(region(BoundForm::Walter, leaf, over, clamp_squared));
            self.bounds += 1;
        }
        self.lights = earlier;
        if least.is_finite() { least } else { 0.0 }
    }

    /// Keeps the strongest of those found: the bound of the weakest of them, once there are `most`.
    fn keep(&mut self, most: usize) -> f32 {
        if most == 0 || self.found.len() < most {
            return 0.0;
        }
        let (_, weakest, _) = self.found.select_nth_unstable_by(most - 1, |a, b| b.cmp(a));
        let bound = f32::from_bits((*weakest >> 32) as u32);
        self.ended |= self.found.len() > most;
        self.found.truncate(most);
        bound
    }
}

/// Chooses the `most` lights with the largest bounds over a region, of equal ones those of lowest
/// index. The lights that `choice` holds from before save time where the region is near theirs.
pub fn strongest(
    groups: &Groups,
    over: &PackedRegion,
    most: usize,
    clamp_squared: f32,
    choice: &mut Choice,
) {
    choice.bounds = 0;
    let mut limit = choice.known(groups, over, most, clamp_squared);
    groups.bound(over, clamp_squared, &mut choice.groups);
    choice.bounds += choice.groups.len() as u64;
    choice.ended = false;
    choice.open.clear();
    for (group, &bound) in (0_u64..).zip(&choice.groups) {
        // Bounds are not negative: their bits are in their order.
        if bound > 0.0 && bound >= limit {
            choice.open.push(u64::from(bound.to_bits()) << 32 | group);
        } else {
            choice.ended |= bound > 0.0;
        }
    }
    choice.open.sort_unstable_by(|a, b| b.cmp(a));
    choice.found.clear();
    let mut bounds = [0.0; FAN];
    let enough = most.saturating_mul(2).saturating_add(FAN);
    for at in 0..choice.open.len() {
        let group = choice.open[at];
        if f32::from_bits((group >> 32) as u32) < limit {
            choice.ended = true;
            break;
        }
        groups.bound_lights(group as u32, over, clamp_squared, &mut bounds);
        let lights = groups.of(group as u32);
        choice.bounds += lights.len() as u64;
        for (leaf, &bound) in lights.iter().zip(&bounds) {
            if bound > 0.0 && bound >= limit {
                let last = u64::from(u32::MAX - leaf.light);
                choice.found.push(u64::from(bound.to_bits()) << 32 | last);
            } else {
                choice.ended |= bound > 0.0;
            }
        }
        if choice.found.len() >= enough {
            limit = limit.max(choice.keep(most));
        }
    }
    choice.keep(most);
    choice.lights.clear();
    choice.lights.extend(choice.found.iter().map(|key| u32::MAX - *key as u32));
    choice.lights.sort_unstable();
}
