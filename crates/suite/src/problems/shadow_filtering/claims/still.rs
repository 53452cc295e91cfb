//! Scenes as the judges see them: receivers, truth and one depth map, prepared once and shared.

use super::super::{SPEC, ShadowCase, kernel_texels};
use super::scenes::{SLATS, SPHERES_COARSE, SPHERES_FINE, slats, spheres};
use crate::{
    SuiteError,
    case::Case,
    knob::{self, Knobs},
    scene,
};
use dapple_metrics::{leak_energy, rmse};
use dapple_shadows::filtering::{
    DepthMap, EsmSpace, Estimator, Format, Receiver, Settings, VsmVariant, cpu, lookup,
};
use std::{
    collections::BTreeMap,
    sync::{Arc, Mutex, PoisonError},
};

/// Side of the map of every quality figure, texels. With the default footprint of 0.015 the
/// window is 7 texels wide.
pub const RESOLUTION: u32 = 512;
/// Image columns; rows are 9/16 of it.
pub const WIDTH: u32 = 256;
/// Normalised-depth biases under which leaks are judged: the source gives none, and it is a
/// hidden knob of some estimators.
pub const BIASES: [f32; 4] = [5e-4, 1e-3, 2e-3, 5e-3];

/// The three scenes of the chapter with three seeds each, in the view where shadow falls into
/// shadow, and its figure 2.9.
pub const STILLS: [Recipe; 10] = [
    Recipe::of("spheres", "", 0),
    Recipe::of("spheres", "", 1),
    Recipe::of("spheres", "", 2),
    Recipe::of("chairs", "", 0),
    Recipe::of("chairs", "", 1),
    Recipe::of("chairs", "", 2),
    Recipe::of("car", "under the car", 0),
    Recipe::of("car", "under the car", 1),
    Recipe::of("car", "under the car", 2),
    Recipe::of("three_planes", "", 0),
];

/// What a still is made from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Recipe {
    scene: &'static str,
    view: &'static str,
    seed: u64,
    width: u32,
    truth_rays: u32,
    resolution: u32,
}

impl Recipe {
    /// A scene at the size of quality figures.
    pub const fn of(scene: &'static str, view: &'static str, seed: u64) -> Self {
        Self { scene, view, seed, width: WIDTH, truth_rays: 8, resolution: RESOLUTION }
    }

    /// The same for timing: another image and map, and a truth of one ray that nobody reads.
    pub const fn timed(self, width: u32, resolution: u32) -> Self {
        Self { width, resolution, truth_rays: 1, ..self }
    }

    /// Scene and seed.
    pub fn name(&self) -> String {
        format!("{}#{}", self.scene, self.seed)
    }

    fn load(&self) -> Result<scene::Loaded, SuiteError> {
        match self.scene {
            SLATS => scene::complete(slats(self.seed), Vec::new()),
            SPHERES_COARSE => scene::complete(spheres(1), Vec::new()),
            SPHERES_FINE => scene::complete(spheres(5), Vec::new()),
            name => scene::load(name, self.seed),
        }
    }

    /// The still, made at the first call.
    ///
    /// # Errors
    /// Those of [`ShadowCase::of`].
    pub fn still(&self) -> Result<Arc<Still>, SuiteError> {
        static MADE: Mutex<BTreeMap<Recipe, Arc<Still>>> = Mutex::new(BTreeMap::new());
        // An entry is whole or absent, whatever panicked elsewhere.
        let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(still) = made.get(self) {
            return Ok(Arc::clone(still));
        }
        let still = Arc::new(Still::new(self)?);
        made.insert(*self, Arc::clone(&still));
        Ok(still)
    }
}

/// Receivers, truth and depth map of one scene.
pub struct Still {
    /// Scene and seed.
    pub name: String,
    /// One a pixel.
    pub receivers: Vec<Receiver>,
    /// Which pixels take part.
    pub mask: Vec<bool>,
    /// Ray-traced visibility over the footprint.
    pub truth: Vec<f32>,
    /// Ray-cast.
    pub map: DepthMap,
    /// Triangles of the scene.
    pub triangles: usize,
    /// Window width, texels.
    pub kernel_texels: u32,
}

/// How much light an estimator lets into full shadow, and its error.
#[derive(Clone, Copy, Debug)]
pub struct Score {
    /// Mean visibility over the receivers in full shadow (truth exactly 0).
    pub leak: f64,
    /// Mean over the same receivers of what exceeds the exact share of the same stored texels
    /// beyond the same biased depth: light that the estimator makes up, free of undersampling and
    /// bias. (On a slanted lit receiver the exact share is too low, its own plane counting as an
    /// occluder; in full shadow something else hides all of the window.)
    pub bleed: f64,
    /// Share of these receivers where it exceeds that by more than [`SPOT`].
    pub spots: f64,
    /// Against truth, over all receivers.
    pub rmse: f64,
}

/// A made-up visibility that shows as a bright spot in a shadow: 13 of 255 grey levels.
pub const SPOT: f32 = 0.05;

