//! Cities: buildings with facades, storeys and lit windows, street lamps, trees, streets.
//!
//! A city is plain data, made by the seeded generator or read from CityJSON or OpenStreetMap.
//! Coordinates are those of scenes: metres, y up, right-handed; a footprint is a polygon of the
//! plane (x, z). Buildings of real cities are not axis-aligned, so a building carries its
//! footprint, an *outer* box that holds it (what may be culled with it) and *inner* boxes that lie
//! within it (what it may hide).

mod error;
mod footprint;
mod generate;
mod import;
mod inner;
mod rim;
mod scene;
mod templates;
mod types;
pub mod windows;

pub use error::CityError;
pub use footprint::MAX_CORNERS;
pub use generate::{BlockShape, Heights, Knobs, generate};
pub use import::{LoadedCity, load};
pub use inner::{InnerKnobs, covered_share, holds, inner_boxes};
pub use scene::{CityScene, Part};
pub use types::{
    Building, City, CityBytes, Facade, Footprint, Ground, GroundKind, OrientedBox, StreetLamp,
    Tree, WindowLight,
};
