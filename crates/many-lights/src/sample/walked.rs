//! Trees as samplers see them: in f64 for the reference, in f32 as processors and devices hold them.
//! Choices are made by the same code over both; only what nodes are worth differs.

use crate::{
    BoundForm, Emission, LightTree, Node, PackedNode, PackedTree, Point,
    bound::{self, packed},
    light::{angle, luminance, luminance_f32},
};
use glam::{DVec3, Vec3};
use std::f64::consts::{FRAC_1_PI, FRAC_PI_2};
use std::sync::Arc;

/// Taken off every smallest angle of an importance, radians, in f64 and f32 alike: rounding must not
/// make a cluster worth nothing that holds a light worth something.
pub(super) const SLACK_RAD: f64 = 1e-4;

/// How clusters are bounded where a cut is made or a child is chosen by its bound.
const BOUND: BoundForm = BoundForm::Cheap;

/// What samplers ask of a tree; `node` is always one of its nodes.
pub(super) trait Walked: Sync {
    /// Nodes that hold all lights.
    fn roots(&self) -> &[u32];

    /// Nodes of the subtree: 1 for a light.
    fn size(&self, node: u32) -> u32;

    /// The light of a leaf.
    fn light(&self, node: u32) -> u32;

    /// What the light of a leaf gives, nothing between.
    fn radiance(&self, leaf: u32, point: &Point) -> DVec3;

    /// How much may come from the node, for drawing lights: of a leaf the luminance of what it gives,
    /// of a cluster the estimate of Conty Estevez and Kulla.
    fn importance(&self, node: u32, point: &Point) -> f64;

    /// The most that any channel can get from the node: of a leaf, what it gives.
    fn bound(&self, node: u32, point: &Point) -> f64;

    /// Whether any of its lights has any intensity.
    fn shines(&self, node: u32) -> bool;

    /// Squared distances to the nearest and the farthest point of the node's box, clamped from below;
    /// 1 for parallel light.
    fn distances_squared(&self, node: u32, point: &Point) -> [f64; 2];

    /// Bytes of the tree as it is walked.
    fn bytes(&self) -> u64;
}

/// A tree in f64.
#[derive(Debug)]
pub(super) struct Double {
    pub tree: Arc<LightTree>,
    pub clamp_m: f64,
}

/// A tree in f32.
#[derive(Debug)]
pub(super) struct Single {
    tree: PackedTree,
    clamp_squared: f32,
}

impl Single {
    pub fn new(tree: PackedTree, clamp_m: f64) -> Self {
        Self { tree, clamp_squared: packed::clamp_squared(clamp_m) }
    }

    fn node(&self, node: u32) -> &PackedNode {
        &self.tree.nodes[node as usize]
    }
}

impl Double {
    fn node(&self, node: u32) -> &Node {
        &self.tree.nodes[node as usize]
    }
}

impl Walked for Double {
    fn roots(&self) -> &[u32] {
        &self.tree.roots
    }

    fn size(&self, node: u32) -> u32 {
        self.node(node).size
    }

    fn light(&self, node: u32) -> u32 {
        self.node(node).light
    }

    fn radiance(&self, leaf: u32, point: &Point) -> DVec3 {
        bound::estimate(self.node(leaf), point, self.clamp_m)
    }

    fn importance(&self, node: u32, point: &Point) -> f64 {
        if self.size(node) == 1 {
            return luminance(self.radiance(node, point));
        }
        importance(self.node(node), point, self.clamp_m)
    }

    fn bound(&self, node: u32, point: &Point) -> f64 {
        if self.size(node) == 1 {
            return self.radiance(node, point).max_element();
        }
        bound::point(BOUND, self.node(node), point, self.clamp_m)
    }

    fn shines(&self, node: u32) -> bool {
        self.node(node).intensity != DVec3::ZERO
    }

    fn distances_squared(&self, node: u32, point: &Point) -> [f64; 2] {
        let node = self.node(node);
        if node.kind == Emission::Directional.code() {
            return [1.0; 2];
        }
        let position = point.position.as_dvec3();
        let (low, high) = (node.min - position, node.max - position);
        let near = low.max(-high).max(DVec3::ZERO).length_squared();
        let far = low.abs().max(high.abs()).length_squared();
        [near, far].map(|squared| squared.max(self.clamp_m * self.clamp_m))
    }

    fn bytes(&self) -> u64 {
        size_of_val(self.tree.nodes.as_slice()) as u64
    }
}

impl Walked for Single {
    fn roots(&self) -> &[u32] {
        &self.tree.roots
    }

    fn size(&self, node: u32) -> u32 {
        self.node(node).size
    }

    fn light(&self, node: u32) -> u32 {
        self.node(node).light
    }

    fn radiance(&self, leaf: u32, point: &Point) -> DVec3 {
        packed::estimate(self.node(leaf), point, self.clamp_squared).as_dvec3()
    }

    fn importance(&self, node: u32, point: &Point) -> f64 {
        let found = self.node(node);
        if found.size == 1 {
            return luminance_f32(packed::estimate(found, point, self.clamp_squared)).into();
        }
        packed_importance(found, point, self.clamp_squared).into()
    }

