//! Trees along the sidewalks.

use super::layout::{Layout, SIDEWALK_M, rounded};
use crate::city::Tree;
use glam::DVec3;
use rand::RngExt;
use rand_pcg::Pcg64;

/// `per_block` trees a block, evenly along its two long sidewalks, each of its own size.
pub fn trees(layout: &Layout, per_block: u32, rng: &mut Pcg64) -> Vec<Tree> {
    let mut trees = vec![];
    for index in 0..layout.rows * layout.columns {
        let [min, max] = layout.slab(index / layout.columns, index % layout.columns);
        for i in 0..per_block {
            let pairs = per_block.div_ceil(2);
            let along = (f64::from(i / 2) + 0.5) / f64::from(pairs);
            let z = if i % 2 == 0 { min.y + 0.5 * SIDEWALK_M } else { max.y - 0.5 * SIDEWALK_M };
            trees.push(Tree {
                position: DVec3::new(min.x + rounded(along * (max.x - min.x)), 0.0, z),
                height_m: rounded(rng.random_range(4.0..7.0)),
                crown_radius_m: rounded(rng.random_range(0.6..0.95)),
            });
        }
    }
    trees
}
