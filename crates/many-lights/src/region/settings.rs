//! Techniques of from-region visibility and what can be turned of each.

use crate::LightsError;

/// How occluders' shadows on a plane are joined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Fusion {
    /// Not at all: a cluster has to lie in the shadow of one occluder.
    None,
    /// In the order in which occluders arrive, whatever overlaps (the thesis).
    Insertion,
    /// At each plane anew, the tallest first: low ones no longer drag tall ones down.
    #[default]
    HeightOrdered,
}

/// The upper edge of a shadow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Edge {
    /// Level, at what is shadowed over its whole width.
    #[default]
    Flat,
    /// From the height at its left end to that at its right end (the thesis's single edge).
    Sloped,
    /// Every edge of it (of single occluders; joined shadows are level).
    Hull,
}

/// What stands for the buildings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum OccluderMode {
    /// Each box that lies inside a building.
    #[default]
    Leaf,
    /// Those, and besides them boxes of gap-free runs as high as their lowest.
    ContiguousMin,
    /// Boxes around clusters of buildings (the thesis): not sound, they fill streets and gaps.
    BoundingBoxes,
}

/// Where planes lie.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Planes {
    /// At occluders' far faces.
    #[default]
    FarFaces,
    /// So many metres behind them.
    Behind(f64),
    /// At even distances, metres.
    Every(f64),
}

/// How often a cluster that is hidden in part is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// Down to single lights.
    All,
    /// So many levels below the first that is hidden in part.
    Levels(u32),
}

/// Facade-cluster visibility.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacadeCluster {
    /// How shadows are joined.
    pub fusion: Fusion,
    /// Their upper edge.
    pub edge: Edge,
    /// What stands for buildings.
    pub occluders: OccluderMode,
    /// Where planes lie.
    pub planes: Planes,
    /// Planes are at least so far apart, metres, at least 0: far faces between are passed over.
    pub least_step_m: f64,
    /// Radiance of a white surface below which a cluster is left out, linear, at least 0; 0 leaves
    /// out only what gives nothing at all.
    pub threshold: f64,
    /// How far clusters are divided.
    pub split: Split,
    /// Whether what a cluster's projections on all planes have in common is kept from its first test to
    /// the later ones.
    pub cached: bool,
}

impl Default for FacadeCluster {
    fn default() -> Self {
        Self {
            fusion: Fusion::default(),
            edge: Edge::default(),
            occluders: OccluderMode::default(),
            planes: Planes::default(),
            least_step_m: 0.0,
            threshold: 1.0 / 1020.0,
            split: Split::All,
            cached: false,
        }
    }
}

/// Visibility by rays between points drawn in the cell and the lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampled {
    /// Rays a light, at least 1.
    pub rays: u32,
    /// Another one draws otherwise.
    pub seed: u32,
}

/// A technique with its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RegionTechnique {
    /// All lights.
    Everything,
    /// Facade-cluster visibility (Conte 2018).
    FacadeCluster(FacadeCluster),
    /// Extended projections on a raster of so many texels a side (Durand et al. 2000).
    ExtendedProjection {
        /// Texels a side.
        texels: u32,
    },
    /// By rays.
    Sampled(Sampled),
}

/// The most rays a light, and texels a side.
const MOST: u32 = 1 << 14;

impl RegionTechnique {
    /// Refuses settings that mean nothing.
    ///
    /// # Errors
    /// [`LightsError::Value`] that names the setting and its limit.
    pub fn check(&self) -> Result<(), LightsError> {
        let at_least = |name: &str, value: f64, least: f64| match value >= least {
            true => Ok(()),
            false => Err(LightsError::value(name, format!("{value} is not at least {least}"))),
        };
        let count = |name: &str, value: u32| match (1..=MOST).contains(&value) {
            true => Ok(()),
            false => Err(LightsError::value(name, format!("{value} is not in 1..={MOST}"))),
        };
        match self {
            Self::Everything => Ok(()),
            Self::FacadeCluster(settings) => {
                at_least("threshold", settings.threshold, 0.0)?;
                at_least("least step", settings.least_step_m, 0.0)?;
                match settings.planes {
                    Planes::FarFaces => Ok(()),
                    Planes::Behind(metres) => at_least("planes behind", metres, 0.0),
                    Planes::Every(metres) => at_least("planes every", metres, 1e-3),
                }
            }
            Self::ExtendedProjection { texels } => count("texels", *texels),
            Self::Sampled(settings) => count("rays", settings.rays),
        }
    }
}
