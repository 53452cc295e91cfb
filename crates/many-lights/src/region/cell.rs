//! Cells: parts of what is seen whose lights are found together.

use super::{Cuboid, Direction, Turn};
use crate::bound::Region;
use glam::DVec3;

/// The surfaces of a cell that may be lit from one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Lower corner of the box around them, turned space, metres.
    pub min: DVec3,
    /// Its upper corner.
    pub max: DVec3,
    /// The same points in local space with their normals and greatest albedo, for bounds.
    pub region: Region,
}

/// An upright box, turned about the vertical, by what faces each direction. A surface faces every
/// horizontal direction that its normal has a positive part along; one that faces straight up or down
/// faces all four.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewCell {
    /// How the cell, and the occluders seen from it, are turned.
    pub turn: Turn,
    /// By [`Direction::index`]; `None` where no surface faces.
    pub faces: [Option<Face>; 4],
}

impl Face {
    /// The box in the space of a direction.
    pub fn cuboid(&self, direction: Direction) -> Cuboid {
        direction.cuboid(self.min, self.max)
    }
}

impl ViewCell {
    /// The face towards a direction.
    pub fn face(&self, direction: Direction) -> Option<&Face> {
        self.faces[direction.index()].as_ref()
    }
}