    fn bound(&self, node: u32, point: &Point) -> f64 {
        let found = self.node(node);
        if found.size == 1 {
            return packed::estimate(found, point, self.clamp_squared).max_element().into();
        }
        packed::point(BOUND, found, point, self.clamp_squared).into()
    }

    fn shines(&self, node: u32) -> bool {
        self.node(node).intensity != Vec3::ZERO
    }

    fn distances_squared(&self, node: u32, point: &Point) -> [f64; 2] {
        let node = self.node(node);
        if node.kind == Emission::Directional.code() {
            return [1.0; 2];
        }
        let (low, high) = (node.min - point.position, node.max - point.position);
        let near = low.max(-high).max(Vec3::ZERO).length_squared();
        let far = low.abs().max(high.abs()).length_squared();
        [near, far].map(|squared| squared.max(self.clamp_squared).into())
    }

    fn bytes(&self) -> u64 {
        size_of_val(self.tree.nodes.as_slice()) as u64
    }
}

/// Based on: A. Conty Estevez and C. Kulla, "Importance sampling of many lights with adaptive tree
/// splitting", 2018, the importance of a cluster: `energy · |cos θi'| · emission(θ') / d²`, θi' the smallest
/// angle between the normal and any direction into the sphere around the box, θ' that between an axis
/// of the cone and any direction from the sphere, d the distance to the sphere's centre.
/// Deviations: the surface shines to one side, so a cosine below 0 counts as 0; energy is the
/// luminance of intensity times albedo; emission is our lights' own, not a cosine; d is clamped from
/// below by the sphere's radius, as published, and by the distance that all estimates are clamped at.
fn importance(node: &Node, point: &Point, clamp_m: f64) -> f64 {
    let energy = FRAC_1_PI * luminance(point.albedo.as_dvec3() * node.intensity);
    let normal = point.normal.as_dvec3();
    if node.kind == Emission::Directional.code() {
        return energy * cosine(angle(normal, -node.axis) - node.cone_rad);
    }
    let position = point.position.as_dvec3();
    let (low, high) = (node.min - position, node.max - position);
    let centre = 0.5 * (low + high);
    let radius_squared = 0.25 * (high - low).length_squared();
    let squared = centre.length_squared();
    let over = squared.max(radius_squared).max(clamp_m * clamp_m);
    if squared <= radius_squared {
        return energy / over;
    }
    let direction = centre / squared.sqrt();
    let spread = (radius_squared / squared).sqrt().asin();
    let incident = cosine(angle(normal, direction) - spread);
    let emission = Emission::of(node.kind, node.half_angle_rad);
    let leaving = match emission {
        Emission::Omni => 1.0,
        _ => {
            let least = angle(node.axis, -direction) - node.cone_rad - spread - SLACK_RAD;
            emission.falloff(least.max(0.0))
        }
    };
    energy * incident * leaving / over
}

/// The cosine of a smallest angle, 1 where it is below 0, 0 from π/2 on.
fn cosine(angle_rad: f64) -> f64 {
    let least = (angle_rad - SLACK_RAD).max(0.0);
    if least >= FRAC_PI_2 { 0.0 } else { least.cos() }
}

/// [`importance`] in f32, operation for operation as `many-lights/light_bvh.wgsl` has it.
fn packed_importance(node: &PackedNode, point: &Point, clamp_squared: f32) -> f32 {
    const SLACK: f32 = SLACK_RAD as f32;
    let cosine = |angle: f32| packed::cosine_or_none((angle - SLACK).max(0.0));
    let energy = luminance_f32(point.albedo * node.intensity) * std::f32::consts::FRAC_1_PI;
    if node.kind == Emission::Directional.code() {
        return energy * cosine(packed::angle_between(point.normal, -node.axis) - node.cone_rad);
    }
    let (low, high) = (node.min - point.position, node.max - point.position);
    let centre = 0.5 * (low + high);
    let half = 0.5 * (high - low);
    let radius_squared = half.dot(half);
    let squared = centre.dot(centre);
    let over = squared.max(radius_squared).max(clamp_squared);
    if squared <= radius_squared {
        return energy / over;
    }
    let direction = centre / squared.sqrt();
    // The angle of a right triangle by its half chord: sin² / (2 (1 + cos)).
    let sine_squared = radius_squared / squared;
    let twice = 2.0 + 2.0 * (1.0 - sine_squared).max(0.0).sqrt();
    let spread = 2.0 * packed::arc_sine((sine_squared / twice).sqrt());
    let incident = cosine(packed::angle_between(point.normal, direction) - spread);
    if incident == 0.0 {
        return 0.0;
    }
    let mut leaving = 1.0;
    if node.kind != Emission::Omni.code() {
        let between = packed::angle_between(node.axis, -direction);
        let least = (between - node.cone_rad - spread - SLACK).max(0.0);
        leaving = if node.kind == Emission::Oriented.code() {
            packed::cosine_or_none(least)
        } else {
            (1.0 - least / node.half_angle_rad).max(0.0)
        };
    }
    energy * (incident * leaving / over)
}
