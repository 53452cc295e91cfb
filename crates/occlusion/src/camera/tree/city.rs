//! A city's own hierarchy: where each object belongs, as a path of numbers.
//!
//! Based on: Conte 2018 (`conte2018`), section 5.1: city, block, building, facade, storey.
//! Deviations: above the blocks lie quadrants, and what belongs to no block, streets and trees, lies
//! in the quadrant of its middle. A city that is one node over all its blocks is found hidden block by
//! block, so that what a walk costs grows with the city and not with what is seen.

use super::{Bounds, Objects};
use dapple_scene::{Scene, city::Part};
use glam::Vec3;

/// The path of each object, for [`Tree::by_keys`](super::Tree::by_keys). `parts` has one an instance
/// of `scene`, `owners` one a placed triangle: its object, and its index there. An object without a
/// part lies beside the trees of its quadrant.
pub fn city_keys(
    parts: &[Part],
    scene: &Scene,
    owners: &[[u32; 2]],
    objects: &Objects,
) -> Vec<Vec<u32>> {
    let mut part_of = vec![None; objects.objects.len()];
    let placed = scene.world_triangles().map(|((instance, _), _)| instance);
    for (instance, [object, _]) in placed.zip(owners) {
        if let Some(part) = part_of.get_mut(*object as usize) {
            *part = parts.get(instance as usize).copied();
        }
    }
    let bounds = |object: usize| objects.objects[object].bounds;
    let mut blocks: Vec<Bounds> = Vec::new();
    let mut city = Bounds::EMPTY;
    for (object, part) in part_of.iter().enumerate() {
        city = city.union(bounds(object));
        if let Some(block) = part.and_then(block) {
            let count = blocks.len().max(block as usize + 1);
            blocks.resize(count, Bounds::EMPTY);
            blocks[block as usize] = blocks[block as usize].union(bounds(object));
        }
    }
    // As many levels as leave about one block a quadrant.
    let levels = (usize::BITS - blocks.len().saturating_sub(1).leading_zeros()).div_ceil(2);
    let key = |(object, part): (usize, &Option<Part>)| {
        let home = part.and_then(block).map_or(bounds(object), |block| blocks[block as usize]);
        let mut key = quadrants(&city, home.centre(), levels);
        key.extend(match *part {
            Some(Part::Storey { block, building, facade, storey }) => {
                vec![0, block, building, 0, facade, storey]
            }
            Some(Part::Roof { block, building }) => vec![0, block, building, 1],
            Some(Part::Ground { ground }) => vec![1, ground],
            Some(Part::Tree { tree }) => vec![2, tree],
            None => vec![3],
        });
        // Clusters of one large instance stay apart.
        key.push(object as u32);
        key
    };
    part_of.iter().enumerate().map(key).collect()
}

fn block(part: Part) -> Option<u32> {
    match part {
        Part::Storey { block, .. } | Part::Roof { block, .. } => Some(block),
        Part::Ground { .. } | Part::Tree { .. } => None,
    }
}

/// The quadrants of `city` that `point` lies in, largest first: bit 0 east, bit 1 south.
fn quadrants(city: &Bounds, point: Vec3, levels: u32) -> Vec<u32> {
    let (mut low, mut high) = (city.min, city.max);
    (0..levels)
        .map(|_| {
            let middle = 0.5 * (low + high);
            let (east, south) = (point.x > middle.x, point.z > middle.z);
            if east {
                low.x = middle.x
            } else {
                high.x = middle.x
            }
            if south {
                low.z = middle.z
            } else {
                high.z = middle.z
            }
            u32::from(east) + 2 * u32::from(south)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Tree;
    use dapple_scene::generate;

    #[test]
    fn quadrants_halve_the_city() {
        let city = Bounds { min: Vec3::ZERO, max: Vec3::new(4.0, 1.0, 4.0) };
        assert_eq!(quadrants(&city, Vec3::new(3.5, 0.0, 0.5), 2), [1, 1]);
        assert_eq!(quadrants(&city, Vec3::new(1.5, 0.0, 3.5), 2), [2, 3]);
        assert!(quadrants(&city, Vec3::ZERO, 0).is_empty());
    }

    #[test]
    fn blocks_stay_whole_and_no_node_has_many_children_but_those_of_the_city() {
        let city = generate::city_of("city", 0).unwrap().scene();
        let (objects, owners) = Objects::from_scene(&city.scene, 128).unwrap();
        let keys = city_keys(&city.parts, &city.scene, &owners, &objects);
        let quadrant = |block: u32| {
            let of = |part: &Part| super::block(*part) == Some(block);
            let mut paths: Vec<&[u32]> =
                keys.iter().zip(&city.parts).filter(|(_, p)| of(p)).map(|(k, _)| &k[..3]).collect();
            paths.dedup();
            paths
        };
        for block in 0..36 {
            assert_eq!(quadrant(block).len(), 1, "block {block}");
        }
        let tree = Tree::by_keys(&objects, &keys).unwrap();
        let children = |depth_first: usize| tree.nodes[depth_first].children.len();
        assert!(children(0) <= 4, "{}", children(0));
        let most = tree.nodes.iter().map(|n| n.children.len()).max();
        assert!(most.is_some_and(|m| m <= 64), "{most:?}");
    }
}