impl Still {
    fn new(recipe: &Recipe) -> Result<Self, SuiteError> {
        let given = Knobs::from([
            ("width".into(), recipe.width.into()),
            ("truth_rays".into(), recipe.truth_rays.into()),
        ]);
        let case = Case {
            problem: SPEC.id.into(),
            scene: recipe.scene.into(),
            view: recipe.view.into(),
            seed: recipe.seed,
            parameters: knob::complete("parameter", SPEC.parameters, &given)?,
        };
        let made = ShadowCase::of(recipe.load()?, &case, None)?;
        Ok(Self {
            name: recipe.name(),
            receivers: made.receivers().to_vec(),
            mask: made.mask().to_vec(),
            truth: made.truth().to_vec(),
            map: (*made.depth_map(recipe.resolution)).clone(),
            triangles: made.tracer().traced_triangles(),
            kernel_texels: kernel_texels(made.footprint(), recipe.resolution),
        })
    }

    /// Visibility of every pixel by the processor's form.
    ///
    /// # Errors
    /// Settings that the filter refuses.
    pub fn shade(&self, s: &Settings) -> Result<Vec<f32>, SuiteError> {
        self.shade_at(&self.receivers, s)
    }

    fn shade_at(&self, receivers: &[Receiver], s: &Settings) -> Result<Vec<f32>, SuiteError> {
        let mut filter = cpu::Filter::new(self.map.width, self.map.height, s)?;
        filter.prefilter(&self.map)?;
        let mut out = vec![0.0; receivers.len()];
        filter.shade(&self.map, receivers, &mut out)?;
        Ok(out)
    }

    /// The share of the stored texels that the estimator of `s` tries to estimate: same window,
    /// lookup and biased depth, unrounded.
    ///
    /// # Errors
    /// Those of [`Still::shade`].
    pub fn exact(&self, s: &Settings) -> Result<Vec<f32>, SuiteError> {
        let biased = |r: &Receiver| Receiver {
            z: lookup::biased_depth(r, s, self.map.width, self.map.height),
            ..*r
        };
        let receivers: Vec<Receiver> = self.receivers.iter().map(biased).collect();
        let estimator = Estimator::Pcf { taps: 0 };
        let exact = Settings { estimator, bias: 0.0, plane_bias: false, format: Format::F32, ..*s };
        self.shade_at(&receivers, &exact)
    }

    /// The settings of this still's window: f32, box, bilinear, half a texel of slope as bias.
    pub fn settings(&self, estimator: Estimator, bias: f32) -> Settings {
        Settings {
            width_texels: self.kernel_texels,
            bias,
            plane_bias: true,
            ..Settings::new(estimator)
        }
    }

    /// Leak, bleed and error under `s`.
    ///
    /// # Errors
    /// Those of [`Still::shade`], or no receiver in full shadow.
    pub fn score(&self, s: &Settings) -> Result<Score, SuiteError> {
        let (result, exact) = (self.shade(s)?, self.exact(s)?);
        let mask = Some(self.mask.as_slice());
        let excess: Vec<f32> = result.iter().zip(&exact).map(|(v, e)| (v - e).max(0.0)).collect();
        let spot: Vec<f32> = excess.iter().map(|e| f32::from(u8::from(*e > SPOT))).collect();
        Ok(Score {
            leak: leak_energy(&result, &self.truth, mask)?,
            bleed: leak_energy(&excess, &self.truth, mask)?,
            spots: leak_energy(&spot, &self.truth, mask)?,
            rmse: rmse(&result, &self.truth, mask)?,
        })
    }

    /// Leak of the exact share itself: what resolution and bias alone let in.
    ///
    /// # Errors
    /// Those of [`Still::score`].
    pub fn exact_leak(&self, s: &Settings) -> Result<f64, SuiteError> {
        Ok(leak_energy(&self.exact(s)?, &self.truth, Some(&self.mask))?)
    }
}

/// Chebyshev's bound with the documented least variance.
pub const VSM: Estimator = Estimator::Vsm { variant: VsmVariant::MinVariance };
/// Chebyshev's bound with the window's maximum.
pub const VSM_MAX: Estimator = Estimator::Vsm { variant: VsmVariant::Max };
/// Exponential shadow map that cannot overflow.
pub const ESM: Estimator = Estimator::Esm { space: EsmSpace::Log };

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exact_share_does_not_bleed_and_a_lit_image_does() {
        let still = Recipe::of("three_planes", "", 0).timed(64, 128).still().unwrap();
        let s = still.settings(Estimator::Pcf { taps: 0 }, 1e-3);
        let pcf = still.score(&s).unwrap();
        // The receivers of this scene are level: the plane bias changes nothing.
        assert_eq!((pcf.bleed, pcf.spots), (0.0, 0.0));
        // A bias of the whole depth range lights everything, and the exact share with it.
        let lit = still.score(&Settings { bias: 1.0, ..s }).unwrap();
        assert_eq!((lit.leak, lit.bleed), (1.0, 0.0));
        let vsm = still.score(&still.settings(VSM, 1e-3)).unwrap();
        assert!(vsm.bleed > pcf.bleed && vsm.spots > 0.0, "{vsm:?}");
    }
}
