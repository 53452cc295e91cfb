//! One list of start nodes from those of several directions.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 4.1: the union of the
//! directions that a surface faces ([`union`]).
//! Deviations: nodes inside others are left out, else their lights count twice. [`combined`] is ours: a
//! street faces all four directions, and what one of them proves hidden the others must not bring
//! back.

use super::{Direction, ViewCell};
use crate::LightTree;

/// The union of precuts of one tree in increasing order, nodes inside others left out: no light is
/// counted twice. `size` is of the tree's nodes: the subtree of `i` is `i .. i + size(i)`.
pub fn union(precuts: &[&[u32]], size: impl Fn(u32) -> u32, nodes: &mut Vec<u32>) {
    nodes.clear();
    nodes.extend(precuts.iter().copied().flatten());
    nodes.sort_unstable();
    let mut end = 0;
    nodes.retain(|&node| {
        let kept = node >= end;
        if kept {
            end = node + size(node);
        }
        kept
    });
}

/// What lights surfaces that face several `directions` and lie in the cell's faces towards all of them:
/// the union of their precuts, less every light in front of one of these faces that is not in its
/// precut. Hidden from all of a box is hidden, whichever direction proves it. `precuts` is by
/// [`Direction::index`]; `nodes` and `open` are emptied first.
pub fn combined(
    tree: &LightTree,
    cell: &ViewCell,
    directions: &[Direction],
    precuts: [&[u32]; 4],
    nodes: &mut Vec<u32>,
    open: &mut Vec<u32>,
) {
    nodes.clear();
    let &[first, ref others @ ..] = directions else { return };
    let size = |node: u32| tree.nodes[node as usize].size;
    if others.is_empty() {
        nodes.extend_from_slice(precuts[first.index()]);
        return;
    }
    let of = |direction: &Direction| precuts[direction.index()];
    let all: [&[u32]; 4] = std::array::from_fn(|i| directions.get(i).map_or(&[][..], of));
    union(&all, size, nodes);
    for direction in directions {
        std::mem::swap(nodes, open);
        nodes.clear();
        keep(tree, cell, *direction, of(direction), open, nodes);
    }
}

