//! How far a port may be from the reference, and a rasterised map from a ray-cast one.

use crate::problem::Checked;
use dapple_shadows::filtering::{DepthMap, Estimator, Format, Settings, reference::Expected};

/// Share of receivers that may lie outside their bounds in 16 bits: there a value on a tie may be
/// rounded the other way, which moves its neighbours by a step more than the bounds allow. Random
/// maps show one receiver in 10^6, of which one is 0.5 % of a small map's 200.
pub const TIES: f64 = 5e-3;

/// The same for four moments in 32 bits, with which solving the matrix of the moments in f32
/// loses more than any rounding of the moments would: seen at one receiver in 20 000, by 2e-5 to
/// 3e-3 of visibility, where the window is almost one depth or a root is far away.
pub const UNSTABLE: f64 = 5e-3;

/// Share of receivers that may lie outside their bounds: none in 32 bits, four moments excepted.
pub fn share_allowed(settings: &Settings) -> f64 {
    match (settings.format, settings.estimator) {
        (Format::F32, Estimator::Msm) => UNSTABLE,
        (Format::F32, _) => 0.0,
        (Format::F16 | Format::U16, _) => TIES,
    }
}

/// How far a port is from the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// Largest difference of visibility; infinite where a value is not finite.
    pub max: f64,
    /// Share of receivers outside their bounds.
    pub share_beyond: f64,
}

impl Deviation {
    /// Compares values, one a receiver.
    pub fn between(port: &[f32], expected: &[Expected]) -> Self {
        let difference = |(got, e): (&f32, &Expected)| {
            let d = (f64::from(*got) - e.value).abs();
            if d.is_nan() { f64::INFINITY } else { d }
        };
        let pairs = || port.iter().zip(expected);
        let beyond = pairs().filter(|(got, e)| !e.allows(**got)).count();
        Self {
            max: pairs().map(difference).fold(0.0, f64::max),
            share_beyond: beyond as f64 / expected.len().max(1) as f64,
        }
    }

    /// Whether a port may be so far off.
    pub fn allowed(&self, settings: &Settings) -> bool {
        self.share_beyond <= share_allowed(settings) && self.max.is_finite()
    }

    /// Words for a port that is further off than it may be.
    pub fn violation(&self, settings: &Settings) -> Option<String> {
        (!self.allowed(settings)).then(|| {
            format!(
                "port: {:.2} % of receivers lie outside what rounding can do to them (allowed: {} \
                 %; largest difference from the reference {:.5})",
                100.0 * self.share_beyond,
                100.0 * share_allowed(settings),
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

    fn power(format: Format) -> Settings {
        Settings::new(Estimator::PowerCdf).with_format(format)
    }

    #[test]
    fn a_port_that_is_not_a_number_is_a_violation_whatever_the_share() {
        let expected = vec![Expected { value: 0.5, low: 0.49, high: 0.51 }; 1000];
        let violation =
            |port: &[f32], format| Deviation::between(port, &expected).violation(&power(format));
        let mut port = vec![0.505; 1000];
        assert_eq!(violation(&port, Format::F32), None);
        port[3] = f32::NAN;
        assert!(violation(&port, Format::U16).is_some());
    }

    #[test]
    fn one_receiver_outside_its_bounds_is_too_many_in_32_bits_and_a_tie_in_16() {
        let expected = vec![Expected { value: 0.5, low: 0.49, high: 0.51 }; 1000];
        let mut port = vec![0.5; 1000];
        port[..5].fill(0.52);
        let deviation = Deviation::between(&port, &expected);
        assert_eq!(deviation.share_beyond, 5e-3);
        assert!((deviation.max - 0.02).abs() < 1e-7);
        assert!(deviation.allowed(&power(Format::F16)) && !deviation.allowed(&power(Format::F32)));
        assert!(deviation.allowed(&Settings::new(Estimator::Msm)));
        port[5] = 0.48;
        assert!(Deviation::between(&port, &expected).violation(&power(Format::F16)).is_some());
        port.fill(0.5);
        port[7] = 0.52;
        assert!(Deviation::between(&port, &expected).violation(&power(Format::F32)).is_some());
    }
}
