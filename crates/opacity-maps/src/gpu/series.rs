//! Sums over all fragments of a ray: Fourier coefficients, or power moments. All numbers of a texel
//! are added by the blending unit in one pass.

use super::{
    OpacityGpuError,
    bounds::{self, Bounds, Ends},
    raster::Raster,
    shade::Decoder,
    targets::{self, MOST_TARGETS, Target, TargetMaps, blend_state},
    technique::Cost,
};
use crate::{Blur, EndMap, Fourier, Moments, Opaque, moments};
use bytemuck::{Pod, Zeroable};
use dapple_gpu::bindings::{Slot, bind, layout, whole};
use dapple_gpu::{Frame, Gpu, GpuError, wgpu};

/// Mirrors `SeriesParams` of `common/opacity_series.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Default, Pod, Zeroable)]
struct SeriesParams {
    numbers: u32,
    own: f32,
    bias: f32,
    pad: u32,
}

/// What is summed.
#[derive(Clone, Copy, Debug)]
pub(super) enum SeriesKind {
    Fourier(Fourier),
    Moments(Moments),
}

/// The bounds a series is taken between, where it is not the light's whole range.
const BOTH: Ends = Ends::Both(EndMap::MaxBlend);

/// Numbers of each texel with what fills them.
#[derive(Debug)]
pub(super) struct Series {
    numbers: u32,
    bounds: Option<Bounds>,
    no_bounds: wgpu::TextureView,
    maps: TargetMaps,
    params: wgpu::Buffer,
    constants: [(&'static str, f64); 2],
    shade: &'static str,
}

impl Series {
    /// Allocates bounds and maps.
    pub fn new(
        gpu: &Gpu,
        raster: &Raster,
        kind: SeriesKind,
        opaque: Opaque,
    ) -> Result<Self, OpacityGpuError> {
        let mut params = SeriesParams::default();
        let (bounded, format, path, shade) = match kind {
            SeriesKind::Fourier(f) => {
                params.numbers = 1 + 2 * f.pairs;
                let shade = "opacity-maps/shade_fourier.wgsl";
                (f.bounded, f.format, "opacity-maps/fourier.wgsl", shade)
            }
            SeriesKind::Moments(m) => {
                params.numbers = 1 + m.moments;
                params.own = 1.0 - m.overestimation;
                params.bias = moments::bias(&m) as f32;
                let shade = "opacity-maps/shade_moments.wgsl";
                (m.bounded, m.format, "opacity-maps/moments.wgsl", shade)
            }
        };
        let Some(texel) = targets::texel(format) else {
            let what = "a series in fixed point".into();
            return Err(OpacityGpuError::NoForm {
                what,
                why: "the blending unit adds no integers",
            });
        };
        let stretches = matches!(opaque, Opaque::Weight { in_bounds: true, .. });
        let bounds = bounded.then(|| Bounds::new(gpu, raster, BOTH, stretches)).transpose()?;
        let no_bounds = bounds::none(gpu)?;
        let alone = matches!(opaque, Opaque::Weight { in_bounds: false, .. });
        let flag = |on: bool| f64::from(u8::from(on));
        let constants = [("BOUNDED", flag(bounded)), ("OPAQUE_ALONE", flag(alone))];
        let params_buffer = gpu.uniform("series", &params)?;
        let slots = layout(gpu, "series", &[Slot::Uniform, Slot::Floats]);
        let textures = params.numbers.div_ceil(4);
        let one = (wgpu::BlendFactor::One, wgpu::BlendFactor::One);
        let target = Target {
            path,
            entry: "targets",
            constants: &constants,
            slots: &slots,
            textures,
            per_pass: textures.min(MOST_TARGETS),
            texel,
            blend: blend_state(one, one, wgpu::BlendOperation::Add),
            clear: 0.0,
            depth_tested: false,
        };
        let view = bounds.as_ref().map_or(&no_bounds, Bounds::view);
        let maps = TargetMaps::new(gpu, raster, &target, |_| {
            let view = wgpu::BindingResource::TextureView(view);
            Ok(bind(gpu, &slots, &[whole(&params_buffer), view]))
        })?;
        let numbers = params.numbers;
        Ok(Self { numbers, bounds, no_bounds, maps, params: params_buffer, constants, shade })
    }

    /// Records the passes of the bounds and of the maps.
    pub fn record(&self, frame: &mut Frame<'_>, raster: &Raster) {
        if let Some(bounds) = &self.bounds {
            bounds.record(frame, raster);
        }
        self.maps.record(frame, raster, "opacity");
    }

    /// Hands what shading needs to `make`.
    pub fn with_decoder<R>(&self, make: impl FnOnce(&Decoder<'_>) -> R) -> R {
        let bounds = self.bounds.as_ref().map_or(&self.no_bounds, Bounds::view);
        let texture = wgpu::BindingResource::TextureView;
        let resources = [whole(&self.params), texture(bounds), texture(self.maps.view())];
        make(&Decoder { path: self.shade, constants: &self.constants, resources: &resources })
    }

    /// What it costs: textures are of four channels, whether used or not.
    pub fn cost(&self, taps: u64, blur: Blur) -> Cost {
        let bounded = u64::from(self.bounds.is_some());
        let together = blur == Blur::Stored && bounded == 0;
        Cost {
            geometry_passes: self.maps.passes() + bounded * bounds::geometry_passes(BOTH),
            map_bytes: self.maps.bytes() + self.bounds.as_ref().map_or(0, Bounds::bytes),
            other_bytes: 0,
            bytes_per_fragment: u64::from(self.maps.textures()) * self.maps.texel_bytes(),
            fetches: taps * u64::from(self.numbers) + if together { 0 } else { taps * bounded },
        }
    }

    /// The bounds, where there are any.
    pub fn bounds(&self) -> Option<&Bounds> {
        self.bounds.as_ref()
    }

    /// Every number, one map after the other.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<Vec<f32>>, GpuError> {
        let mut maps = self.maps.read_channels(gpu, 4)?;
        maps.truncate(self.numbers as usize);
        Ok(maps)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_has_the_layout_of_the_shaders() {
        for path in ["opacity-maps/fourier.wgsl", "opacity-maps/shade_moments.wgsl"] {
            let fields = [("numbers", 0), ("own", 4), ("bias", 8), ("pad0", 12)];
            crate::gpu::mirror::<SeriesParams>(path, "SeriesParams", &fields);
        }
    }
}
