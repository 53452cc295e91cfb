//! View cells of a frame as regions for lights.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 4.1 (cells by coverage;
//! each evaluated towards the directions that its surfaces face).
//! Deviations: a cell may be around all that lies below its node, seen or not: then what is found for
//! it stays true whatever comes into sight. The thesis, which keeps precuts for 50 frames, does not
//! say.

use crate::{Surfaces, Town};
use dapple_many_lights::region::{Direction, Surface, Turn, ViewCell, turn_of};
use std::{collections::BTreeMap, sync::Arc};

/// Directions as bits, by [`Direction::index`].
pub type Directions = u8;

/// What the surfaces of an object face, each on its own: sets of directions as bits, by
/// [`Directions`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Faced(u16);

impl Faced {
    /// Each set of directions that any surface faces.
    pub fn sets(self) -> impl Iterator<Item = Directions> {
        (1..16).filter(move |set| self.0 >> set & 1 == 1)
    }

    /// All directions that any surface faces.
    pub fn all(self) -> Directions {
        self.sets().fold(0, |all, set| all | set)
    }

    /// Of sets of directions, one a surface.
    pub fn of_sets(sets: impl IntoIterator<Item = Directions>) -> Self {
        let all = sets.into_iter().fold(0, |all, set| all | 1 << (set & 0xF));
        // A surface that faces nothing needs nothing.
        Self(all & !1)
    }

    fn of(surfaces: &[Surface], turn: Turn) -> Self {
        Self::of_sets(surfaces.iter().map(|surface| {
            let cell = ViewCell::around(std::slice::from_ref(surface), turn);
            let faced = Direction::ALL.into_iter().filter(|d| cell.face(*d).is_some());
            faced.fold(0, |all, direction| all | 1 << direction.index())
        }))
    }
}

/// A node's cell, and what the objects in it face.
#[derive(Clone, Debug)]
pub struct NodeCell {
    /// The cell.
    pub cell: ViewCell,
    /// Objects in increasing order, each with what its surfaces face.
    objects: Vec<(u32, Faced)>,
}

impl NodeCell {
    /// Around the surfaces of objects, turned to their facades.
    pub fn around(surfaces: &Surfaces, objects: &[u32]) -> Self {
        let all = surfaces_of(surfaces, objects);
        let turn = turn_of(&all);
        let needed = |object: &u32| (*object, Faced::of(surfaces.of_object(*object), turn));
        let mut needed: Vec<_> = objects.iter().map(needed).collect();
        needed.sort_unstable_by_key(|(object, _)| *object);
        Self { cell: ViewCell::around(&all, turn), objects: needed }
    }

    /// Around some of its objects alone, turned as it is: what is kept by direction keeps its meaning.
    pub fn shrunk(&self, surfaces: &Surfaces, objects: &[u32]) -> ViewCell {
        ViewCell::around(&surfaces_of(surfaces, objects), self.cell.turn)
    }

    /// What the surfaces of an object face: nothing of one that is not in the cell.
    pub fn faced(&self, object: u32) -> Faced {
        let found = self.objects.binary_search_by_key(&object, |(object, _)| *object);
        found.map_or(Faced::default(), |place| self.objects[place].1)
    }

    /// Directions that an object faces: none of one that is not in the cell.
    pub fn directions(&self, object: u32) -> Directions {
        self.faced(object).all()
    }

    /// Directions that any of some objects faces.
    pub fn directions_of(&self, objects: &[u32]) -> Directions {
        objects.iter().fold(0, |all, object| all | self.directions(*object))
    }

    /// Bytes.
    pub fn bytes(&self) -> u64 {
        (size_of::<Self>() + size_of_val(&self.objects[..])) as u64
    }
}

/// The directions of a set, in order.
pub fn each(directions: Directions) -> impl Iterator<Item = Direction> {
    Direction::ALL.into_iter().filter(move |direction| directions >> direction.index() & 1 == 1)
}

fn surfaces_of(surfaces: &Surfaces, objects: &[u32]) -> Vec<Surface> {
    objects.iter().flat_map(|object| surfaces.of_object(*object)).copied().collect()
}

/// Cells around all that lies below nodes, made when first asked for.
#[derive(Clone, Debug, Default)]
pub struct WholeCells {
    cells: BTreeMap<u32, Arc<NodeCell>>,
    bytes: u64,
}

impl WholeCells {
    /// The cell of a node of the town's tree.
    pub fn of(&mut self, town: &Town, node: u32) -> Arc<NodeCell> {
        let Self { cells, bytes } = self;
        let made = cells.entry(node).or_insert_with(|| {
            let cell = NodeCell::around(&town.surfaces, town.tree.objects_of(node));
            *bytes += cell.bytes();
            Arc::new(cell)
        });
        Arc::clone(made)
    }

    /// Bytes.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }
}
