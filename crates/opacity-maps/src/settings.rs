//! Everything that can be chosen. Plain data; [`Settings::check`] refuses what is out of range.

use crate::OpacityError;

/// A technique with its filter.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// What a texel stores.
    pub code: Code,
    /// Which texels a receiver reads.
    pub taps: Taps,
    /// What is averaged over them.
    pub blur: Blur,
    /// Light depth taken from the receiver's before any comparison, 0..=0.1; the ε of the thesis.
    pub bias: f32,
    /// How opaque casters take part.
    pub opaque: Opaque,
}

/// Texels a receiver reads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Taps {
    /// The nearest.
    #[default]
    One,
    /// Offsets -1, 0, 1 in u and v.
    Box3,
    /// Offsets -1.5 .. 1.5 in u and v.
    Box4,
    /// 16 jittered points in the square of `Box4`, one in each of its cells, hashed from the
    /// receiver's place.
    Stochastic16,
}

/// What is averaged over the taps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Blur {
    /// Each tap is decoded by its own texel, then transmittances are averaged.
    #[default]
    Transmittance,
    /// Stored numbers are averaged, then decoded once (thesis; linear codes alone).
    Stored,
}

/// How opaque casters take part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Opaque {
    /// In a depth map of their own, compared as in any shadow map.
    Separate,
    /// As one fragment of this optical thickness in the opacity maps (thesis: 3, first 10).
    Weight {
        /// Optical thickness, > 0.
        weight: f32,
        /// Whether that fragment also stretches the bounds. Where nothing translucent lies, it is
        /// the bounds either way, so that a trunk alone casts its shadow.
        in_bounds: bool,
    },
}

/// What a texel stores.
#[derive(Clone, Debug, PartialEq)]
pub enum Code {
    /// Nothing: T = 1 everywhere.
    Unshadowed,
    /// The nearest depth of anything: T = 0 behind it.
    Binary,
    /// Opacity in layers: OSM, DOM, BOM.
    Layered(Layered),
    /// Fourier opacity map.
    Fourier(Fourier),
    /// Adaptive volumetric shadow map.
    Adaptive(Adaptive),
    /// Moment-based transmittance.
    Moments(Moments),
    /// Stochastic shadow map.
    Stochastic(Stochastic),
    /// Compressed deep shadow map.
    Deep(Deep),
}

/// Layered opacity maps.
#[derive(Clone, Debug, PartialEq)]
pub struct Layered {
    /// Where layers lie.
    pub layout: Layout,
    /// Number of layers K, 1..=256.
    pub layers: u32,
    /// How a receiver reads them.
    pub lookup: Lookup,
    /// Light depth taken from a fragment's before it is put into a layer, 0..=0.1. The thesis takes
    /// the receivers' bias here too; with 0 a fragment's own layer begins behind its receiver.
    pub write_bias: f32,
    /// Thickness is multiplied by the share of taps whose first fragment lies in front of the
    /// receiver: a soft edge of the lit surface (thesis; with [`Blur::Stored`], and not for planes,
    /// which have no first fragment).
    pub soft_start: bool,
    /// How fragments are blended.
    pub blend: Blend,
    /// Storage of a layer.
    pub format: Format,
    /// How layers are spread over textures and passes. The result depends on it by rounding alone,
    /// save that [`Packing::Slabs`] clip each texture's sum by itself where a format clips, and
    /// that [`Blend::Alpha`] and [`Blend::Premultiplied`] need textures of four channels.
    pub packing: Packing,
    /// Graphics form: who adds. The result does not depend on it, but for rounding.
    pub storage: Storage,
    /// Graphics form: how the farthest depth is found. The result does not depend on it.
    pub end_map: EndMap,
}

