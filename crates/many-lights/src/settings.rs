//! Techniques and what can be turned of each.

use crate::LightsError;

/// How the greatest cosine of a box of directions is bounded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BoundForm {
    /// Exact for a box in a frame turned to the axis (Walter et al. 2005).
    Walter,
    /// By the farthest corner along the axis over the box's distance: fewer operations, looser.
    #[default]
    Cheap,
}

/// Over what one cut is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Per {
    /// Every pixel its own.
    #[default]
    Pixel,
    /// One for each 8 x 8 pixels, bounded over all of them: no lane waits for another.
    Tile,
}

/// How the worst node of a cut is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Selection {
    /// A heap.
    #[default]
    Heap,
    /// By looking at every node of the cut (the thesis's first attempt on a GPU).
    Scan,
}

/// R1 and R2: the node with the largest bound is split until every bound is at most `epsilon` of the
/// whole estimate (Walter et al. 2005).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lightcuts {
    /// Allowed bound of a node over the estimate of the pixel, at least 0.
    pub epsilon: f64,
    /// Most nodes of a cut, at least 1.
    pub most: u32,
    /// How the worst is found; the gpu form always scans.
    pub selection: Selection,
    /// How nodes are bounded.
    pub bound: BoundForm,
}

/// R3: a node is split while its bound exceeds its own estimate by more than a share of that.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relative {
    /// That share, at least 0.
    pub epsilon: f64,
    /// How nodes are bounded.
    pub bound: BoundForm,
}

/// R4: a node is split while its bound exceeds a fixed radiance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Absolute {
    /// That radiance, linear, at least 0; infinite for roots alone.
    pub threshold: f64,
    /// How nodes are bounded.
    pub bound: BoundForm,
    /// Over what one cut is made.
    pub per: Per,
}

/// Lights drawn by chance down a tree, in proportion to their importance (Conty Estevez and Kulla
/// 2018).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightBvh {
    /// Lights drawn a pixel, at least 1.
    pub samples: u32,
}

/// A light drawn by chance in every node of a cut (Yuksel 2019).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StochasticLightcuts {
    /// Nodes of the cut: so many lights are drawn a pixel. At least 1.
    pub cut: u32,
    /// Whether the cut is made once for 8 x 8 pixels, at one of them by chance (Lin and Yuksel
    /// 2020).
    pub real_time: bool,
}

/// Reservoir resampling with reuse over space and time (Bitterli et al. 2020).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reservoirs {
    /// Lights drawn a pixel and frame as candidates, at least 1.
    pub candidates: u32,
    /// Whether the reservoir of the frame before is reused.
    pub temporal: bool,
    /// Most candidates that it may stand for, over those of this frame.
    pub history: u32,
    /// Neighbours looked at a pixel; 0 for none.
    pub neighbours: u32,
    /// How far away they are at most, pixels.
    pub radius_px: f64,
    /// Whether candidates that neighbours could not have drawn are counted (unbiased), or all are
    /// (biased, as first published for speed).
    pub unbiased: bool,
}

/// Lights of finite reach, listed by boxes of space (Olsson et al. 2012).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clustered {
    /// Radiance below which a light is left out: its reach is where a white surface that faces it
    /// gives that much. More than 0.
    pub cutoff: f64,
    /// Pixels a side of a cluster, at least 1.
    pub tile: u32,
    /// Slices of depth, growing by a constant factor, at least 1.
    pub slices: u32,
    /// Whether what is left within reach is faded to 0 at its end, as engines do.
    pub window: bool,
}

/// A fixed most number of lights: the strongest of each 8 x 8 pixels, by a bound of what they give
/// there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capped {
    /// Most lights, at least 1.
    pub most: u32,
}

/// A technique with its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Technique {
    /// R0: every light at every pixel.
    BruteForce,
    /// R1, R2.
    Lightcuts(Lightcuts),
    /// R3.
    Relative(Relative),
    /// R4.
    Absolute(Absolute),
    /// Importance sampling.
    LightBvh(LightBvh),
    /// A light by chance a node of a cut.
    StochasticLightcuts(StochasticLightcuts),
    /// Resampling with reuse.
    Reservoirs(Reservoirs),
    /// Lights of finite reach.
    Clustered(Clustered),
    /// A fixed most number.
    Capped(Capped),
}

impl Technique {
    /// Refuses settings out of range.
    ///
    /// # Errors
    /// [`LightsError::Value`] that names the setting.
    pub fn check(&self) -> Result<(), LightsError> {
        let least = |name: &str, value: f64, least: f64| {
            // Written so that what is not a number is refused.
            if value >= least {
                return Ok(());
            }
            Err(LightsError::value(name, format!("{value} is not at least {least}")))
        };
        match self {
            Self::BruteForce => Ok(()),
            Self::Lightcuts(s) => {
                least("epsilon", s.epsilon, 0.0)?;
                least("most", f64::from(s.most), 1.0)
            }
            Self::Relative(s) => least("epsilon", s.epsilon, 0.0),
            Self::Absolute(s) => least("threshold", s.threshold, 0.0),
            Self::LightBvh(s) => least("samples", f64::from(s.samples), 1.0),
            Self::StochasticLightcuts(s) => least("cut", f64::from(s.cut), 1.0),
            Self::Reservoirs(s) => {
                least("candidates", f64::from(s.candidates), 1.0)?;
                least("radius", s.radius_px, 0.0)
            }
            Self::Clustered(s) => {
                least("cutoff", s.cutoff, f64::MIN_POSITIVE)?;
                least("tile", f64::from(s.tile), 1.0)?;
                least("slices", f64::from(s.slices), 1.0)
            }
            Self::Capped(s) => least("most", f64::from(s.most), 1.0),
        }
    }
}
