//! Shadows on a plane that are joined with those beside them, and moved from plane to plane.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, sections 4.2.4 (fusion)
//! and 4.2.5 (reprojection).
//! Deviations: shadows have feet, so some that overlap cannot be joined: then both stay. A parent whose
//! height collapses leaves its children, where the thesis stops. What lies wholly inside its parent is
//! not kept. [`Fusion::HeightOrdered`] is not the thesis's.

mod join;
pub mod reference;

use super::horizon::{Projection, Umbra, reproject};
use super::{Cuboid, Fusion};

pub use join::join;

/// What a projection has in common with shadows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It lies in one of them.
    Hidden,
    /// It overlaps one of them, laterally and vertically.
    Partial,
    /// None of them touches it: neither it nor any part of it is hidden.
    Free,
}

/// Whether a shadow and a projection have a point in common; borders belong to both. The shadow is
/// taken to be as high everywhere as its highest point.
fn overlaps(shadow: &Umbra, p: &Projection) -> bool {
    let beside = p.u[0] <= shadow.u[1] && shadow.u[0] <= p.u[1];
    beside && p.h[0] <= shadow.highest() && shadow.foot <= p.h[1]
}

/// All shadows on one plane.
#[derive(Clone, Debug)]
pub struct Horizon {
    clear: reference::Horizon,
}

impl Horizon {
    /// No shadows.
    pub fn new(fusion: Fusion) -> Self {
        Self { clear: reference::Horizon::new(fusion) }
    }

    /// Forgets all shadows, keeps their memory.
    pub fn clear(&mut self) {
        self.clear.clear();
    }

    /// Whether nothing is hidden.
    pub fn is_empty(&self) -> bool {
        self.clear.is_empty()
    }

    /// 14: shadows on the current plane join what is there.
    pub fn add(&mut self, shadows: &[Umbra]) {
        self.clear.add(shadows);
    }

    /// 13: moves everything from one plane to a farther one; returns how many shadows are left.
    pub fn reproject(&mut self, cell: &Cuboid, from: f64, to: f64) -> u64 {
        self.clear.reproject(cell, from, to)
    }

    /// Whether a projection lies in one shadow. `compared` counts the shadows looked at.
    pub fn test(&self, p: &Projection, compared: &mut u64) -> Verdict {
        self.clear.test(p, compared)
    }

    /// Bytes of all of it.
    pub fn bytes(&self) -> u64 {
        size_of_val(self.clear.nodes().as_slice()) as u64
    }
}
