//! The knobs of a filter, their defaults and their limits.

use thiserror::Error;

/// How the statistics of a window become a visibility.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Estimator {
    /// One comparison with the nearest texel; the window's width is not used.
    Hard,
    /// Percentage-closer filtering (Reeves et al. 1987): the mean of the comparisons.
    Pcf {
        /// 0, or at least the window's width: every texel of the window. n: n x n texels spread
        /// over it, the i-th in column `floor((i + 1/2) * support / n)`.
        taps: u32,
    },
    /// Variance shadow map (Donnelly and Lauritzen 2006): Chebyshev's bound.
    Vsm {
        /// Which repair of the bound is used.
        variant: VsmVariant,
    },
    /// Gaussian fitted to mean and variance (Gumbau 2011, eq. 7.4).
    GaussianCdf,
    /// Power function fitted to minimum, maximum and mean (Gumbau 2011, eq. 7.7).
    PowerCdf,
    /// Exponential shadow map (Annen et al. 2008).
    Esm {
        /// What is stored and filtered.
        space: EsmSpace,
    },
    /// Layered variance shadow map (Lauritzen and McCool 2008).
    LayeredVsm {
        /// Where the layers begin.
        splits: Splits,
    },
    /// The Gaussian estimator over the warped depths of each layer.
    LayeredGaussian {
        /// Where the layers begin.
        splits: Splits,
    },
    /// The power estimator over the warped depths of each layer.
    LayeredPower {
        /// Where the layers begin.
        splits: Splits,
    },
    /// Exponential variance shadow map (Lauritzen and McCool 2008): Chebyshev's bound over
    /// exponentially warped depths.
    Evsm {
        /// Positive warp alone, or the smaller of both.
        components: EvsmComponents,
    },
    /// Moment shadow map, four power moments (Peters and Klein 2015).
    Msm,
}

impl Estimator {
    /// Every estimator in every variant; percentage-closer filtering with every texel. Tests and
    /// gates run over this list.
    #[must_use]
    pub fn every() -> Vec<Self> {
        use {EsmSpace as Space, EvsmComponents as Warps, VsmVariant as Vsm};
        let mut all = vec![Self::Hard, Self::Pcf { taps: 0 }];
        all.extend(
            [Vsm::Plain, Vsm::MinVariance, Vsm::Linstep, Vsm::Max]
                .map(|variant| Self::Vsm { variant }),
        );
        all.extend([Self::GaussianCdf, Self::PowerCdf]);
        all.extend([Space::Linear, Space::Log].map(|space| Self::Esm { space }));
        for splits in [Splits::Uniform, Splits::Lloyd] {
            all.push(Self::LayeredVsm { splits });
            all.push(Self::LayeredGaussian { splits });
            all.push(Self::LayeredPower { splits });
        }
        all.extend([Warps::Two, Warps::Four].map(|components| Self::Evsm { components }));
        all.push(Self::Msm);
        all
    }
}

/// Repairs of Chebyshev's bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum VsmVariant {
    /// The bound as it is; [`Settings::min_variance`] is not used.
    Plain,
    /// Variance raised to at least [`Settings::min_variance`].
    MinVariance,
    /// `MinVariance`, then visibilities up to [`Settings::bleed_reduction`] cut to 0 and the
    /// rest stretched over 0..=1.
    Linstep,
    /// `MinVariance`, and 0 for a receiver beyond the window's largest depth.
    Max,
}

/// What an exponential shadow map stores.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EsmSpace {
    /// `E[exp(c z)]`: plain linear filtering, overflows for large `c`.
    Linear,
    /// `ln(E[exp(c z)]) / c`, a depth: filtered by log-sum-exp, fits every format.
    Log,
}

/// Where layers begin and end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Splits {
    /// Layers of equal depth range.
    Uniform,
    /// Lloyd relaxation over the histogram of the map.
    Lloyd,
}

/// Channels of an exponential variance map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EvsmComponents {
    /// Positive warp: two moments.
    Two,
    /// Positive and negative warp: two moments each, the smaller bound counts.
    Four,
}

/// Weights of the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum KernelShape {
    /// Equal weights over `width_texels`.
    Box,
    /// Normal distribution of the same variance, `sigma = width / sqrt(12)`, cut at
    /// `ceil(3 sigma)` and normalised. Minimum and maximum are taken over this whole support.
    Gaussian,
}

