//! What a technique adds to the opaque map and to shading. One match a question: a technique is a
//! variant here and a file beside.

use super::{
    OpacityGpuError,
    bounds::Bounds,
    layered::LayeredMaps,
    nearest::Nearest,
    raster::Raster,
    series::{Series, SeriesKind},
    shade::Decoder,
    survivors::Survivors,
};
use crate::{Blur, Code, Settings};
use dapple_gpu::{Frame, Gpu, GpuError};

/// Maps of a technique with the passes that fill them.
#[derive(Debug)]
pub(super) enum Technique {
    /// None.
    Lit,
    /// Layers of opacity.
    Layered(Box<LayeredMaps>),
    /// Fourier coefficients or power moments.
    Series(Box<Series>),
    /// Nearest survivors of a random test.
    Survivors(Box<Survivors>),
    /// The nearest depth of anything.
    Nearest(Box<Nearest>),
}

/// What a technique costs.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cost {
    /// Passes over the translucent geometry.
    pub geometry_passes: u64,
    /// Bytes as shading reads them.
    pub map_bytes: u64,
    /// Bytes that the making of the maps needs besides.
    pub other_bytes: u64,
    /// Bytes that the opacity passes write for a fragment.
    pub bytes_per_fragment: u64,
    /// Texels that a receiver asks for.
    pub fetches: u64,
}

impl Technique {
    /// Makes the maps; `depth_tested` is a deliberate fault of layers.
    pub fn new(
        gpu: &Gpu,
        raster: &Raster,
        settings: &Settings,
        depth_tested: bool,
    ) -> Result<Self, OpacityGpuError> {
        let no_form = |what: &str, why| Err(OpacityGpuError::NoForm { what: what.into(), why });
        if depth_tested && !matches!(settings.code, Code::Layered(_)) {
            return no_form("a depth test", "only layers are drawn with that fault");
        }
        let ordered = "a texel's fragments must be taken one after the other, in order";
        Ok(match &settings.code {
            Code::Unshadowed => Self::Lit,
            Code::Layered(layered) => {
                let maps = LayeredMaps::new(gpu, raster, layered, settings, depth_tested)?;
                Self::Layered(Box::new(maps))
            }
            Code::Fourier(fourier) => {
                let kind = SeriesKind::Fourier(*fourier);
                Self::Series(Box::new(Series::new(gpu, raster, kind, settings.opaque)?))
            }
            Code::Moments(moments) => {
                let kind = SeriesKind::Moments(*moments);
                Self::Series(Box::new(Series::new(gpu, raster, kind, settings.opaque)?))
            }
            Code::Stochastic(stochastic) => {
                Self::Survivors(Box::new(Survivors::new(gpu, raster, *stochastic)?))
            }
            Code::Binary => Self::Nearest(Box::new(Nearest::new(gpu, raster)?)),
            Code::Adaptive(_) => return no_form("an adaptive volumetric shadow map", ordered),
            Code::Deep(_) => return no_form("a compressed deep shadow map", ordered),
        })
    }

    /// Records the passes that fill the maps.
    pub fn record(&self, frame: &mut Frame<'_>, raster: &Raster) {
        match self {
            Self::Lit => {}
            Self::Layered(maps) => maps.record(frame, raster),
            Self::Series(series) => series.record(frame, raster),
            Self::Survivors(survivors) => survivors.record(frame, raster),
            Self::Nearest(nearest) => nearest.record(frame, raster),
        }
    }

    /// Hands what shading needs to `make`.
    pub fn with_decoder<R>(&self, make: impl FnOnce(&Decoder<'_>) -> R) -> R {
        match self {
            Self::Lit => {
                let path = "opacity-maps/shade_lit.wgsl";
                make(&Decoder { path, constants: &[], resources: &[] })
            }
            Self::Layered(maps) => maps.with_decoder(make),
            Self::Series(series) => series.with_decoder(make),
            Self::Survivors(survivors) => survivors.with_decoder(make),
            Self::Nearest(nearest) => nearest.with_decoder(make),
        }
    }

    /// What it costs with `taps` taps a receiver.
    pub fn cost(&self, taps: u64, blur: Blur) -> Cost {
        match self {
            Self::Lit => Cost::default(),
            Self::Layered(maps) => maps.cost(taps, blur),
            Self::Series(series) => series.cost(taps, blur),
            Self::Survivors(survivors) => survivors.cost(taps),
            Self::Nearest(nearest) => nearest.cost(taps),
        }
    }

    /// The bounds of each texel, where the technique keeps any.
    pub fn bounds(&self) -> Option<&Bounds> {
        match self {
            Self::Layered(maps) => maps.bounds(),
            Self::Series(series) => series.bounds(),
            Self::Lit | Self::Survivors(_) | Self::Nearest(_) => None,
        }
    }

    /// Stored numbers, one map after the other.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<Vec<f32>>, GpuError> {
        match self {
            Self::Lit => Ok(Vec::new()),
            Self::Layered(maps) => maps.read(gpu),
            Self::Series(series) => series.read(gpu),
            Self::Survivors(survivors) => survivors.read(gpu),
            Self::Nearest(nearest) => nearest.read(gpu),
        }
    }
}