/// Where layers lie along a ray.
#[derive(Clone, Debug, PartialEq)]
pub enum Layout {
    /// OSM: planes shared by all rays, from the first to the last translucent fragment.
    Planes(Slicing),
    /// DOM: from each ray's first fragment on, `span` of the light's depth range deep.
    Deep {
        /// Depth of all layers together, > 0; the last takes everything beyond.
        span: f32,
        /// Each layer is this many times as deep as the one before, 1..=4.
        growth: f32,
        /// The first layers' printed masks: fragments of layer k are missing from channels
        /// `c < k mod 4` of every later target.
        listing: bool,
    },
    /// BOM: between each ray's first and last fragment.
    Bounded {
        /// Where boundaries lie between the two.
        split: Split,
        /// How a layer coordinate becomes a layer.
        bins: Bins,
    },
}

/// How planes are placed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Slicing {
    /// Evenly.
    #[default]
    Uniform,
    /// At equal shares of all opacity.
    Density,
    /// Each gap a fixed factor (1.15) wider than the one before.
    Growing,
}

/// Layer coordinate u = H(t) of local depth t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Split {
    /// 0 uniform, 1 logarithmic, between them a mixture.
    pub lambda: f32,
    /// Which logarithm, and how it is evaluated.
    pub kind: SplitKind,
    /// Width N of the lookup texture, 3..=1024; also the logarithm's ratio N - 1.
    pub width: u32,
}

/// How the split function is evaluated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SplitKind {
    /// Arithmetic, normalised: log2(1 + (N - 2) t) / log2(N - 1).
    #[default]
    Normalised,
    /// The thesis's table of bytes, its exponent truncated: saturates at t = 0.5 for λ = 1.
    Listing,
    /// The normalised function in an N-texel table of bytes, read linearly.
    Table8,
    /// The same in 32-bit floats.
    Table32,
    /// Positions are mixed instead of coordinates, as parallel-split shadow maps do.
    Positions,
}

/// How a layer coordinate u in 0..=1 becomes one of K layers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Bins {
    /// floor(u K).
    #[default]
    Full,
    /// trunc(u (K - 1)), the thesis's: the last layer holds u = 1 alone.
    Thesis,
}

/// How a receiver reads layers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lookup {
    /// Between the sum up to the layer before and the sum up to its own.
    #[default]
    Lerp,
    /// The sum up to and including its own.
    Nearest,
    /// The sum up to the layer before.
    Exclusive,
}

/// Blend state of the opacity pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Blend {
    /// ONE, ONE.
    #[default]
    Add,
    /// ONE, 1 - SRC_COLOR: 1 - Π(1 - α) in every channel by itself.
    Over,
    /// SRC_ALPHA, 1 - SRC_ALPHA: channels are not independent.
    Alpha,
    /// ONE, 1 - SRC_ALPHA with one opacity in all four channels: channels are not independent.
    Premultiplied,
}

/// Storage of a layer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// 32-bit float.
    #[default]
    F32,
    /// 16-bit float, rounded to nearest after every addition.
    F16,
    /// 8 bits of 0..=1: sums clip at 1.
    Unorm8,
    /// 8 bits of 0..=1, thickness divided by 8 ln 2, so that T reaches 1/256.
    Unorm8Scaled,
    /// 32-bit fixed point with 20 binary digits, clipping at 4096: exact sums, any order.
    Fixed,
}

/// How layers are spread over textures and passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Packing {
    /// One texture and one pass a layer; a pass draws what lies in front of its plane.
    Single,
    /// Four layers a texture, one pass over the geometry a texture.
    Slabs,
    /// Four layers a texture, this many textures (1..=8) a pass; more passes where K needs them.
    Targets(u32),
    /// Fragments are sorted into slabs first and touched once.
    Sorted,
}

/// Who adds in the graphics form.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Storage {
    /// The blending unit, into render targets.
    #[default]
    Blend,
    /// Integer atomics on a storage buffer: the same bits in any order.
    Atomic,
}

/// How the graphics form finds each texel's farthest depth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EndMap {
    /// One pass for both ends: MAX blending of (-d, d).
    #[default]
    MaxBlend,
    /// One pass for both ends: atomic minimum and maximum.
    Atomic,
    /// A second pass with depth comparison GREATER.
    Greater,
    /// A second pass with near and far plane swapped.
    Swapped,
    /// A second pass with the depth range reversed.
    RangeFlip,
}