/// How a channel is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// IEEE binary16, rounded to nearest even.
    F16,
    /// IEEE binary32.
    F32,
    /// 16-bit unsigned normalised integer: steps of 1/65535 over 0..=1.
    U16,
}

/// How the pre-filtered map is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Lookup {
    /// The texel that contains the receiver.
    Nearest,
    /// The four around it: channels blended (minimum and maximum conservatively) before the
    /// estimator; for `Hard` and `Pcf` the comparison results are blended.
    Bilinear,
}

/// The knobs of a filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Default: as given to [`Settings::new`].
    pub estimator: Estimator,
    /// Default: box.
    pub kernel: KernelShape,
    /// Width of the box in texels, odd, 1..=4095. Default 7.
    pub width_texels: u32,
    /// Default: 32-bit float.
    pub format: Format,
    /// Normalised depth subtracted from the receiver's, finite. Default 1e-3: above the rounding
    /// of 16-bit depths (4.9e-4 for floats below 1).
    pub bias: f32,
    /// Whether the receiver's slope moves the comparison: to the plane above each texel for `Hard`
    /// and `Pcf`, by half a texel's change for pre-filtered maps. Default off.
    pub plane_bias: bool,
    /// Default: bilinear.
    pub lookup: Lookup,
    /// Smallest variance, squared normalised depth (of the layer for layered estimators), used by
    /// every estimator with a variance but [`VsmVariant::Plain`]. Default 1e-5, 1e-4 in 16 bits.
    /// In an exponential variance map it is scaled by the warp's squared derivative, `(2 c)^2` of
    /// the receiver's: there it is also the least visibility in full shadow, `4 c^2 min_variance`,
    /// and the default is 1e-8 (the deviation of 1e-4 is twice the published one), 1e-5 in half
    /// floats.
    pub min_variance: f32,
    /// Visibility cut off by [`VsmVariant::Linstep`], 0..1. Default 0.2.
    pub bleed_reduction: f32,
    /// `c` of the exponential estimators, above 0. Default: ESM 80 (11 in half floats), EVSM 10
    /// (5.54 in half floats); limits in [`Settings::max_exponent`]. The published 42 of EVSM is
    /// the largest that fits f32, for a depth range around one split of a small window: where a
    /// window spans more than about `1 / 2c` of depth its nearest and its farthest texels alone
    /// decide, and both bounds are loose.
    pub exponent: f32,
    /// Layers of the layered estimators: 1, 2, 4 or 8. Default 4.
    pub layers: u32,
    /// How far moments are moved towards those of a fixed distribution, 0..1. Default 3e-6;
    /// 6e-5 in 16-bit integers; 2e-3 in half floats, whose steps are 32 times coarser. The
    /// published 3e-7 for 32 bits is the least that rounding asks for; ten times that also lights
    /// most of an unoccluded slope below a wide window
    /// ([`moments`](super::estimators::moments)), for a twentieth more error below narrow ones.
    pub moment_bias: f32,
}

/// Widest box, texels.
pub const MAX_WIDTH_TEXELS: u32 = 4095;

impl Settings {
    /// The documented defaults for an estimator, 32-bit floats.
    #[must_use]
    pub fn new(estimator: Estimator) -> Self {
        Self {
            estimator,
            kernel: KernelShape::Box,
            width_texels: 7,
            format: Format::F32,
            bias: 1e-3,
            plane_bias: false,
            lookup: Lookup::Bilinear,
            min_variance: 1e-5,
            bleed_reduction: 0.2,
            exponent: 80.0,
            layers: 4,
            moment_bias: 3e-6,
        }
        .with_format(Format::F32)
    }

    /// The same settings in another format, with that format's default exponent, minimum
    /// variance and moment bias.
    #[must_use]
    pub fn with_format(self, format: Format) -> Self {
        let half = format == Format::F16;
        let exponent = match self.estimator {
            Estimator::Evsm { .. } => {
                if half {
                    5.54
                } else {
                    10.0
                }
            }
            Estimator::Esm { space: EsmSpace::Linear } if half => 11.0,
            _ => 80.0,
        };
        let (min_variance, moment_bias) = match format {
            Format::F32 => (1e-5, 3e-6),
            Format::U16 => (1e-4, 6e-5),
            Format::F16 => (1e-4, 2e-3),
        };
        let min_variance = match self.estimator {
            Estimator::Evsm { .. } if half => 1e-5,
            Estimator::Evsm { .. } => 1e-8,
            _ => min_variance,
        };
        Self { format, exponent, min_variance, moment_bias, ..self }
    }

