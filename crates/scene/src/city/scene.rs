//! A city as a scene: one instance an object, and where in the city each object belongs.

use crate::Scene;

/// Where an instance belongs: the path that a hierarchy over the city follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// One storey of one facade.
    Storey {
        /// Index into `City::blocks`.
        block: u32,
        /// Index into `City::buildings`.
        building: u32,
        /// Index into its facades.
        facade: u32,
        /// From 0 at the ground.
        storey: u32,
    },
    /// Roof and gables.
    Roof {
        /// Index into `City::blocks`.
        block: u32,
        /// Index into `City::buildings`.
        building: u32,
    },
    /// What lies flat.
    Ground {
        /// Index into `City::grounds`.
        ground: u32,
    },
    /// A tree: its crown is alpha-tested.
    Tree {
        /// Index into `City::trees`.
        tree: u32,
    },
}

/// A scene and the part that each of its instances is.
#[derive(Clone, Debug)]
pub struct CityScene {
    /// One instance an object. Every storey of every facade is the same mesh, scaled.
    pub scene: Scene,
    /// One an instance.
    pub parts: Vec<Part>,
}
