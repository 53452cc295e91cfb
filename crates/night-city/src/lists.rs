//! What objects of a cell start at, from the precuts of its directions.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 4.1 (the union of the
//! directions that surfaces face) and section 6.1 (future work: heights below which clusters are hidden).
//! Deviations: of a surface that faces several directions, what one of them proves hidden stays hidden
//! ([`combined`]). An object whose surfaces face different ones starts at all that any of them needs: a
//! light that no wall to the north sees may shine on the wall to the east beside it.

use crate::cells::{Directions, Faced, each};
use dapple_many_lights::{
    LightTree,
    region::{Direction, ViewCell, combined, union},
};

/// A precut as it is kept.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Precut<'a> {
    /// Nodes of the light tree, in increasing order, none inside another.
    pub nodes: &'a [u32],
    /// Local y, metres, one a node: no point of the face at that height or below sees anything of it.
    /// Empty where none was asked for.
    pub hidden_below: &'a [f32],
}

/// The height of a node that is hidden from no point.
const NEVER: f32 = f32::NEG_INFINITY;

/// A list being made; kept for its memory.
#[derive(Clone, Debug, Default)]
pub struct List {
    /// Nodes in increasing order, none inside another.
    pub nodes: Vec<u32>,
    /// Local y, metres, one a node: no point of the object at that height or below sees anything of it.
    /// Empty where no precut has any.
    pub hidden_below: Vec<f32>,
    /// Of one set of directions.
    of_set: Vec<u32>,
    open: Vec<u32>,
    /// Of all sets.
    entries: Vec<(u32, f32)>,
}