    /// Largest `exponent` whose channels fit the format; `None` where none can (integers cannot
    /// store a warped depth) and infinity where it is not limited.
    ///
    /// ESM stores `exp(c)` at most: c <= ln(max), 88.72 for floats and 11.09 for half floats,
    /// given as 88 and 11. EVSM warps depth to -1..=1 and stores `exp(2 c)`: half of that, given
    /// as 44 and 5.54. The log-space ESM stores depths in any format and is held to 700, where
    /// sums in f64 still have room.
    #[must_use]
    pub fn max_exponent(&self) -> Option<f32> {
        let stored = match self.format {
            Format::F32 => Some((88.0, 44.0)),
            Format::F16 => Some((11.0, 5.54)),
            Format::U16 => None,
        };
        match self.estimator {
            Estimator::Esm { space: EsmSpace::Linear } => stored.map(|(esm, _)| esm),
            Estimator::Evsm { .. } => stored.map(|(_, evsm)| evsm),
            Estimator::Esm { space: EsmSpace::Log } => Some(700.0),
            _ => Some(f32::INFINITY),
        }
    }

    /// Channels of a stored texel: those filtered by mean, minimum and maximum, all layers.
    #[must_use]
    pub fn channel_count(&self) -> u32 {
        match self.estimator {
            Estimator::Hard | Estimator::Pcf { .. } | Estimator::Esm { .. } => 1,
            Estimator::Vsm { variant: VsmVariant::Max } | Estimator::PowerCdf => 3,
            Estimator::Vsm { .. } | Estimator::GaussianCdf => 2,
            Estimator::LayeredVsm { .. } | Estimator::LayeredGaussian { .. } => 2 * self.layers,
            Estimator::LayeredPower { .. } => 3 * self.layers,
            Estimator::Evsm { components: EvsmComponents::Two } => 2,
            Estimator::Evsm { components: EvsmComponents::Four } | Estimator::Msm => 4,
        }
    }

    /// Bytes of a stored texel, all channels and layers, without padding.
    #[must_use]
    pub fn bytes_per_texel(&self) -> u32 {
        let channel = if self.format == Format::F32 { 4 } else { 2 };
        self.channel_count() * channel
    }

    /// Whether the map is filtered before it is read (all but `Hard` and `Pcf`).
    #[must_use]
    pub fn prefiltered(&self) -> bool {
        !matches!(self.estimator, Estimator::Hard | Estimator::Pcf { .. })
    }

    /// How the layers are split, where there are layers.
    #[must_use]
    pub fn splits(&self) -> Option<Splits> {
        match self.estimator {
            Estimator::LayeredVsm { splits }
            | Estimator::LayeredGaussian { splits }
            | Estimator::LayeredPower { splits } => Some(splits),
            _ => None,
        }
    }

    /// Checks every knob, and that a map of `map_width` x `map_height` texels exists.
    ///
    /// # Errors
    /// The [`FilterError`] that names the knob, its value and its limit.
    pub fn check(&self, map_width: u32, map_height: u32) -> Result<(), FilterError> {
        if map_width == 0 || map_height == 0 {
            return Err(FilterError::EmptyMap { width: map_width, height: map_height });
        }
        if self.width_texels.is_multiple_of(2) || self.width_texels > MAX_WIDTH_TEXELS {
            return Err(FilterError::Width { width: self.width_texels });
        }
        let knob = |name, value: f32, good: bool, limit| {
            if good { Ok(()) } else { Err(FilterError::Knob { name, value, limit }) }
        };
        knob("bias", self.bias, self.bias.is_finite(), "finite")?;
        let var = self.min_variance;
        knob("min_variance", var, (0.0..=1.0).contains(&var), "0..=1")?;
        let bleed = self.bleed_reduction;
        knob("bleed_reduction", bleed, (0.0..1.0).contains(&bleed), "0..1")?;
        let moment = self.moment_bias;
        knob("moment_bias", moment, (0.0..1.0).contains(&moment), "0..1")?;
        let c = self.exponent;
        knob("exponent", c, c > 0.0 && c.is_finite(), "above 0 and finite")?;
        match self.max_exponent() {
            None => return Err(FilterError::Unstorable { format: self.format }),
            Some(limit) if c > limit => {
                return Err(FilterError::Overflow { exponent: c, limit, format: self.format });
            }
            Some(_) => {}
        }
        if self.splits().is_some() && ![1, 2, 4, 8].contains(&self.layers) {
            return Err(FilterError::Layers { layers: self.layers });
        }
        Ok(())
    }
}

