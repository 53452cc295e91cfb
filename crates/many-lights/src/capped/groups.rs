//! Lights of a tree in its order, which keeps neighbours together, and boxes around 32 at a time.
#![allow(clippy::needless_range_loop, reason = "lanes side by side become vectors")]

use crate::{
    BoundForm, Emission, PackedNode, PackedTree,
    bound::{
        branchless::{self, OMNI, ORIENTED, SPOT, greater},
        packed::{self, ALONG_SLACK, GUARD, NOWHERE, PackedRegion},
    },
};
use glam::Vec3;
use multiversion::multiversion;
use std::f32::consts::FRAC_1_PI;

/// Lights of a group, at most.
pub const FAN: usize = 32;

/// By how much cosines of groups are raised: rounding could take that much from them and not from
/// their lights'.
const RAISE: f32 = 1.0001;

/// Lights of one kind, number by number; those beyond its number are dark.
#[derive(Clone, Debug)]
struct Turned {
    kind: u32,
    min: [[f32; FAN]; 3],
    max: [[f32; FAN]; 3],
    intensity: [[f32; FAN]; 3],
    axis: [[f32; FAN]; 3],
    half_angle_rad: [f32; FAN],
}

/// All lights of a tree, and groups of them. Coordinates are one list an axis, so that many groups are
/// bounded at once.
#[derive(Clone, Debug, Default)]
pub struct Groups {
    /// The leaves, those of parallel light last.
    pub lights: Vec<PackedNode>,
    /// Where each light is among them.
    pub places: Vec<u32>,
    /// Where each group begins, and the end.
    pub first: Vec<u32>,
    /// Lower corners of the groups' boxes, metres.
    pub min: [Vec<f32>; 3],
    /// Upper corners.
    pub max: [Vec<f32>; 3],
    /// The greatest intensity of any of a group's lights, channel by channel.
    pub intensity: [Vec<f32>; 3],
    /// Groups of lights that have a place; parallel light comes after.
    placed: usize,
    /// The lights of each group, number by number.
    turned: Vec<Turned>,
}

impl Groups {
    /// The groups of a tree's lights.
    pub fn new(tree: &PackedTree) -> Self {
        let mut groups = Self::default();
        let parallel =
            |&&root: &&u32| tree.nodes[root as usize].kind == Emission::Directional.code();
        for root in tree.roots.iter().filter(|root| !parallel(root)) {
            groups.add(tree, *root);
        }
        groups.placed = groups.first.len();
        for root in tree.roots.iter().filter(parallel) {
            groups.add(tree, *root);
        }
        groups.first.push(groups.lights.len() as u32);
        groups.places = vec![0; groups.lights.len()];
        for (place, leaf) in (0..).zip(&groups.lights) {
            if let Some(of) = groups.places.get_mut(leaf.light as usize) {
                *of = place;
            }
        }
        groups
    }

    fn add(&mut self, tree: &PackedTree, root: u32) {
        let size = tree.nodes[root as usize].size;
        let below = &tree.nodes[root as usize..(root + size) as usize];
        let leaves: Vec<&PackedNode> = below.iter().filter(|node| node.size == 1).collect();
        for lights in leaves.chunks(FAN) {
            self.first.push(self.lights.len() as u32);
            for k in 0..3 {
                let of = |each: fn(&PackedNode) -> Vec3| lights.iter().map(move |l| each(l)[k]);
                self.min[k].push(of(|l| l.min).fold(f32::INFINITY, f32::min));
                self.max[k].push(of(|l| l.max).fold(f32::NEG_INFINITY, f32::max));
                self.intensity[k].push(of(|l| l.intensity).fold(0.0, f32::max));
            }
            self.lights.extend(lights.iter().copied());
            self.turned.push(Turned::of(lights));
        }
    }

    /// Lights of a group.
    pub fn of(&self, group: u32) -> &[PackedNode] {
        let [first, end] = [0, 1].map(|next| self.first[group as usize + next] as usize);
        &self.lights[first..end]
    }

    /// At least the bound of any light of each group over a region; `bounds` becomes one a group.
    ///
    /// What falls off with the angle is left out. All else is [`crate::bound::packed::region`]'s cheap
    /// form, which is nowhere below Walter's: boxes that hold others are nearer and reach farther along
    /// a normal, in f32 too, but for roundings that [`RAISE`] and three slacks instead of one make up
    /// for.
    pub fn bound(&self, over: &PackedRegion, clamp_squared: f32, bounds: &mut Vec<f32>) {
        bounds.resize(self.first.len().saturating_sub(1), 0.0);
        bound(self, over, clamp_squared, bounds);
    }

