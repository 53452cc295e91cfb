//! Which channels an estimator stores, how each is filtered, and how they are read.
//!
//! Order of the channels: mean, mean square (VSM, Gaussian CDF) and maximum (VSM with maximum);
//! mean, minimum, maximum (power CDF); the same per layer, near layer first; mean and mean square
//! of the positive, then of the negative warp (EVSM); four moments (MSM), in 16-bit formats after
//! [`moments::to_stored`].

use std::ops::Range;

use super::estimators::layered::Layers;
use super::estimators::{
    Real, chebyshev, exponential, exponential_variance, gaussian, moments, power,
};
use super::{DepthMap, EsmSpace, Estimator, EvsmComponents, Format, Settings, Splits, VsmVariant};

/// Most channels one lookup reads.
pub const MAX_READ: usize = 4;

/// How a channel is filtered over a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reduction {
    /// Weighted mean.
    Mean,
    /// `ln(weighted mean of exp(c x)) / c`.
    LogMean,
    /// Minimum over the support.
    Min,
    /// Maximum over the support.
    Max,
}

/// The channels of one estimator over one map.
#[derive(Clone, Debug)]
pub struct Channels {
    settings: Settings,
    layers: Layers,
}

impl Channels {
    /// The channels of checked settings; the map matters for Lloyd splits only.
    #[must_use]
    pub fn new(settings: &Settings, map: &DepthMap) -> Self {
        let (splits, count) = match settings.splits() {
            Some(splits) => (splits, settings.layers),
            None => (Splits::Uniform, 1),
        };
        Self { settings: *settings, layers: Layers::new(splits, count, map) }
    }

    /// The layers; one over the whole depth where the estimator has none.
    #[must_use]
    pub fn layers(&self) -> &Layers {
        &self.layers
    }

    /// Channels of one layer (all channels where there are no layers): what one lookup reads.
    #[must_use]
    pub fn per_layer(&self) -> usize {
        self.settings.channel_count() as usize / self.layers.as_slice().len()
    }

    /// How a channel is filtered.
    #[must_use]
    pub fn reduction(&self, channel: usize) -> Reduction {
        match (self.settings.estimator, channel % self.per_layer()) {
            (Estimator::PowerCdf | Estimator::LayeredPower { .. }, 1) => Reduction::Min,
            (Estimator::PowerCdf | Estimator::LayeredPower { .. }, 2) => Reduction::Max,
            (Estimator::Vsm { variant: VsmVariant::Max }, 2) => Reduction::Max,
            (Estimator::Esm { space: EsmSpace::Log }, _) => Reduction::LogMean,
            _ => Reduction::Mean,
        }
    }

    /// A depth's value in a channel, not yet rounded to the format.
    #[inline]
    #[must_use]
    pub fn pack<R: Real>(&self, channel: usize, z: R) -> R {
        let c = R::of(f64::from(self.settings.exponent));
        let square = |x: R| x * x;
        match self.settings.estimator {
            Estimator::Hard | Estimator::Pcf { .. } | Estimator::PowerCdf => z,
            Estimator::Vsm { .. } | Estimator::GaussianCdf => {
                if channel == 1 {
                    square(z)
                } else {
                    z
                }
            }
            Estimator::Esm { space: EsmSpace::Linear } => exponential::warp(z, c),
            Estimator::Esm { space: EsmSpace::Log } => z,
            Estimator::LayeredVsm { .. } | Estimator::LayeredGaussian { .. } => {
                let warped = self.layers.as_slice()[channel / 2].occluder(z);
                if channel % 2 == 1 { square(warped) } else { warped }
            }
            Estimator::LayeredPower { .. } => self.layers.as_slice()[channel / 3].occluder(z),
            Estimator::Evsm { .. } => match channel {
                0 => exponential_variance::warp_positive(z, c),
                1 => square(exponential_variance::warp_positive(z, c)),
                2 => exponential_variance::warp_negative(z, c),
                _ => square(exponential_variance::warp_negative(z, c)),
            },
            Estimator::Msm if self.settings.format == Format::F32 => moments::pack(z)[channel],
            Estimator::Msm => moments::to_stored(moments::pack(z))[channel],
        }
    }

