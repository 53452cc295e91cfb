//! Deliberate faults, so that a gate can be shown to catch them.

use super::reference::evaluate;
use super::{Cascade, CascadeError, CascadeReceiver, Settings};
use crate::filtering::DepthMap;

/// A mistake in the reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fault {
    /// The map of the next cascade is read (of the first for the last). Shows with two cascades
    /// and more.
    NextCascade,
    /// The region lies one texel further left than its map.
    CropOneTexel,
    /// Nothing is taken off a receiver's depth, nor does it have a plane: a slanted surface
    /// shadows itself.
    Unbiased,
}

impl Fault {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::NextCascade, Self::CropOneTexel, Self::Unbiased];
}

/// [`reference::visibility`](super::reference::visibility) with one fault put in.
///
/// # Errors
/// As the faultless one.
pub fn visibility(
    maps: &[DepthMap],
    cascades: &[Cascade],
    receivers: &[CascadeReceiver],
    settings: &Settings,
    fault: Fault,
) -> Result<Vec<f64>, CascadeError> {
    evaluate(maps, cascades, receivers, settings, Some(fault))
}
