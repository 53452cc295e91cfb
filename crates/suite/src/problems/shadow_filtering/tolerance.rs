//! How far a port may be from the reference, and a rasterised map from a ray-cast one.

use crate::problem::Checked;
use dapple_shadows::filtering::{DepthMap, Estimator, Format, Settings};

/// How a port may deviate: `beyond` is the share of receivers that may exceed `visibility`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Name, for messages.
    pub name: &'static str,
    /// Deviation of visibility.
    pub visibility: f64,
    /// Share of receivers that may exceed it.
    pub beyond: f64,
}

/// Comparisons of stored depths: decided on the same f32 values in every form, so only the sum of
/// the weights rounds. A slope moved by f32 rounding can tip a near-tie.
pub const COMPARED: Tolerance = Tolerance { name: "compared", visibility: 1e-4, beyond: 5e-3 };

/// Channels of 32 bits: what is left of E[z^2] - E[z]^2 in f32 is good to about 1e-7, which a
/// least variance of 1e-5 turns into 1 % of the variance and 0.25 % of visibility. Windows of
/// (nearly) one depth are steps, and rounding may tip them.
pub const FILTERED: Tolerance = Tolerance { name: "filtered", visibility: 5e-3, beyond: 1e-2 };

/// Four moments in 32 bits: the moment bias of 3e-7 keeps the pivots of the moments' matrix just
/// above the rounding of f32, so solving it keeps two digits.
pub const SOLVED: Tolerance = Tolerance { name: "solved", visibility: 3e-2, beyond: 2e-2 };

/// Channels of 16 bits: ports round once more, between the passes, by half a step: 2^-12 for half
/// floats below 1. The estimators' slopes carry that to a few hundredths of visibility.
pub const ROUNDED: Tolerance = Tolerance { name: "rounded", visibility: 5e-2, beyond: 1e-2 };

/// Mean and mean square in half floats: half a step of 2^-11 against a least variance of 1e-4 is
/// most of the variance, so single receivers may differ wildly (what the source calls broken).
pub const CANCELLED: Tolerance = Tolerance { name: "cancelled", visibility: 5e-2, beyond: 5e-2 };

/// The tolerance that settings call for.
pub fn of(settings: &Settings) -> Tolerance {
    match (settings.estimator, settings.format) {
        (Estimator::Hard | Estimator::Pcf { .. }, _) => COMPARED,
        (Estimator::Msm, Format::F32) => SOLVED,
        (_, Format::F32) => FILTERED,
        (
            Estimator::Vsm { .. }
            | Estimator::GaussianCdf
            | Estimator::LayeredVsm { .. }
            | Estimator::LayeredGaussian { .. },
            Format::F16,
        ) => CANCELLED,
        (_, Format::F16 | Format::U16) => ROUNDED,
    }
}

/// How far a port is from the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// Largest difference; infinite where a value is not finite.
    pub max: f64,
    /// Share of receivers beyond the tolerance.
    pub share_beyond: f64,
}

impl Deviation {
    /// Compares values, one a receiver.
    pub fn between(port: &[f32], reference: &[f64], settings: &Settings) -> Self {
        let limit = of(settings).visibility;
        let difference = |(a, b): (&f32, &f64)| {
            let d = (f64::from(*a) - b).abs();
            if d.is_nan() { f64::INFINITY } else { d }
        };
        let differences: Vec<f64> = port.iter().zip(reference).map(difference).collect();
        let beyond = differences.iter().filter(|d| **d > limit).count();
        Self {
            max: differences.iter().fold(0.0, |most, d| most.max(*d)),
            share_beyond: beyond as f64 / differences.len().max(1) as f64,
        }
    }

    /// Words for a broken tolerance.
    pub fn violation(&self, settings: &Settings) -> Option<String> {
        let t = of(settings);
        let broken = self.share_beyond > t.beyond || self.max.is_infinite();
        broken.then(|| {
            format!(
                "port: {:.2} % of receivers deviate by more than {} from the reference (tolerance \
                 `{}`: {} %; largest {:.3})",
                100.0 * self.share_beyond,
                t.visibility,
                t.name,
                100.0 * t.beyond,
                self.max
            )
        })
    }
}

/// A texel counts as different when its depths differ by more than this.
pub const DEPTH_STEP: f32 = 1e-3;

/// Share of a map's texels that may differ between rasteriser and rays: those whose centre lies
/// within the rasteriser's sub-pixel step of a triangle's edge. Models of 10^4 to 10^5 triangles
/// show 1e-6 to 6e-5 of them on maps of 256 to 1024 texels.
pub const DEPTH_TEXELS: f64 = 1e-3;

/// Texels that may differ in any case: a small map has few.
pub const DEPTH_TEXELS_FREE: usize = 4;

/// Holds a rasterised map against a ray-cast one.
pub fn check_raster(cast: &DepthMap, raster: &DepthMap, checked: &mut Checked) {
    let same = |(a, b): &(&f32, &f32)| (*a - *b).abs() <= DEPTH_STEP;
    let different = cast.depths.iter().zip(&raster.depths).filter(|p| !same(p)).count();
    let share = different as f64 / cast.depths.len().max(1) as f64;
    checked.port_errors.insert("depth_texels".into(), share);
    if share > DEPTH_TEXELS && different > DEPTH_TEXELS_FREE {
        checked.violations.push(format!(
            "depth: {:.2} % of texels differ by more than {DEPTH_STEP} between rasteriser and rays \
             (tolerance {} %)",
            100.0 * share,
            100.0 * DEPTH_TEXELS
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shifted_map_is_caught_and_a_few_edge_texels_are_not() {
        let depths: Vec<f32> = (0..100).map(|i| if i % 10 < 5 { 0.2 } else { 0.7 }).collect();
        let cast = DepthMap { width: 10, height: 10, depths };
        let mut edge = cast.clone();
        edge.depths[4] = 0.7;
        edge.depths[7] = f32::NAN;
        let mut checked = Checked::default();
        check_raster(&cast, &edge, &mut checked);
        assert_eq!(checked.port_errors["depth_texels"], 0.02);
        assert!(checked.violations.is_empty());
        let mut shifted = cast.clone();
        shifted.depths.rotate_left(1);
        check_raster(&cast, &shifted, &mut checked);
        assert_eq!(checked.violations.len(), 1);
    }

    #[test]
    fn a_port_that_is_not_a_number_is_a_violation_whatever_the_share() {
        let settings = Settings::new(Estimator::PowerCdf);
        let mut port = vec![0.5; 1000];
        let reference = vec![0.5; 1000];
        assert!(Deviation::between(&port, &reference, &settings).violation(&settings).is_none());
        port[3] = f32::NAN;
        assert!(Deviation::between(&port, &reference, &settings).violation(&settings).is_some());
        let off = vec![0.52; 1000];
        assert!(Deviation::between(&off, &reference, &settings).violation(&settings).is_some());
    }
}
