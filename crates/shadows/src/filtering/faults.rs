//! Deliberate faults, so that a gate can be shown to catch them.
//!
//! Each is a mistake that has been made with these filters. A check that passes on a faulty
//! result checks nothing.

use super::reference::evaluate;
use super::{DepthMap, FilterError, Receiver, Settings};

/// A mistake in the reference chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fault {
    /// The error function as printed, without its sign, in eq. 7.4 clamped instead of guarded:
    /// receivers before the mean are darkened. Shows with the Gaussian CDF.
    PrintedErf,
    /// The depth is averaged before it is squared, so that every variance is 0. Shows with VSM
    /// and the Gaussian CDF.
    MeanBeforeSquare,
    /// Minimum and maximum blended linearly like means. Shows with the power CDF and VSM with
    /// maximum, bilinear lookups.
    BilinearMinMax,
    /// The window begins one texel early and keeps its width. Shows with every estimator.
    WindowOffByOne,
    /// A receiver outside the map is moved to its border and shaded there. Shows where the border
    /// is nearer to the light than the receiver.
    ClampedReceiver,
}

impl Fault {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::PrintedErf,
        Self::MeanBeforeSquare,
        Self::BilinearMinMax,
        Self::WindowOffByOne,
        Self::ClampedReceiver,
    ];
}

/// [`reference::visibility`](super::reference::visibility) with one fault put in.
///
/// # Errors
/// As the faultless one.
pub fn visibility(
    map: &DepthMap,
    receivers: &[Receiver],
    settings: &Settings,
    fault: Fault,
) -> Result<Vec<f64>, FilterError> {
    evaluate(map, receivers, settings, Some(fault))
}