/// Fourier opacity map: Σ of the absorption's Fourier coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fourier {
    /// Cosine and sine pairs, 1..=15; 2 n + 1 coefficients a texel.
    pub pairs: u32,
    /// Whether depths are taken between each ray's bounds, or over the light's whole range.
    pub bounded: bool,
    /// Storage of a coefficient (F32 or F16).
    pub format: Format,
}

/// In which order fragments reach a lossy code.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// As they are drawn.
    #[default]
    Drawn,
    /// By depth.
    Sorted,
}

/// Adaptive volumetric shadow map: nodes (depth, transmittance) merged by least area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adaptive {
    /// Nodes a texel, 2..=64.
    pub nodes: u32,
    /// In which order fragments arrive.
    pub order: Order,
}

/// Moment-based transmittance: Σ ω z^j.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// Power moments, 4 or 6 (beside the zeroth).
    pub moments: u32,
    /// Pull towards safe moments, 0..=0.5; 0: the format's default.
    pub bias: f32,
    /// 0: the least transmittance that the moments allow, 1: the greatest.
    pub overestimation: f32,
    /// Whether depths are taken between each ray's bounds, or over the light's whole range.
    pub bounded: bool,
    /// Storage of a moment (F32 or F16).
    pub format: Format,
}

/// Stochastic shadow map: depths that survive a random test of their opacity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stochastic {
    /// Depths a texel, 1..=64.
    pub samples: u32,
    /// Of the hash.
    pub seed: u32,
}

/// Deep shadow map: piecewise linear transmittance within an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deep {
    /// Greatest error of a stored transmittance, 0..=0.5; 0 keeps every step.
    pub tolerance: f32,
    /// Most nodes a texel, 2..=1024; beyond them the tolerance grows.
    pub nodes: u32,
}

/// What a search for λ judges maps by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Criterion {
    /// Greatest sum of absolute differences of neighbouring maps.
    Sad,
    /// Least sum of correlations of neighbouring maps.
    Correlation,
    /// Least mutual information of neighbouring maps.
    MutualInformation,
    /// Least Σ (A_k - A_{k-1})²: layers of equal opacity.
    EqualOpacity,
    /// Least Σ (T_{k-1} - T_k)², T = e^-A: layers that each take the same share of light.
    EqualTransmittance,
    /// Least error of transmittance against sorted fragments.
    Oracle,
}

fn within<T: PartialOrd + ToString>(
    what: &'static str,
    value: T,
    range: std::ops::RangeInclusive<T>,
    limit: &'static str,
) -> Result<(), OpacityError> {
    if range.contains(&value) { Ok(()) } else { Err(OpacityError::setting(what, value, limit)) }
}

impl Settings {
    /// A code read at the nearest texel, with a bias of 1e-4 and opaque casters apart.
    #[must_use]
    pub fn plain(code: Code) -> Self {
        Self {
            code,
            taps: Taps::One,
            blur: Blur::Transmittance,
            bias: 1e-4,
            opaque: Opaque::Separate,
        }
    }

    /// Whether opaque casters stretch the bounds of rays.
    pub fn opaque_in_bounds(&self) -> bool {
        self.opaque.stretches_bounds()
    }

