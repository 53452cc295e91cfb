//! What can be turned of a whole frame.

use crate::{NightError, coherence::Keeping};
use dapple_many_lights::{
    Absolute, BoundForm, Per, Technique,
    region::{FacadeCluster, RegionTechnique, evaluate::MOST_HEIGHTS},
};
use dapple_occlusion::camera;

/// The smallest part of a city that is a cell of its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Part {
    /// All facades of a building.
    Building,
    /// All storeys of a facade.
    Facade,
    /// A storey of a facade.
    Storey,
    /// Whatever is drawn on its own.
    #[default]
    Any,
}

/// Columns times rows of the image that [`Night::tau_px`] is told for.
pub const TAU_IMAGE_PX: f64 = 1200.0 * 900.0;

/// A whole frame's techniques and knobs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Night {
    /// How what is seen is found.
    pub visibility: camera::Settings,
    /// A cell that covers more pixels is divided; pixels of an image of 1200 x 900.
    pub tau_px: f64,
    /// The smallest cell.
    pub split: Part,
    /// Whether a cell is around all that lies below its node, so that its precuts stay valid whatever
    /// comes into sight. Otherwise it is around what is visible: smaller, and found anew for more.
    pub whole_boxes: bool,
    /// How long precuts are kept, and how many.
    pub keeping: Keeping,
    /// Most precuts found in a frame; `None`: all that are needed. Cells that have to wait start at
    /// the lights of a cell above them, or at all lights. Needs [`Night::whole_boxes`].
    pub budget: Option<u32>,
    /// Whether all cells are found before the first frame: every part of the city at `split` is a
    /// cell, whatever it covers, and its precuts never expire.
    pub precomputed: bool,
    /// How precuts are found.
    pub region: RegionTechnique,
    /// Heights of a cell, beside its top, up to each of which it is found what of its precut is hidden
    /// from there; 0: none. Needs facade-cluster visibility.
    pub heights: u32,
    /// How pixels add them up.
    pub cut: Absolute,
    /// Whether each cluster that a pixel adds up costs a shadow ray.
    pub shadow_rays: bool,
}

impl Default for Night {
    fn default() -> Self {
        Self {
            // A node in sight is not asked: only the sum of what is below says what it covers.
            visibility: camera::Settings {
                coverage: camera::Coverage::Summed,
                ..camera::Settings::new(camera::Technique::ChcPlusPlus)
            },
            tau_px: 16_384.0,
            split: Part::default(),
            whole_boxes: true,
            keeping: Keeping { validity: Some(50), ..Keeping::default() },
            budget: None,
            precomputed: false,
            region: RegionTechnique::FacadeCluster(FacadeCluster::default()),
            heights: 0,
            cut: Absolute {
                threshold: 1.0 / 25_500.0,
                bound: BoundForm::default(),
                per: Per::default(),
            },
            shadow_rays: false,
        }
    }
}

impl Night {
    /// Refuses settings that mean nothing.
    ///
    /// # Errors
    /// [`NightError`] that names the setting and its limit.
    pub fn check(&self) -> Result<(), NightError> {
        self.visibility.check()?;
        self.region.check()?;
        Technique::Absolute(self.cut).check()?;
        if self.tau_px < 0.0 || self.tau_px.is_nan() {
            return Err(NightError::value("tau", format!("{} is not at least 0", self.tau_px)));
        }
        if self.keeping.validity == Some(0) {
            return Err(NightError::value("validity", "0 is not at least 1 frame"));
        }
        if self.heights > MOST_HEIGHTS {
            let limit = format!("{} is not at most {MOST_HEIGHTS}", self.heights);
            return Err(NightError::value("heights", limit));
        }
        if self.heights > 0 && !matches!(self.region, RegionTechnique::FacadeCluster(_)) {
            return Err(NightError::value("heights", "need facade-cluster visibility"));
        }
        if self.budget.is_some() && !self.whole_boxes {
            return Err(NightError::value("budget", "needs cells around all below a node"));
        }
        if self.precomputed && !self.whole_boxes {
            return Err(NightError::value("precomputed", "needs cells around all below a node"));
        }
        Ok(())
    }

    /// [`Night::tau_px`] in an image of so many columns and rows; a precomputed cell is always divided.
    pub fn tau_of(&self, [width, height]: [u32; 2]) -> u32 {
        if self.precomputed {
            return 0;
        }
        // Beyond the greatest it stays the greatest.
        (self.tau_px * f64::from(width) * f64::from(height) / TAU_IMAGE_PX).round() as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_threshold_scales_with_the_image() {
        let night = Night::default();
        assert_eq!(night.tau_of([1200, 900]), 16_384);
        assert_eq!(night.tau_of([300, 225]), 1024);
        assert_eq!(Night { precomputed: true, ..night }.tau_of([300, 225]), 0);
        assert_eq!(Night { tau_px: f64::INFINITY, ..night }.tau_of([300, 225]), u32::MAX);
    }

    #[test]
    fn settings_that_mean_nothing_are_refused_by_name() {
        let night = Night::default();
        night.check().unwrap();
        let refused = |night: Night| night.check().unwrap_err().to_string();
        assert!(refused(Night { tau_px: f64::NAN, ..night }).starts_with("tau: NaN"));
        let keeping = Keeping { validity: Some(0), ..night.keeping };
        assert!(refused(Night { keeping, ..night }).starts_with("validity: 0"));
        let cut = Absolute { threshold: -1.0, ..night.cut };
        assert!(refused(Night { cut, ..night }).starts_with("threshold: -1"));
        let drawn = Night { precomputed: true, whole_boxes: false, ..night };
        assert!(refused(drawn).starts_with("precomputed"));
        assert!(refused(Night { heights: 65, ..night }).starts_with("heights: 65"));
        let all = Night { heights: 1, region: RegionTechnique::Everything, ..night };
        assert!(refused(all).starts_with("heights: need"));
        let drawn = Night { budget: Some(4), whole_boxes: false, ..night };
        assert!(refused(drawn).starts_with("budget"));
        let visibility = camera::Settings { batch: 0, ..night.visibility };
        assert!(refused(Night { visibility, ..night }).starts_with("batch: 0"));
    }
}
