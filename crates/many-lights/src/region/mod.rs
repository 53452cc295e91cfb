//! Which lights may reach a facade: from-region visibility of clusters of lights, behind occluders
//! that stand on the ground.
//!
//! A [`ViewCell`] is an upright box, turned about the vertical, whose surfaces face up to four
//! [`Direction`]s. For a cell and a direction, [`Precuts::precut`] finds nodes of the light tree that
//! together hold every light that any point of those surfaces may see; what is left out is hidden
//! from all of them, or too weak. Points are shaded with the union over the directions that their
//! surfaces face ([`union`]).
//!
//! Spaces: *local* is that of [`crate::World`] (metres relative to its origin, y up); *turned* is local
//! in a cell's [`Turn`]; the space of a direction ([`Cuboid`]) has u along the plane, w away from the
//! cell, h up.

mod cell;
pub mod evaluate;
pub mod extended_projection;
pub mod fusion;
pub mod horizon;
pub mod levels_of_detail;
mod make;
mod many;
mod occluders;
mod potential;
mod reference;
pub mod sampled;
mod settings;
mod space;
pub mod specular;
mod steps;
mod surfaces;
pub mod truth;
mod union;

pub use cell::{Face, ViewCell};
pub use make::make;
pub use many::Many;
pub use occluders::{Occluders, Solid, Turned};
pub use reference::Reference;
pub use settings::{
    Edge, FacadeCluster, Fusion, OccluderMode, Planes, RegionTechnique, Sampled, Split,
};
pub use space::{Cuboid, Direction, Turn};
pub use steps::Steps;
pub use surfaces::{Surface, turn_of};
pub use union::{combined, union};

/// From-region visibility made ready for one light tree.
pub trait Precuts: Send {
    /// Nodes of the light tree, in increasing order, none inside another: all lights that any point
    /// of the cell's face towards `direction` may see, less what is too weak. `nodes` is emptied
    /// first; it stays empty where the cell has no such face.
    fn precut(&mut self, cell: &ViewCell, direction: Direction, nodes: &mut Vec<u32>);

    /// Work since it was made ready.
    fn steps(&self) -> &Steps;

    /// Bytes of what it holds beside the tree.
    fn bytes(&self) -> u64;
}