    /// Bounds of a group's lights over a region, Walter's form, and how many there are.
    pub fn bound_lights(
        &self,
        group: u32,
        over: &PackedRegion,
        clamp_squared: f32,
        bounds: &mut [f32; FAN],
    ) {
        let turned = &self.turned[group as usize];
        if turned.kind == Emission::Directional.code() {
            for (bound, light) in bounds.iter_mut().zip(self.of(group)) {
                *bound = packed::region(BoundForm::Walter, light, over, clamp_squared);
            }
        } else {
            bound_turned(turned, over, clamp_squared, bounds);
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        let words = self.places.len() + self.first.len() + 9 * self.first.len().saturating_sub(1);
        (size_of_val(&*self.lights) + size_of_val(&*self.turned) + 4 * words) as u64
    }
}

impl Turned {
    fn of(lights: &[&PackedNode]) -> Self {
        let none = [[0.0; FAN]; 3];
        let mut turned = Self {
            kind: lights.first().map_or(OMNI, |light| light.kind),
            min: none,
            max: none,
            intensity: none,
            axis: none,
            half_angle_rad: [1.0; FAN],
        };
        for (lane, light) in lights.iter().enumerate().take(FAN) {
            for k in 0..3 {
                turned.min[k][lane] = light.min[k];
                turned.max[k][lane] = light.max[k];
                turned.intensity[k][lane] = light.intensity[k];
                turned.axis[k][lane] = light.axis[k];
            }
            turned.half_angle_rad[lane] = light.half_angle_rad;
        }
        turned
    }

    #[inline(always)]
    fn light(&self, lane: usize) -> PackedNode {
        let vector = |of: &[[f32; FAN]; 3]| Vec3::new(of[0][lane], of[1][lane], of[2][lane]);
        PackedNode {
            min: vector(&self.min),
            max: vector(&self.max),
            intensity: vector(&self.intensity),
            axis: vector(&self.axis),
            half_angle_rad: self.half_angle_rad[lane],
            ..PackedNode::default()
        }
    }
}

#[multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512dq+avx512vl+avx2",
    "x86_64+avx2",
    "x86_64+sse4.1",
))]
fn bound_turned(lights: &Turned, over: &PackedRegion, clamp_squared: f32, bounds: &mut [f32; FAN]) {
    match (lights.kind, over.normal_spread_rad == 0.0) {
        (OMNI, true) => of_kind::<OMNI, true>(lights, over, clamp_squared, bounds),
        (OMNI, false) => of_kind::<OMNI, false>(lights, over, clamp_squared, bounds),
        (ORIENTED, true) => of_kind::<ORIENTED, true>(lights, over, clamp_squared, bounds),
        (ORIENTED, false) => of_kind::<ORIENTED, false>(lights, over, clamp_squared, bounds),
        (_, true) => of_kind::<SPOT, true>(lights, over, clamp_squared, bounds),
        (_, false) => of_kind::<SPOT, false>(lights, over, clamp_squared, bounds),
    }
}

#[inline(always)]
fn of_kind<const KIND: u32, const PLANAR: bool>(
    lights: &Turned,
    over: &PackedRegion,
    clamp_squared: f32,
    bounds: &mut [f32; FAN],
) {
    for lane in 0..FAN {
        let light = lights.light(lane);
        bounds[lane] = branchless::region::<KIND, false, PLANAR>(&light, over, clamp_squared);
    }
}

#[multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512dq+avx512vl+avx2",
    "x86_64+avx2",
    "x86_64+sse4.1",
))]
fn bound(groups: &Groups, over: &PackedRegion, clamp_squared: f32, bounds: &mut [f32]) {
    let count = bounds.len();
    let [ax, ay, az] = [0, 1, 2].map(|k| &groups.min[k][..count]);
    let [bx, by, bz] = [0, 1, 2].map(|k| &groups.max[k][..count]);
    let [r, g, b] = [0, 1, 2].map(|k| &groups.intensity[k][..count]);
    let (min, max, n, albedo) = (over.min, over.max, over.normal_axis, over.albedo);
    let planar = over.normal_spread_rad == 0.0;
    let placed = groups.placed.min(count);
    for i in 0..placed {
        let low = [ax[i] - max.x, ay[i] - max.y, az[i] - max.z];
        let high = [bx[i] - min.x, by[i] - min.y, bz[i] - min.z];
        let (mut squared, mut along, mut farthest) = (0.0, 0.0, 0.0);
        for k in 0..3 {
            let outside = greater(greater(low[k], -high[k]), 0.0);
            squared += outside * outside;
            along += greater(n[k] * low[k], n[k] * high[k]);
            farthest += greater(low[k].abs(), high[k].abs());
        }
        let along = along + 3.0 * ALONG_SLACK * farthest;
        let ratio = greater(along, 0.0) / squared.sqrt();
        // What is no number, of a box that holds everything, counts as 1.
        let cosine = if planar && squared > 2.0 * NOWHERE && ratio < 1.0 { ratio } else { 1.0 };
        let intensity = greater(greater(albedo.x * r[i], albedo.y * g[i]), albedo.z * b[i]);
        let greatest = GUARD * FRAC_1_PI * intensity;
        bounds[i] = greatest * (RAISE * cosine / greater(squared, clamp_squared));
    }
    for i in placed..count {
        let intensity = greater(greater(albedo.x * r[i], albedo.y * g[i]), albedo.z * b[i]);
        bounds[i] = GUARD * FRAC_1_PI * intensity * RAISE;
    }
}