/// Why a filter refuses its input.
#[derive(Debug, Error, Clone, PartialEq)]
pub enum FilterError {
    /// A side of the map is 0.
    #[error("the depth map is empty ({width} x {height} texels)")]
    EmptyMap {
        /// Texels in a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// Depths and size do not agree.
    #[error("the depth map should hold {expected} depths and holds {actual}")]
    MapLength {
        /// `width * height`.
        expected: usize,
        /// Depths given.
        actual: usize,
    },
    /// Not the size the filter was made for.
    #[error("the filter was made for a map of {expected:?} texels and got {actual:?}")]
    MapSize {
        /// Width and height the filter was made for.
        expected: (u32, u32),
        /// Width and height of the map.
        actual: (u32, u32),
    },
    /// A depth that is no normalised depth.
    #[error("depth {depth} of texel {texel} is not within 0..=1")]
    Depth {
        /// Index into the depths.
        texel: usize,
        /// What it holds.
        depth: f32,
    },
    /// A window width that is even, 0 or too large.
    #[error("window width {width} is not an odd number within 1..={MAX_WIDTH_TEXELS}")]
    Width {
        /// Width given, texels.
        width: u32,
    },
    /// A knob out of its range.
    #[error("{name} is {value}, which is not {limit}")]
    Knob {
        /// Field of [`Settings`].
        name: &'static str,
        /// Value given.
        value: f32,
        /// Range allowed.
        limit: &'static str,
    },
    /// An exponent whose powers overflow the format.
    #[error("exponent {exponent} overflows {format:?}, whose limit is {limit}")]
    Overflow {
        /// Exponent given.
        exponent: f32,
        /// Largest exponent of the format.
        limit: f32,
        /// Format asked for.
        format: Format,
    },
    /// A format that cannot store the estimator's channels at all.
    #[error("{format:?} cannot store exponentially warped depths")]
    Unstorable {
        /// Format asked for.
        format: Format,
    },
    /// A number of layers that is not supported.
    #[error("{layers} layers asked for; 1, 2, 4 and 8 are supported")]
    Layers {
        /// Layers given.
        layers: u32,
    },
    /// An output of another length than the receivers.
    #[error("{receivers} receivers, but room for {outputs} results")]
    OutputLength {
        /// Receivers given.
        receivers: usize,
        /// Results there is room for.
        outputs: usize,
    },
    /// Shading before the map was filtered.
    #[error("the map was not filtered yet")]
    NotFiltered,
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{collections::HashSet, mem::discriminant};

    /// A new variant does not compile here: count its values, and list them in `every`.
    fn values_of_the_same_kind(estimator: Estimator) -> usize {
        match estimator {
            Estimator::Hard | Estimator::Pcf { .. } => 1,
            Estimator::GaussianCdf | Estimator::PowerCdf | Estimator::Msm => 1,
            Estimator::Esm { space: EsmSpace::Linear | EsmSpace::Log } => 2,
            Estimator::LayeredVsm { splits: Splits::Uniform | Splits::Lloyd }
            | Estimator::LayeredGaussian { .. }
            | Estimator::LayeredPower { .. } => 2,
            Estimator::Evsm { components: EvsmComponents::Two | EvsmComponents::Four } => 2,
            Estimator::Vsm { variant } => match variant {
                VsmVariant::Plain
                | VsmVariant::MinVariance
                | VsmVariant::Linstep
                | VsmVariant::Max => 4,
            },
        }
    }

    #[test]
    fn every_estimator_is_listed_once() {
        let all = Estimator::every();
        for estimator in &all {
            let same = all.iter().filter(|e| discriminant(*e) == discriminant(estimator)).count();
            assert_eq!(same, values_of_the_same_kind(*estimator), "{estimator:?}");
        }
        assert_eq!(all.iter().collect::<HashSet<_>>().len(), all.len());
        // Eleven kinds: this number is counted by hand from the enum above.
        let kinds: HashSet<_> = all.iter().map(discriminant).collect();
        assert_eq!((kinds.len(), all.len()), (11, 19));
    }
}
