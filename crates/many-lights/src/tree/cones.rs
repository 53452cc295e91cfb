//! Axes and cones of clusters, and the lights that stand for them.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 3.1, Table 3.I.
//! Deviations: see [`super::Node`].

use super::{
    Node, Representative,
    fit::{Mean, stand_for},
    shape::Place,
};
use crate::{
    Light,
    light::{Emission, angle},
};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Mean axes shorter than this cancel.
pub(super) const CANCELS: f64 = 1e-6;

/// Lights of all leaves, in the tree's order.
struct Leaves {
    positions: Vec<DVec3>,
    axes: Vec<DVec3>,
    lights: Vec<u32>,
}

/// Axes, cones and the lights that stand for clusters, each over all lights below: a pass over the
/// leaves for each level.
pub(super) fn turn(
    lights: &[Light],
    places: &[Place],
    nodes: &mut [Node],
    means: &[Mean],
    representative: Representative,
) {
    let ids: Vec<u32> = places.iter().filter(|p| p.is_leaf()).map(|p| p.light).collect();
    let of = |&id: &u32| &lights[id as usize];
    let leaves = Leaves {
        positions: ids.iter().map(|id| super::median::place_of(of(id))).collect(),
        axes: ids.iter().map(|id| of(id).axis.normalize_or_zero()).collect(),
        lights: ids,
    };
    let mut before = 0;
    let first: Vec<u32> = places
        .iter()
        .map(|place| {
            let first = before;
            before += u32::from(place.is_leaf());
            first
        })
        .chain([leaves.lights.len() as u32])
        .collect();
    nodes.par_iter_mut().enumerate().filter(|(_, node)| !node.is_leaf()).for_each(
        |(index, node)| {
            let below = first[index] as usize..first[index + node.size as usize] as usize;
            let mean_axis = means[index].axis;
            match representative {
                Representative::Weighted => {
                    node.axis = mean_axis.try_normalize().unwrap_or(DVec3::Y);
                    // Parallel light is where its axis is.
                    let directional = node.kind == Emission::Directional.code();
                    let centre = if directional { mean_axis } else { node.position };
                    node.light = leaves.nearest(below.clone(), centre);
                }
                Representative::Nearest => {
                    let directional = node.kind == Emission::Directional.code();
                    let centre = if directional { mean_axis } else { node.position };
                    stand_for(node, lights, leaves.nearest(below.clone(), centre));
                }
                Representative::Random { .. } => {}
            }
            let cancels =
                representative == Representative::Weighted && mean_axis.length() < CANCELS;
            node.cone_rad =
                cone(node, cancels, || leaves.widest(below, node.axis.normalize_or_zero()));
        },
    );
}

/// Half the opening of a cluster's cone. π is for axes that cancel, and for light to all sides, alone:
/// there, estimates forget the direction.
pub(super) fn cone(node: &Node, cancels: bool, widest: impl FnOnce() -> f64) -> f64 {
    if cancels || node.kind == Emission::Omni.code() { PI } else { widest().min(PI.next_down()) }
}

impl Leaves {
    /// The light nearest to a place, the first of several.
    fn nearest(&self, below: std::ops::Range<usize>, centre: DVec3) -> u32 {
        let mut best = (f64::INFINITY, u32::MAX);
        for (position, &light) in self.positions[below.clone()].iter().zip(&self.lights[below]) {
            let squared = position.distance_squared(centre);
            if squared < best.0 || (squared == best.0 && light < best.1) {
                best = (squared, light);
            }
        }
        best.1
    }

    /// The greatest angle of an axis from `axis`, radians. Which one is widest is told by the chord to
    /// the axis, or, beyond a right angle, to its opposite: each is exact where it is short.
    fn widest(&self, below: std::ops::Range<usize>, axis: DVec3) -> f64 {
        let axes = &self.axes[below];
        let mut widest = (0.0, axis);
        for &other in axes {
            let chord = other.distance_squared(axis);
            if chord > widest.0 {
                widest = (chord, other);
            }
        }
        if widest.0 > 2.0 {
            let mut closest = f64::INFINITY;
            for &other in axes {
                let chord = other.distance_squared(-axis);
                if chord < closest {
                    (closest, widest.1) = (chord, other);
                }
            }
        }
        angle(axis, widest.1)
    }
}
