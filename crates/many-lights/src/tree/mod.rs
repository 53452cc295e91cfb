//! Light trees: lights clustered, in depth-first order with skip counts.

mod along;
mod check;
pub mod city;
mod cluster;
mod cones;
mod fit;
mod greedy;
mod joined;
mod keys;
mod locally_ordered;
mod median;
mod moved;
mod nearest;
mod node;
mod order;
mod shape;
mod surface_area;

pub use joined::Extent;
pub use node::{LightTree, Node, PackedNode, PackedTree};

use crate::{Light, LightsError, light::Emission};
use cluster::{Cluster, Metric};
use shape::Place;

/// Most lights of a tree: node numbers stay far within 32 bits.
pub const MOST_LIGHTS: usize = 1 << 30;

/// How lights are clustered. Lights of different kinds never share a cluster.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Build<'a> {
    /// The best of all pairs is joined first (Walter et al. 2005). `spread` scales the weight of
    /// directions against places, 1 by default. Binary; seconds for tens of thousands.
    Greedy {
        /// At least 0.
        spread: f64,
    },
    /// The same metric among neighbours along a Morton curve (Meister and Bittner 2018). Binary.
    LocallyOrdered {
        /// At least 0.
        spread: f64,
    },
    /// [`Build::Greedy`] for up to [`EXACT`] lights of a kind, [`Build::LocallyOrdered`] above.
    Original {
        /// At least 0.
        spread: f64,
    },
    /// In halves along the longest axis: depth ⌈log₂ n⌉.
    Median,
    /// By one path a light, any length up to [`keys::MOST_LEVELS`]: lights with equal leading keys
    /// share a node at that level. Levels of a single child are left out.
    Keys(&'a [Vec<u32>]),
    /// From the top, where surface, directions and intensity of both sides promise the least (Conty
    /// Estevez and Kulla 2018): for lights that are drawn by chance. Binary.
    SurfaceArea,
}

/// Most lights of a kind whose tree [`Build::Original`] makes exactly.
pub const EXACT: usize = 20_000;

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
    /// A light that [`Light::check`] refuses, more than [`MOST_LIGHTS`], another number of keys than
    /// lights, too long ones, a `spread` that is not at least 0.
    pub fn build(
        lights: &[Light],
        build: Build<'_>,
        representative: Representative,
    ) -> Result<Self, LightsError> {
        check(lights)?;
        match build {
            Build::Keys(keys) => keys::check(lights, keys)?,
            Build::Greedy { spread }
            | Build::LocallyOrdered { spread }
            | Build::Original { spread }
                if !(spread >= 0.0 && spread.is_finite()) =>
            {
                return Err(LightsError::value("spread", format!("{spread} is not at least 0")));
            }
            _ => {}
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
                Build::Original { spread } if of_kind.len() <= EXACT => {
                    joined(lights, &of_kind, spread, greedy::merges)
                }
                Build::Greedy { spread } => joined(lights, &of_kind, spread, greedy::merges),
                Build::LocallyOrdered { spread } | Build::Original { spread } => {
                    joined(lights, &of_kind, spread, locally_ordered::merges)
                }
                Build::Median => median::build(lights, &mut of_kind),
                Build::Keys(keys) => keys::build(keys, of_kind),
                Build::SurfaceArea => surface_area::build(lights, &of_kind),
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

    /// As the tree of Walter et al. 2005: the best of all pairs is joined first where there are at most
    /// [`EXACT`] lights of a kind, and among neighbours where there are more.
    ///
    /// # Errors
    /// As [`Self::build`].
    pub fn original(lights: &[Light], representative: Representative) -> Result<Self, LightsError> {
        Self::build(lights, Build::Original { spread: 1.0 }, representative)
    }

    /// A given hierarchy, weighted representatives.
    ///
    /// # Errors
    /// As [`Self::build`].
    pub fn by_keys(lights: &[Light], keys: &[Vec<u32>]) -> Result<Self, LightsError> {
        Self::build(lights, Build::Keys(keys), Representative::Weighted)
    }
}

/// The tree that joins of one kind's lights make.
fn joined(
    lights: &[Light],
    ids: &[u32],
    spread: f64,
    merges: fn(&Metric, Vec<Cluster>) -> Vec<shape::Merge>,
) -> Vec<Place> {
    let of = |&id: &u32| &lights[id as usize];
    let clusters: Vec<Cluster> = ids.iter().map(|id| Cluster::of(of(id))).collect();
    let kind = ids.first().map_or(Emission::Omni, |id| of(id).emission);
    let metric = Metric::of(&clusters, kind, spread);
    shape::from_merges(ids, &merges(&metric, clusters))
}

/// Kinds of emission.
const KINDS: u32 = 4;

fn check(lights: &[Light]) -> Result<(), LightsError> {
    if lights.len() > MOST_LIGHTS {
        let limit = format!("{} of at most {MOST_LIGHTS}", lights.len());
        return Err(LightsError::value("lights of a tree", limit));
    }
    for (index, light) in lights.iter().enumerate() {
        light.check(index)?;
    }
    Ok(())
}
