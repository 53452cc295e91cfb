//! How objects are drawn and samples counted.

use crate::OcclusionError;
use crate::camera::Readiness;
use dapple_gpu::Abilities;

/// How a list of objects becomes draw calls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Drawing {
    /// One call an object, in the order given.
    #[default]
    PerObject,
    /// One call for all objects of a template between two batches of queries, in the order of the
    /// templates. The image is the same, but where two objects have equal depth.
    Instanced,
    /// One call for two triangles of an object: a quad.
    PerQuad,
}

/// How the samples of a query are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Counting {
    /// By queries where the device's count exactly, else by atomics.
    #[default]
    Auto,
    /// By the device's occlusion queries, which must count exactly.
    Query,
    /// By fragments that compare depths and add to a count.
    Atomic,
    /// By the device's occlusion queries, which need only tell none from some: counts are 0 or 1.
    Boolean,
}

/// What a renderer is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// How objects are drawn.
    pub drawing: Drawing,
    /// How samples are counted.
    pub counting: Counting,
    /// When answers are there.
    pub readiness: Readiness,
}

/// A deliberate fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Samples of a query pass behind what has been drawn.
    ReversedQuery,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            drawing: Drawing::default(),
            counting: Counting::default(),
            readiness: Readiness::Polled,
        }
    }
}

impl Counting {
    /// What counts on a device of these abilities: never `Auto`.
    ///
    /// # Errors
    /// A way that the device's probe found wanting.
    pub fn on(self, abilities: &Abilities) -> Result<Self, OcclusionError> {
        let refused = |what: &str| {
            Err(OcclusionError::value(
                "counting",
                format!("occlusion queries of this device do not {what}"),
            ))
        };
        match self {
            Self::Auto if abilities.occlusion_exact_counts => Ok(Self::Query),
            Self::Auto => Ok(Self::Atomic),
            Self::Query if !abilities.occlusion_exact_counts => refused("count samples"),
            Self::Boolean if !abilities.occlusion_boolean => refused("tell none from some"),
            given => Ok(given),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counting_follows_what_the_probe_found() {
        let none = Abilities::default();
        let boolean = Abilities { occlusion_boolean: true, ..none.clone() };
        let exact = Abilities { occlusion_exact_counts: true, ..boolean.clone() };
        assert_eq!(Counting::Auto.on(&exact).unwrap(), Counting::Query);
        assert_eq!(Counting::Auto.on(&boolean).unwrap(), Counting::Atomic);
        assert_eq!(Counting::Atomic.on(&none).unwrap(), Counting::Atomic);
        assert_eq!(Counting::Boolean.on(&boolean).unwrap(), Counting::Boolean);
        assert!(Counting::Boolean.on(&none).is_err());
        let error = Counting::Query.on(&boolean).unwrap_err();
        assert_eq!(
            error.to_string(),
            "counting: occlusion queries of this device do not count samples"
        );
    }
}
