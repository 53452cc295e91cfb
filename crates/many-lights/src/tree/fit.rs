//! Nodes of a tree whose shape is known.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 3.3, Eq. 3.1
//! (weighted representatives); B. Walter et al., "Lightcuts: a scalable approach to illumination",
//! 2005, section 4 (random ones).
//! Deviations: see [`super::Node`] for axes and cones.

use super::{Node, Representative, cones::turn, shape::Place};
use crate::{
    Light, cut,
    light::luminance,
    sample::{Random, hash},
};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Subtrees of so many nodes are one piece of parallel work.
const PIECE: u32 = 4096;

/// What is known of a cluster beside its node while a tree is fitted.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Mean {
    /// Position, weighted by luminance.
    pub position: DVec3,
    /// Axis, likewise; shorter than 1 where axes differ.
    pub axis: DVec3,
    /// Luminance.
    pub weight: f64,
    /// Lights.
    pub count: f64,
}

impl Mean {
    fn of(light: &Light) -> Self {
        let axis = light.axis.normalize_or_zero();
        Self { position: light.position, axis, weight: light.luminance(), count: 1.0 }
    }

    /// The mean of means: by weight, or by number where there is no weight.
    pub fn over(parts: impl Iterator<Item = Self> + Clone) -> Self {
        let (weight, count) = parts
            .clone()
            .fold((0.0, 0.0), |(weight, count), part| (weight + part.weight, count + part.count));
        let mut all = Self { weight, count, ..Self::default() };
        for part in parts {
            let share = if weight > 0.0 { part.weight / weight } else { part.count / count };
            all.position += part.position * share;
            all.axis += part.axis * share;
        }
        all
    }
}

/// Children of a node, in order.
pub(super) fn children(nodes: &[Node], index: usize) -> impl Iterator<Item = usize> + Clone {
    let size = |node: u32| nodes[node as usize].size;
    cut::children(index as u32, size).map(|child| child as usize)
}

/// All nodes of one kind's tree. `places` has at least one.
pub(super) fn fit(lights: &[Light], places: &[Place], representative: Representative) -> Vec<Node> {
    let mut nodes: Vec<Node> = places.par_iter().map(|place| empty(lights, place)).collect();
    let mut means = vec![Mean::default(); nodes.len()];
    sum_up(lights, &mut nodes, &mut means, representative);
    turn(lights, places, &mut nodes, &means, representative);
    nodes
}

/// A node that knows only its light or its size.
fn empty(lights: &[Light], place: &Place) -> Node {
    let size = place.size;
    if place.is_leaf() {
        return leaf(&lights[place.light as usize], place.light);
    }
    Node {
        min: DVec3::ZERO,
        max: DVec3::ZERO,
        position: DVec3::ZERO,
        intensity: DVec3::ZERO,
        axis: DVec3::Y,
        cone_rad: PI,
        half_angle_rad: 0.0,
        kind: 0,
        size,
        light: place.light,
    }
}

/// The node of a single light.
pub(super) fn leaf(light: &Light, index: u32) -> Node {
    Node {
        min: light.position,
        max: light.position,
        position: light.position,
        intensity: light.intensity,
        axis: light.axis,
        cone_rad: 0.0,
        half_angle_rad: light.emission.half_angle_rad(),
        kind: light.emission.code(),
        size: 1,
        light: index,
    }
}

/// Boxes, sums and means, from the leaves up; small subtrees side by side.
fn sum_up(
    lights: &[Light],
    nodes: &mut [Node],
    means: &mut [Mean],
    representative: Representative,
) {
    let mut pieces = Vec::new();
    let mut above = Vec::new();
    {
        let (mut nodes, mut means) = (&mut *nodes, &mut *means);
        let mut offset = 0;
        while let Some(node) = nodes.first() {
            let piece = if node.size <= PIECE { node.size as usize } else { 1 };
            if node.size > PIECE {
                above.push(offset);
            }
            let (these_nodes, these_means);
            (these_nodes, nodes) = nodes.split_at_mut(piece);
            (these_means, means) = means.split_at_mut(piece);
            if piece > 1 || these_nodes[0].is_leaf() {
                pieces.push((offset, these_nodes, these_means));
            }
            offset += piece;
        }
        pieces.into_par_iter().for_each(|(offset, nodes, means)| {
            for index in (0..nodes.len()).rev() {
                sum_node(lights, nodes, means, index, offset, representative);
            }
        });
    }
    for index in above.into_iter().rev() {
        sum_node(lights, nodes, means, index, 0, representative);
    }
}

/// One node, its children being known. `offset` is the place of `nodes[0]` in the tree.
fn sum_node(
    lights: &[Light],
    nodes: &mut [Node],
    means: &mut [Mean],
    index: usize,
    offset: usize,
    representative: Representative,
) {
    if nodes[index].is_leaf() {
        means[index] = Mean::of(&lights[nodes[index].light as usize]);
        return;
    }
    means[index] = Mean::over(children(nodes, index).map(|child| means[child]));
    gather(nodes, index);
    let node = &mut nodes[index];
    node.position = means[index].position.clamp(node.min, node.max);
    if let Representative::Random { seed } = representative {
        let light = drawn(nodes, index, seed, offset + index);
        stand_for(&mut nodes[index], lights, light);
    }
}

/// Box, intensity, kind and half angle from the children.
pub(super) fn gather(nodes: &mut [Node], index: usize) {
    let mut node = nodes[index];
    (node.min, node.max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    (node.intensity, node.half_angle_rad) = (DVec3::ZERO, 0.0);
    for child in children(nodes, index) {
        let child = &nodes[child];
        (node.min, node.max) = (node.min.min(child.min), node.max.max(child.max));
        node.intensity += child.intensity;
        node.half_angle_rad = node.half_angle_rad.max(child.half_angle_rad);
        node.kind = child.kind;
    }
    nodes[index] = node;
}

/// The light that stands for one of the children, drawn by luminance; all alike where all are dark.
pub(super) fn drawn(nodes: &[Node], index: usize, seed: u64, number: usize) -> u32 {
    let weight = |child: usize| luminance(nodes[child].intensity);
    let total: f64 = children(nodes, index).map(weight).sum();
    let count = children(nodes, index).count() as f64;
    let mut random = Random::new(seed as u32, hash((seed >> 32) as u32), number as u32);
    // 53 bits, so that no light is too dim to be drawn.
    let bits = u64::from(random.bits()) << 32 | u64::from(random.bits());
    let mut left = (bits >> 11) as f64 / (1_u64 << 53) as f64;
    let mut last = index;
    for child in children(nodes, index) {
        let share = if total > 0.0 { weight(child) / total } else { 1.0 / count };
        if share > 0.0 {
            last = child;
            if left < share {
                break;
            }
            left -= share;
        }
    }
    nodes[last].light
}

/// Makes a real light the representative. What is left is the cone.
pub(super) fn stand_for(node: &mut Node, lights: &[Light], light: u32) {
    let real = &lights[light as usize];
    (node.light, node.position, node.axis) = (light, real.position, real.axis);
}
