//! Two-pass culling with a hierarchical depth buffer.
//!
//! Based on: Haar and Aaltonen, GPU-Driven Rendering Pipelines, SIGGRAPH 2015 course, two-phase
//! occlusion culling; Greene, Kass and Miller, Hierarchical Z-Buffer Visibility, SIGGRAPH 1993, for
//! the pyramid and the descent of the scene's tree.
//!
//! A frame draws what was visible in the last one, builds the pyramid of farthest depths, draws
//! every other object whose box is not hidden behind it, and then asks all boxes again, against
//! everything drawn, for the next frame. So the image is exact whatever the last frame saw: a wrong
//! guess costs time alone.
//!
//! Deviations: the course reprojects last frame's depth to choose what is drawn first; here its
//! visible objects are drawn again, which needs no second guess where the camera moves far. A box
//! that the near plane touches counts as visible unasked: it is drawn in the first pass if the last
//! frame saw it, else in the second. A box whose rectangle holds no pixel centre is not drawn at all.
//!
//! Alpha-tested objects are drawn like all others, first pass or second: what is in the depth
//! buffer is their drawn pixels alone, and the pyramid takes the farthest, which a hole shows.
//!
//! - [`mod@reference`]: every pixel of a rectangle is looked at: the most that boxes can cull.
//! - [`cpu`]: the pyramid, asked a few texels a box, flat or down the tree.
//! - [`gpu`]: the same in kernels, without a tree and without a word to the host.

pub mod cpu;
pub mod gpu;
pub mod pyramid;
pub mod reference;
#[cfg(test)]
mod tests;

pub use pyramid::{Level, Pixels, Pyramid};

use super::software::{Fast, Reference};
use super::{Bounds, Objects, Renderer, View};
use crate::OcclusionError;

/// A renderer that shows its depth while it draws.
pub trait ShowsDepth: Renderer {
    /// What has been drawn since the frame began, reversed, rows top to bottom.
    fn depth(&self) -> &[f32];
}

impl ShowsDepth for Fast {
    fn depth(&self) -> &[f32] {
        &self.image().depth
    }
}

impl ShowsDepth for Reference {
    fn depth(&self) -> &[f32] {
        &self.image().depth
    }
}

/// How the processor finds the boxes to ask.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Traversal {
    /// Every object in the frustum.
    #[default]
    Flat,
    /// From the root: what is below a hidden node is hidden.
    Tree,
}

/// What a frame can be told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Which boxes are asked.
    pub traversal: Traversal,
    /// Most texels of the pyramid that a rectangle is wide and high where it is asked, 1 to
    /// [`MOST_ACROSS`]: more read more and hide more.
    pub across: u32,
}

/// A deliberate fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The pyramid takes the nearest depth, as one for standard depth would.
    Nearest,
}

/// Most texels across that [`Settings::across`] may ask for.
pub const MOST_ACROSS: u32 = 64;

impl Default for Settings {
    /// The 2 x 2 texels of one gather.
    fn default() -> Self {
        Self { traversal: Traversal::Flat, across: 2 }
    }
}

impl Settings {
    /// Refuses what is out of range.
    ///
    /// # Errors
    /// Naming the setting and its range.
    pub fn check(&self) -> Result<(), OcclusionError> {
        if (1..=MOST_ACROSS).contains(&self.across) {
            return Ok(());
        }
        let limit = format!("{} is not within 1 to {MOST_ACROSS}", self.across);
        Err(OcclusionError::value("texels across", limit))
    }
}

/// Where a box lies on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Place {
    /// No pixel centre is in it.
    Outside,
    /// The near plane touches it: it counts as visible.
    Near,
    /// These pixels at most, nowhere nearer than the depth.
    At(Pixels, f32),
}

impl Place {
    pub(crate) fn of(view: &View, bounds: &Bounds) -> Self {
        if !view.sees(bounds) {
            return Self::Outside;
        }
        match view.screen_rect(bounds) {
            None => Self::Near,
            Some((rect, nearest)) => Pixels::within(rect, view.width, view.height)
                .map_or(Self::Outside, |pixels| Self::At(pixels, nearest)),
        }
    }
}

/// Which objects the last frame saw.
#[derive(Clone, Debug)]
pub(crate) struct Seen {
    pub(crate) visible: Vec<bool>,
}

impl Seen {
    pub(crate) fn new(objects: &Objects) -> Self {
        Self { visible: vec![false; objects.objects.len()] }
    }

    /// Refuses objects that the state was not made for.
    pub(crate) fn check(&self, objects: &Objects) -> Result<(), OcclusionError> {
        let (made, given) = (self.visible.len(), objects.objects.len());
        if made == given {
            return Ok(());
        }
        Err(OcclusionError::value("objects", format!("{given}, but the state is of {made}")))
    }
}
