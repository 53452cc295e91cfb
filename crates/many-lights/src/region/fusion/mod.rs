//! Shadows on a plane that are joined with those beside them, and moved from plane to plane.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, sections 4.2.4 (fusion)
//! and 4.2.5 (reprojection).
//! Deviations: shadows have feet, so some that overlap cannot be joined: then both stay. A parent whose
//! height collapses leaves its children, where the thesis stops. What lies wholly inside its parent is
//! not kept: it would never be asked. [`Fusion::HeightOrdered`] is not the thesis's: whatever
//! is touched by new shadows that add to it is taken apart, and all of it is joined anew from the tallest
//! to the lowest. Parents take part as the shadows that they are, so none is lost when its children have
//! shrunk apart. Without feet, it finds on one plane all that lies below the skyline of the shadows, and no tree has more
//! nodes than there were shadows; feet that differ may cost two or three a shadow. What nothing that is
//! still asked can touch is dropped from plane to plane ([`Horizon::reproject_asked`]).

mod asked;
mod forest;
mod horizon;
mod join;
mod query;
pub mod reference;
mod weave;

use super::horizon::{Projection, Umbra, reproject};
use super::{Cuboid, Fusion};

pub use asked::{NOTHING, around, asked_part, nothing_yet};
pub use horizon::Horizon;
pub use join::join;

/// What a projection has in common with shadows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It lies in one of them.
    Hidden,
    /// It overlaps one of them, laterally and vertically.
    Partial,
    /// None of them touches it: no part of it is hidden.
    Free,
}
