//! Nodes of light trees.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 3.1, Table 3.I.
//! Deviations: the thesis leaves direction and cone of a cluster open: here the axis is the
//! normalised sum of luminance times axis over the lights (over all alike where none gives light), and
//! the cone holds every light's axis.
//! Lights of different kinds of emission never share a node, so that a bound is that of one kind:
//! a tree is a few trees, one a kind, their roots listed.

use crate::{Light, light::angle};
use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::f64::consts::PI;

/// A light or a cluster of lights of one kind. Local space, f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// The smallest box that holds the lights' positions.
    pub min: DVec3,
    /// Its upper corner.
    pub max: DVec3,
    /// Position of the representative, inside the box.
    pub position: DVec3,
    /// Sum of the lights' intensities.
    pub intensity: DVec3,
    /// Axis of the cone of axes, unit length (any for omni); the light's own where a real light is the
    /// representative.
    pub axis: DVec3,
    /// Half the cone's opening, radians: every light's axis lies within. 0 for a leaf; π for clusters
    /// of omni lights and where axes cancel (the sum is below 1e-6 of what it would be if all
    /// agreed), and nowhere else.
    pub cone_rad: f64,
    /// The greatest of the lights' half angles, radians ([`crate::Emission::half_angle_rad`]).
    pub half_angle_rad: f64,
    /// The lights' kind, [`crate::Emission::code`].
    pub kind: u32,
    /// Nodes of the subtree, this one included: 1 for a leaf.
    pub size: u32,
    /// The light of a leaf; of a cluster the light that stands for it where one has to be real (a
    /// shadow ray): the representative, or, where that is a mean, the nearest of its own to it (of
    /// parallel light the one nearest to the mean axis).
    pub light: u32,
}

/// Trees in depth-first order: the subtree of node `i` is `i .. i + size`, its first child `i + 1`.
#[derive(Clone, Debug, Default)]
pub struct LightTree {
    /// All nodes.
    pub nodes: Vec<Node>,
    /// One a kind of emission, in increasing order; empty without lights.
    pub roots: Vec<u32>,
    /// Node of each light.
    pub leaves: Vec<u32>,
}

/// A node as processors and devices walk it in f32. 80 bytes, 5 x 16.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PackedNode {
    /// Representative's position.
    pub position: Vec3,
    /// Half the opening of the cone of axes, radians, rounded up, of a cluster also widened by
    /// what the axis turned when it was rounded; the f32 next to π where axes cancel alone.
    pub cone_rad: f32,
    /// Summed intensity.
    pub intensity: Vec3,
    /// Nodes of the subtree.
    pub size: u32,
    /// Axis of the cone.
    pub axis: Vec3,
    /// The lights' greatest half angle, radians.
    pub half_angle_rad: f32,
    /// Lower corner, rounded down.
    pub min: Vec3,
    /// As [`Node::light`].
    pub light: u32,
    /// Upper corner, rounded up.
    pub max: Vec3,
    /// As [`Node::kind`].
    pub kind: u32,
}

/// The same tree in f32.
#[derive(Clone, Debug, Default)]
pub struct PackedTree {
    /// All nodes, in the same order.
    pub nodes: Vec<PackedNode>,
    /// As [`LightTree::roots`].
    pub roots: Vec<u32>,
}

impl Node {
    /// Whether it is a single light.
    pub fn is_leaf(&self) -> bool {
        self.size == 1
    }
}

impl PackedNode {
    /// The leaf of a light.
    pub fn of(light: &Light, index: u32) -> Self {
        super::fit::leaf(light, index).pack()
    }

    /// The same numbers in f64.
    pub fn unpack(&self) -> Node {
        Node {
            min: self.min.as_dvec3(),
            max: self.max.as_dvec3(),
            position: self.position.as_dvec3(),
            intensity: self.intensity.as_dvec3(),
            axis: self.axis.as_dvec3(),
            cone_rad: f64::from(self.cone_rad),
            half_angle_rad: f64::from(self.half_angle_rad),
            kind: self.kind,
            size: self.size,
            light: self.light,
        }
    }
}

impl LightTree {
    /// The tree in f32: boxes and cones are rounded outwards, so that they still hold what they held.
    pub fn pack(&self) -> PackedTree {
        let nodes = self.nodes.par_iter().map(Node::pack).collect();
        PackedTree { nodes, roots: self.roots.clone() }
    }
}

impl Node {
    /// The node in f32, as in [`LightTree::pack`].
    pub fn pack(&self) -> PackedNode {
        let axis = self.axis.normalize_or(DVec3::Z).as_vec3();
        PackedNode {
            position: self.position.as_vec3(),
            cone_rad: self.packed_cone(axis),
            intensity: self.intensity.as_vec3(),
            size: self.size,
            axis,
            half_angle_rad: up(self.half_angle_rad),
            min: -outwards(-self.min),
            light: self.light,
            max: outwards(self.max),
            kind: self.kind,
        }
    }

    fn packed_cone(&self, axis: Vec3) -> f32 {
        if self.is_leaf() || self.cone_rad >= PI {
            return up(self.cone_rad);
        }
        // The f32 next to π is above it: below that, axes do not cancel.
        let widened = self.cone_rad + angle(self.axis, axis.as_dvec3());
        up(widened).min(std::f32::consts::PI.next_down())
    }
}

/// The least f32 that is not below `value`.
fn up(value: f64) -> f32 {
    let rounded = value as f32;
    if f64::from(rounded) < value { rounded.next_up() } else { rounded }
}

fn outwards(corner: DVec3) -> Vec3 {
    Vec3::new(up(corner.x), up(corner.y), up(corner.z))
}