/// Those of `from` that are not in front of a face, or in its precut. `from` is used up.
fn keep(
    tree: &LightTree,
    cell: &ViewCell,
    direction: Direction,
    precut: &[u32],
    from: &mut Vec<u32>,
    kept: &mut Vec<u32>,
) {
    let Some(face) = cell.face(direction) else {
        kept.append(from);
        return;
    };
    let rear = face.cuboid(direction).w[0];
    // As a stack, so that the smallest node comes first and children are put back in order.
    from.reverse();
    let mut next = 0;
    while let Some(index) = from.pop() {
        let node = &tree.nodes[index as usize];
        let (min, max) = cell.turn.around(node.min, node.max);
        let [low, high] = direction.cuboid(min, max).w;
        if low > rear {
            let end = index + node.size;
            // Nodes increase, and so do those of the precut.
            while precut.get(next).is_some_and(|&p| p + tree.nodes[p as usize].size <= index) {
                next += 1;
            }
            match precut.get(next) {
                Some(&p) if p <= index => kept.push(index),
                _ => {
                    while let Some(&p) = precut.get(next).filter(|p| **p < end) {
                        kept.push(p);
                        next += 1;
                    }
                }
            }
        } else if high <= rear || node.is_leaf() {
            kept.push(index);
        } else {
            let first = from.len();
            let mut child = index + 1;
            while child < index + node.size {
                from.push(child);
                child += tree.nodes[child as usize].size;
            }
            from[first..].reverse();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Emission, Light,
        bound::Region,
        region::{Face, Turn},
    };
    use glam::DVec3;
    use proptest::prelude::*;

    #[test]
    fn nodes_inside_others_and_doubles_are_left_out() {
        // 0 (1 2 (3 4) 5), 6
        let sizes = [6, 1, 3, 1, 1, 1, 1];
        let mut nodes = vec![9];
        union(&[&[2, 6], &[1, 3], &[4, 6]], |i| sizes[i as usize], &mut nodes);
        assert_eq!(nodes, [1, 2, 6]);
        union(&[&[0], &[5, 6]], |i| sizes[i as usize], &mut nodes);
        assert_eq!(nodes, [0, 6]);
        union(&[], |_| 1, &mut nodes);
        assert!(nodes.is_empty());
    }

    /// The largest nodes of which all lights are wanted.
    fn nodes_of(tree: &LightTree, wanted: &[bool]) -> Vec<u32> {
        let mut nodes = Vec::new();
        let mut index = 0;
        while index < tree.nodes.len() as u32 {
            let node = &tree.nodes[index as usize];
            let inside = index..index + node.size;
            let all = (0..wanted.len()).all(|l| !inside.contains(&tree.leaves[l]) || wanted[l]);
            if all {
                nodes.push(index);
            }
            index += if all { node.size } else { 1 };
        }
        nodes
    }

    fn lights_of(tree: &LightTree, nodes: &[u32]) -> Vec<u32> {
        let inside = |l: &u32| {
            let leaf = tree.leaves[*l as usize];
            nodes
                .iter()
                .filter(|n| (**n..**n + tree.nodes[**n as usize].size).contains(&leaf))
                .count()
        };
        let all = 0..tree.leaves.len() as u32;
        all.flat_map(|l| std::iter::repeat_n(l, inside(&l))).collect()
    }

    proptest! {
        #[test]
        fn what_one_direction_hides_stays_hidden_and_no_light_counts_twice(
            places in prop::collection::vec((-9_i32..9, -9_i32..9, any::<[bool; 4]>()), 1..60),
            faced in any::<[bool; 4]>(),
            degrees in 0_u32..3,
        ) {
            let light = |&(x, z, _): &(i32, i32, [bool; 4])| Light {
                position: DVec3::new(f64::from(x), 1.0, f64::from(z)),
                axis: DVec3::Y,
                intensity: DVec3::ONE,
                emission: Emission::Omni,
            };
            let lights: Vec<Light> = places.iter().map(light).collect();
            let tree = LightTree::median(&lights).unwrap();
            let turn = Turn::degrees(30 * degrees);
            let (min, max) = (DVec3::new(-2.0, 0.0, -1.0), DVec3::new(1.0, 1.0, 3.0));
            let region = Region { min, max, normal_axis: DVec3::Y, normal_spread_rad: 0.0, albedo: DVec3::ONE };
            let face = Face { min, max, region };
            let cell = ViewCell { turn, faces: [Some(face); 4] };
            let front = |d: Direction, l: usize| {
                let at = turn.to(lights[l].position);
                d.cuboid(at, at).w[0] > face.cuboid(d).w[0]
            };
            // Only what lies in front of a face can be in its precut.
            let in_precut = |d: Direction, l: usize| front(d, l) && places[l].2[d.index()];
            let precuts = Direction::ALL.map(|d| {
                let wanted: Vec<bool> = (0..lights.len()).map(|l| in_precut(d, l)).collect();
                nodes_of(&tree, &wanted)
            });
            let directions: Vec<Direction> =
                Direction::ALL.into_iter().filter(|d| faced[d.index()]).collect();
            let (mut nodes, mut open) = (vec![], vec![]);
            combined(&tree, &cell, &directions, precuts.each_ref().map(|p| &p[..]), &mut nodes, &mut open);
            prop_assert!(nodes.is_sorted());
            let expected: Vec<u32> = (0..lights.len())
                .filter(|&l| {
                    let seen = directions.iter().any(|&d| in_precut(d, l));
                    seen && directions.iter().all(|&d| !front(d, l) || in_precut(d, l))
                })
                .map(|l| l as u32)
                .collect();
            prop_assert_eq!(lights_of(&tree, &nodes), expected);
        }
    }
}
