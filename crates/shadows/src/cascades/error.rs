//! What is refused, by name.

use thiserror::Error;

use super::MAX_CASCADES;
use crate::filtering::FilterError;

/// Why cascades cannot be made or used.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum CascadeError {
    /// No cascade, or more than there may be.
    #[error("{count} cascades are not within 1..={MAX_CASCADES}")]
    Count {
        /// Cascades asked for.
        count: usize,
    },
    /// View depths that are no range.
    #[error("near {near} and far {far} must be finite, with 0 < near < far and a finite ratio")]
    Range {
        /// Nearest view depth.
        near: f64,
        /// Farthest view depth.
        far: f64,
    },
    /// A range without room for different splits.
    #[error("between near {near} and far {far} there is no room for {count} different slices")]
    Narrow {
        /// Nearest view depth.
        near: f64,
        /// Farthest view depth.
        far: f64,
        /// Slices asked for.
        count: usize,
    },
    /// A knob out of its range.
    #[error("{name} is {value}, which is not {limit}")]
    Knob {
        /// Which one.
        name: &'static str,
        /// Value given.
        value: f64,
        /// Range allowed.
        limit: &'static str,
    },
    /// Lists that do not belong together.
    #[error("{what}: expected {expected} elements, got {actual}")]
    Length {
        /// Which list.
        what: &'static str,
        /// Needed.
        expected: usize,
        /// Given.
        actual: usize,
    },
    /// A corner of a slice that is not finite.
    #[error("corner {corner} of slice {slice} is not finite")]
    Corner {
        /// Index of the slice.
        slice: usize,
        /// Index of the corner.
        corner: usize,
    },
    /// A box of casters that is not finite or inside out.
    #[error("the casters' box from {least:?} to {most:?} must be finite and not inside out")]
    Casters {
        /// Its corner of least u and v.
        least: [f64; 2],
        /// Its corner of largest u and v.
        most: [f64; 2],
    },
    /// A margin that leaves nothing of the map.
    #[error("a margin of {margin_texels} texels leaves nothing of a map of {side} texels")]
    Margin {
        /// Texels left free on each border.
        margin_texels: u32,
        /// Side of the map, texels.
        side: u32,
    },
    /// A cascade that is no region of the map, or does not begin where the one before ends.
    #[error("cascade {cascade}: {why}")]
    Cascade {
        /// Its index.
        cascade: usize,
        /// What is wrong.
        why: &'static str,
    },
    /// A depth map that is not sound.
    #[error("the map of cascade {cascade}: {error}")]
    Map {
        /// Index of the cascade.
        cascade: usize,
        /// What is wrong.
        error: FilterError,
    },
}