    /// Channels that a receiver of biased depth `z` reads: those of its layer.
    #[inline]
    #[must_use]
    pub fn read<R: Real>(&self, z: R) -> Range<usize> {
        let first = self.layers.select(z) * self.per_layer();
        first..first + self.per_layer()
    }

    /// The value of a channel between four texels (shares sum to 1): blended, but minimum and
    /// maximum over all four whatever their share, so that they stay conservative.
    #[inline]
    #[must_use]
    pub fn blend<R: Real>(&self, channel: usize, corners: [(R, R); 4]) -> R {
        let c = R::of(f64::from(self.settings.exponent));
        let [(wa, a), (wb, b), (wc, c0), (wd, d)] = corners;
        match self.reduction(channel) {
            Reduction::Mean => wa * a + wb * b + wc * c0 + wd * d,
            Reduction::LogMean => exponential::log_mean(corners.into_iter(), c),
            Reduction::Min => a.at_most(b).at_most(c0.at_most(d)),
            Reduction::Max => a.at_least(b).at_least(c0.at_least(d)),
        }
    }

    /// The visibility of a receiver of biased depth `z` from the channels it read
    /// ([`Channels::read`]), in order; unused places of `stats` are ignored.
    #[inline]
    #[must_use]
    pub fn visibility<R: Real>(&self, stats: &[R; MAX_READ], z: R) -> R {
        let s = &self.settings;
        let [first, second, third, _] = *stats;
        let c = R::of(f64::from(s.exponent));
        let min_variance = R::of(f64::from(s.min_variance));
        let degenerate = R::of(f64::from(s.format.degenerate_range()));
        let zero = R::of(0.0);
        let warped = || self.layers.as_slice()[self.layers.select(z)].receiver(z);
        match s.estimator {
            // Not pre-filtered: the one channel is the stored depth.
            Estimator::Hard | Estimator::Pcf { .. } => {
                super::estimators::step::visibility(first, z)
            }
            Estimator::Vsm { variant: VsmVariant::Plain } => {
                chebyshev::visibility(first, second, z, zero)
            }
            Estimator::Vsm { variant: VsmVariant::MinVariance } => {
                chebyshev::visibility(first, second, z, min_variance)
            }
            Estimator::Vsm { variant: VsmVariant::Linstep } => chebyshev::reduce_bleeding(
                chebyshev::visibility(first, second, z, min_variance),
                R::of(f64::from(s.bleed_reduction)),
            ),
            Estimator::Vsm { variant: VsmVariant::Max } => {
                chebyshev::visibility_max(first, second, third, z, min_variance)
            }
            Estimator::GaussianCdf => gaussian::visibility(first, second, z, min_variance),
            Estimator::PowerCdf => power::visibility(second, third, first, z, degenerate),
            Estimator::Esm { space: EsmSpace::Linear } => exponential::visibility(first, z, c),
            Estimator::Esm { space: EsmSpace::Log } => exponential::visibility_log(first, z, c),
            Estimator::LayeredVsm { .. } => {
                chebyshev::visibility(first, second, warped(), min_variance)
            }
            Estimator::LayeredGaussian { .. } => {
                gaussian::visibility(first, second, warped(), min_variance)
            }
            Estimator::LayeredPower { .. } => {
                power::visibility(second, third, first, warped(), degenerate)
            }
            Estimator::Evsm { components: EvsmComponents::Two } => {
                exponential_variance::visibility2(first, second, z, c, min_variance)
            }
            Estimator::Evsm { components: EvsmComponents::Four } => {
                exponential_variance::visibility4(*stats, z, c, min_variance)
            }
            Estimator::Msm => {
                let sixteen_bit = s.format != Format::F32;
                let b = if sixteen_bit { moments::from_stored(*stats) } else { *stats };
                let target = R::of(moments::bias_target(sixteen_bit));
                moments::visibility(b, z, R::of(f64::from(s.moment_bias)), target)
            }
        }
    }
}