    /// Checks every number (NaN is out of every range) and that formats and blends fit the code.
    ///
    /// # Errors
    /// [`OpacityError::Setting`] naming the first that does not.
    pub fn check(&self) -> Result<(), OpacityError> {
        within("bias", self.bias, 0.0..=0.1, "0..=0.1")?;
        if let Opaque::Weight { weight, .. } = self.opaque
            && !(weight > 0.0 && weight <= 1e6)
        {
            return Err(OpacityError::setting("opaque weight", weight, "above 0, at most 1e6"));
        }
        match &self.code {
            Code::Unshadowed | Code::Binary => Ok(()),
            Code::Layered(layered) if layered.soft_start && self.blur != Blur::Stored => Err(
                OpacityError::setting("soft start", true, "only where stored sums are averaged"),
            ),
            Code::Layered(layered) => layered.check(),
            Code::Fourier(f) => {
                within("pairs", f.pairs, 1..=15, "1..=15")?;
                float_format(f.format)
            }
            Code::Adaptive(a) => within("nodes", a.nodes, 2..=64, "2..=64"),
            Code::Moments(m) => {
                if m.moments != 4 && m.moments != 6 {
                    return Err(OpacityError::setting("moments", m.moments, "4 or 6"));
                }
                within("moment bias", m.bias, 0.0..=0.5, "0..=0.5")?;
                within("overestimation", m.overestimation, 0.0..=1.0, "0..=1")?;
                float_format(m.format)
            }
            Code::Stochastic(s) => within("samples", s.samples, 1..=64, "1..=64"),
            Code::Deep(d) => {
                within("tolerance", d.tolerance, 0.0..=0.5, "0..=0.5")?;
                within("nodes", d.nodes, 2..=1024, "2..=1024")
            }
        }
    }
}

impl Opaque {
    /// Whether opaque casters stretch the bounds of rays.
    pub fn stretches_bounds(self) -> bool {
        matches!(self, Self::Weight { in_bounds: true, .. })
    }
}

impl Layered {
    fn check(&self) -> Result<(), OpacityError> {
        within("layers", self.layers, 1..=256, "1..=256")?;
        within("write bias", self.write_bias, 0.0..=0.1, "0..=0.1")?;
        if self.soft_start && matches!(self.layout, Layout::Planes(_)) {
            return Err(OpacityError::setting("soft start", true, "not for planes"));
        }
        if let Packing::Targets(targets) = self.packing {
            within("targets", targets, 1..=8, "1..=8")?;
        }
        let four = matches!(self.packing, Packing::Slabs | Packing::Targets(_));
        if matches!(self.blend, Blend::Alpha | Blend::Premultiplied) && !four {
            let limit = "alpha and premultiplied states need four channels: Slabs or Targets";
            return Err(OpacityError::setting("blend", format!("{:?}", self.blend), limit));
        }
        if matches!(self.layout, Layout::Deep { listing: true, .. })
            && self.packing == Packing::Slabs
        {
            let limit = "Slabs have no later textures, which the listing gets wrong";
            return Err(OpacityError::setting("listing", true, limit));
        }
        let whole = matches!(self.format, Format::Fixed | Format::Unorm8Scaled);
        if whole && self.blend != Blend::Add {
            return Err(OpacityError::setting(
                "blend",
                format!("{:?}", self.blend),
                "fixed point and scaled bytes can only be added",
            ));
        }
        match &self.layout {
            Layout::Planes(_) => Ok(()),
            Layout::Deep { span, growth, .. } => {
                within("span", *span, 1e-6..=10.0, "1e-6..=10")?;
                within("growth", *growth, 1.0..=4.0, "1..=4")
            }
            Layout::Bounded { split, .. } => {
                within("lambda", split.lambda, 0.0..=1.0, "0..=1")?;
                within("split width", split.width, 3..=1024, "3..=1024")
            }
        }
    }
}

fn float_format(format: Format) -> Result<(), OpacityError> {
    match format {
        Format::F32 | Format::F16 => Ok(()),
        _ => Err(OpacityError::setting("format", format!("{format:?}"), "F32 or F16")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_out_of_range_are_refused_by_name() {
        let deep = |tolerance| Settings::plain(Code::Deep(Deep { tolerance, nodes: 8 }));
        deep(0.01).check().unwrap();
        assert!(deep(f32::NAN).check().unwrap_err().to_string().contains("tolerance"));
        let mut biased = deep(0.01);
        biased.bias = -1.0;
        assert!(biased.check().unwrap_err().to_string().contains("bias"));
        biased.bias = 0.0;
        biased.opaque = Opaque::Weight { weight: 0.0, in_bounds: false };
        assert!(biased.check().unwrap_err().to_string().contains("weight"));
    }
}