impl List {
    /// What an object starts at whose surfaces face `faced` of a cell. `precuts` is by
    /// [`Direction::index`].
    pub fn make(
        &mut self,
        tree: &LightTree,
        cell: &ViewCell,
        faced: Faced,
        precuts: [Precut<'_>; 4],
    ) {
        let nodes = precuts.map(|precut| precut.nodes);
        let heights = precuts.iter().any(|precut| !precut.hidden_below.is_empty());
        self.entries.clear();
        for set in faced.sets() {
            let (directions, count) = listed(set);
            let directions = &directions[..count];
            combined(tree, cell, directions, nodes, &mut self.of_set, &mut self.open);
            let height = |node: u32| match heights {
                true => hidden_below(tree, cell, directions, &precuts, node),
                false => NEVER,
            };
            self.entries.extend(self.of_set.iter().map(|&node| (node, height(node))));
        }
        self.entries.sort_unstable_by_key(|(node, _)| *node);
        self.of_set.clear();
        self.of_set.extend(self.entries.iter().map(|(node, _)| *node));
        union(&[&self.of_set], |node| tree.nodes[node as usize].size, &mut self.nodes);
        self.hidden_below.clear();
        if heights {
            self.join_heights(tree);
        }
    }

    /// A node is hidden up to where all entries are that lie in it: for a set without any it is hidden
    /// everywhere.
    fn join_heights(&mut self, tree: &LightTree) {
        let mut entries = self.entries.iter().peekable();
        for &node in &self.nodes {
            let end = node + tree.nodes[node as usize].size;
            let mut lowest = f32::INFINITY;
            while let Some((_, height)) = entries.next_if(|(inside, _)| *inside < end) {
                lowest = lowest.min(*height);
            }
            self.hidden_below.push(lowest);
        }
    }
}

fn listed(set: Directions) -> ([Direction; 4], usize) {
    let mut all = Direction::ALL;
    let mut count = 0;
    for direction in each(set) {
        all[count] = direction;
        count += 1;
    }
    (all, count)
}

/// The greatest height up to which any direction hides a node from surfaces that face all of
/// `directions`. A direction proves nothing of what is not wholly in front of its face; to a surface that
/// faces no other, what is behind gives nothing.
fn hidden_below(
    tree: &LightTree,
    cell: &ViewCell,
    directions: &[Direction],
    precuts: &[Precut<'_>; 4],
    node: u32,
) -> f32 {
    let by = |direction: &Direction| {
        if directions.len() > 1 && !is_in_front(tree, cell, *direction, node) {
            return None;
        }
        let Precut { nodes, hidden_below } = precuts[direction.index()];
        let place = nodes.partition_point(|&before| before <= node).checked_sub(1)?;
        let holder = nodes[place];
        let holds = node < holder + tree.nodes[holder as usize].size;
        hidden_below.get(place).copied().filter(|_| holds)
    };
    directions.iter().filter_map(by).fold(NEVER, f32::max)
}

/// Whether all lights of a node lie in front of the rearmost point of a face, as [`combined`] has it.
fn is_in_front(tree: &LightTree, cell: &ViewCell, direction: Direction, node: u32) -> bool {
    let Some(face) = cell.face(direction) else { return false };
    let node = &tree.nodes[node as usize];
    let (min, max) = cell.turn.around(node.min, node.max);
    direction.cuboid(min, max).w[0] > face.cuboid(direction).w[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_many_lights::{
        Emission, Light,
        region::{Surface, Turn},
    };
    use glam::{DVec2, DVec3};

    fn bit(direction: Direction) -> Directions {
        1 << direction.index()
    }

    /// Lights at places, a tree over them, and a cell of a wall that faces +x and one that faces +z, up
    /// to 3 m high.
    fn corner(places: &[DVec3]) -> (LightTree, ViewCell) {
        let light = |&position: &DVec3| Light {
            position,
            axis: DVec3::Y,
            intensity: DVec3::ONE,
            emission: Emission::Omni,
        };
        let lights: Vec<Light> = places.iter().map(light).collect();
        let wall = |from: DVec2, to: DVec2| Surface::wall(from, to, [0.0, 3.0], DVec3::ONE);
        let east = wall(DVec2::new(0.0, 0.0), DVec2::new(0.0, -4.0));
        let south = wall(DVec2::new(-4.0, 0.0), DVec2::new(0.0, 0.0));
        assert_eq!([east, south].map(|wall| wall.normal_axis), [DVec3::X, DVec3::Z]);
        let walls = [east, south];
        (LightTree::median(&lights).unwrap(), ViewCell::around(&walls, Turn::NONE))
    }

    fn walls() -> (Directions, Directions) {
        (bit(Direction::PlusX), bit(Direction::PlusZ))
    }

    #[test]
    fn what_one_wall_does_not_see_may_shine_on_the_wall_beside_it() {
        let (tree, cell) = corner(&[DVec3::new(5.0, 1.0, 5.0)]);
        let (east, south) = walls();
        let mut precuts = [Precut::default(); 4];
        precuts[Direction::PlusX.index()].nodes = &[0];
        let mut list = List::default();
        let mut nodes = |sets: &[Directions]| {
            list.make(&tree, &cell, Faced::of_sets(sets.iter().copied()), precuts);
            assert!(list.hidden_below.is_empty());
            list.nodes.clone()
        };
        assert_eq!(nodes(&[east]), [0]);
        assert!(nodes(&[south]).is_empty());
        assert_eq!(nodes(&[east, south]), [0], "two walls");
        assert!(nodes(&[east | south]).is_empty(), "one wall askew");
        assert!(nodes(&[]).is_empty());
    }

    #[test]
    fn a_node_is_hidden_as_high_as_any_direction_says_of_one_surface_and_all_say_of_several() {
        let (tree, cell) = corner(&[DVec3::new(5.0, 1.0, 5.0), DVec3::new(9.0, 1.0, 6.0)]);
        let (east, south) = walls();
        let mut precuts = [Precut::default(); 4];
        precuts[Direction::PlusX.index()] = Precut { nodes: &[0], hidden_below: &[1.0] };
        precuts[Direction::PlusZ.index()] = Precut { nodes: &[1, 2], hidden_below: &[2.0, 0.5] };
        let mut list = List::default();
        let mut of = |sets: &[Directions]| {
            list.make(&tree, &cell, Faced::of_sets(sets.iter().copied()), precuts);
            list.nodes.iter().copied().zip(list.hidden_below.iter().copied()).collect::<Vec<_>>()
        };
        assert_eq!(of(&[east]), [(0, 1.0)]);
        assert_eq!(of(&[south]), [(1, 2.0), (2, 0.5)]);
        assert_eq!(of(&[east | south]), [(1, 2.0), (2, 1.0)]);
        assert_eq!(of(&[east, south]), [(0, 0.5)]);
        // What the wall to the south does not see at all hides nothing from the other.
        precuts[Direction::PlusZ.index()] = Precut { nodes: &[1], hidden_below: &[2.0] };
        list.make(&tree, &cell, Faced::of_sets([east, south]), precuts);
        assert_eq!((&list.nodes[..], &list.hidden_below[..]), (&[0][..], &[1.0][..]));
    }

    #[test]
    fn what_is_not_wholly_in_front_of_a_face_is_hidden_by_others_alone() {
        // Beside the wall that faces +z, behind its rear.
        let (tree, cell) = corner(&[DVec3::new(5.0, 1.0, -3.0)]);
        let (east, south) = walls();
        let mut precuts = [Precut::default(); 4];
        precuts[Direction::PlusX.index()] = Precut { nodes: &[0], hidden_below: &[1.0] };
        precuts[Direction::PlusZ.index()] = Precut { nodes: &[], hidden_below: &[] };
        let mut list = List::default();
        list.make(&tree, &cell, Faced::of_sets([east | south]), precuts);
        assert_eq!((&list.nodes[..], &list.hidden_below[..]), (&[0][..], &[1.0][..]));
    }
}
