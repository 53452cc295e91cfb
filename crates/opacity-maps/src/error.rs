//! What is refused, by name.

use thiserror::Error;

/// Why input or settings cannot be used.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum OpacityError {
    /// A side of the map is 0.
    #[error("the map is empty ({width} x {height} texels)")]
    EmptyMap {
        /// Texels in a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// A vector of another length than the map needs.
    #[error("{what}: expected {expected} elements, got {actual}")]
    Length {
        /// Which one.
        what: &'static str,
        /// Needed.
        expected: usize,
        /// Given.
        actual: usize,
    },
    /// Places of fragments that run backwards.
    #[error("fragments of texel {texel} end before they start")]
    Starts {
        /// The texel.
        texel: usize,
    },
    /// A fragment that is not finite, or of negative thickness.
    #[error(
        "fragment {fragment}: depth {depth} and thickness {omega} must be finite, the latter >= 0"
    )]
    Fragment {
        /// Place in the items.
        fragment: usize,
        /// Its depth.
        depth: f32,
        /// Its thickness.
        omega: f32,
    },
    /// An opaque depth that is not finite.
    #[error("opaque depth {depth} of texel {texel} is not finite")]
    OpaqueDepth {
        /// The texel.
        texel: usize,
        /// The depth.
        depth: f32,
    },
    /// A setting outside its range.
    #[error("{what} = {value}: {limit}")]
    Setting {
        /// Its name.
        what: &'static str,
        /// As given.
        value: String,
        /// What is allowed.
        limit: &'static str,
    },
}

impl OpacityError {
    /// A setting that is out of range.
    pub fn setting(what: &'static str, value: impl ToString, limit: &'static str) -> Self {
        Self::Setting { what, value: value.to_string(), limit }
    }
}
