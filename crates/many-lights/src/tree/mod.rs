//! Light trees: lights clustered, in depth-first order with skip counts.

mod check;
mod fit;
mod keys;
mod median;
mod node;
mod shape;

pub use node::{LightTree, Node, PackedNode, PackedTree};

use crate::{Light, LightsError};
use shape::Place;

/// Most lights of a tree: node numbers stay far within 32 bits.
pub const MOST_LIGHTS: usize = 1 << 30;

/// How lights are clustered. Lights of different kinds never share a cluster.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Build<'a> {
    /// In halves along the longest axis: depth ⌈log₂ n⌉.
    Median,
    /// By one path a light, any length up to [`keys::MOST_LEVELS`]: lights with equal leading keys
    /// share a node at that level. Levels of a single child are left out.
    Keys(&'a [Vec<u32>]),
}

/// What stands for a cluster.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Representative {
    /// The mean position by luminance (all alike where all is 0), and the mean axis.
    #[default]
    Weighted,
    /// The representative of a child, drawn in proportion to its luminance: a real light.
    Random {
        /// Another one draws otherwise.
        seed: u64,
    },
    /// The real light nearest to the weighted position.
    Nearest,
}

impl LightTree {
    /// Clusters lights.
    ///
    /// # Errors
    /// A light that [`Light::check`] refuses, more than [`MOST_LIGHTS`], intensities whose sum is
    /// no number, another number of keys than lights, too long ones.
    pub fn build(
        lights: &[Light],
        build: Build<'_>,
        representative: Representative,
    ) -> Result<Self, LightsError> {
        check(lights)?;
        if let Build::Keys(keys) = build {
            keys::check(lights, keys)?;
        }
        let mut tree = Self { leaves: vec![0; lights.len()], ..Self::default() };
        for kind in 0..KINDS {
            let mut of_kind: Vec<u32> = (0..lights.len() as u32)
                .filter(|&light| lights[light as usize].emission.code() == kind)
                .collect();
            if of_kind.is_empty() {
                continue;
            }
            let places: Vec<Place> = match build {
                Build::Median => median::build(lights, &mut of_kind),
                Build::Keys(keys) => keys::build(keys, of_kind),
            };
            let root = tree.nodes.len() as u32;
            tree.roots.push(root);
            tree.nodes.extend(fit::fit(lights, &places, representative));
            for (index, place) in (root..).zip(&places).filter(|(_, p)| p.is_leaf()) {
                tree.leaves[place.light as usize] = index;
            }
        }
        Ok(tree)
    }

    /// Halves along the longest axis, weighted representatives.
    ///
    /// # Errors
    /// As [`Self::build`].
    pub fn median(lights: &[Light]) -> Result<Self, LightsError> {
        Self::build(lights, Build::Median, Representative::Weighted)
    }

    /// A given hierarchy, weighted representatives.
    ///
    /// # Errors
    /// As [`Self::build`].
    pub fn by_keys(lights: &[Light], keys: &[Vec<u32>]) -> Result<Self, LightsError> {
        Self::build(lights, Build::Keys(keys), Representative::Weighted)
    }
}

/// Kinds of emission.
const KINDS: u32 = 4;

fn check(lights: &[Light]) -> Result<(), LightsError> {
    if lights.len() > MOST_LIGHTS {
        let limit = format!("{} of at most {MOST_LIGHTS}", lights.len());
        return Err(LightsError::value("lights of a tree", limit));
    }
    let mut total = glam::DVec3::ZERO;
    for (index, light) in lights.iter().enumerate() {
        light.check(index)?;
        total += light.intensity;
    }
    if !total.is_finite() {
        return Err(LightsError::value("lights of a tree", "the sum of intensities is no number"));
    }
    Ok(())
}
