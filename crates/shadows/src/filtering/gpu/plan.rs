//! What the shaders are told: constants of the pipelines, and the uniforms that mirror theirs.

use bytemuck::{Pod, Zeroable};

use super::super::channels::{Channels, Reduction};
use super::super::estimators::moments;
use super::super::kernel::Kernel;
use super::super::{
    EsmSpace, Estimator, EvsmComponents, Format, KernelShape, Lookup, Settings, VsmVariant,
};

/// Texels a workgroup of `filter_x.wgsl` makes, and its strip.
pub(super) const ROW_RUN: u32 = 512;
pub(super) const ROW_STRIP: u32 = 8;
/// Strip and workgroup of `filter_y.wgsl`.
pub(super) const COLUMN_STRIP: u32 = 16;
pub(super) const COLUMN_LANES: u32 = 64;
pub(super) const COLUMN_STRIPS: u32 = 4;
/// Words of `results` in `filter_x.wgsl`.
const ROW_RESULTS: u32 = 576;

/// Mirrors `PackParams` of `shadows/pack.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct PackParams {
    pub texels: u32,
    pub channels: u32,
    pub layers: u32,
    pub exponent: f32,
}

/// Mirrors `FilterParams` of `common/window.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct FilterParams {
    pub width: u32,
    pub height: u32,
    pub taps: u32,
    pub scale: f32,
    pub norm: f32,
    pub exponent: f32,
    pub pad0: u32,
    pub pad1: u32,
}

/// Mirrors `ShadeParams` of `shadows/shade.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct ShadeParams {
    pub width: u32,
    pub height: u32,
    pub receivers: u32,
    pub layers: u32,
    pub taps: u32,
    pub contiguous: u32,
    pub bias: f32,
    pub min_variance: f32,
    pub bleed_reduction: f32,
    pub exponent: f32,
    pub moment_bias: f32,
    pub moment_target: f32,
    pub degenerate_range: f32,
    pub pad0: f32,
    pub pad1: f32,
    pub pad2: f32,
}

/// `FORMAT_*` of `common/channels.wgsl`.
pub(super) fn format_code(format: Format) -> u32 {
    match format {
        Format::F32 => 0,
        Format::F16 => 1,
        Format::U16 => 2,
    }
}

/// `PACK_*` of `shadows/pack.wgsl`.
pub(super) fn pack_code(estimator: Estimator) -> u32 {
    match estimator {
        Estimator::PowerCdf | Estimator::LayeredPower { .. } => 1,
        Estimator::Esm { space: EsmSpace::Linear } => 2,
        Estimator::Hard | Estimator::Pcf { .. } | Estimator::Esm { space: EsmSpace::Log } => 3,
        Estimator::Evsm { .. } => 4,
        Estimator::Msm => 5,
        _ => 0,
    }
}

/// Estimators of `shadows/shade.wgsl`.
pub(super) fn shade_code(estimator: Estimator) -> u32 {
    match estimator {
        Estimator::Hard | Estimator::Pcf { .. } => 0,
        Estimator::Vsm { variant: VsmVariant::Plain | VsmVariant::MinVariance }
        | Estimator::LayeredVsm { .. } => 1,
        Estimator::Vsm { variant: VsmVariant::Linstep } => 2,
        Estimator::Vsm { variant: VsmVariant::Max } => 3,
        Estimator::GaussianCdf | Estimator::LayeredGaussian { .. } => 4,
        Estimator::PowerCdf | Estimator::LayeredPower { .. } => 5,
        Estimator::Esm { space: EsmSpace::Linear } => 6,
        Estimator::Esm { space: EsmSpace::Log } => 7,
        Estimator::Evsm { components: EvsmComponents::Two } => 8,
        Estimator::Evsm { components: EvsmComponents::Four } => 9,
        Estimator::Msm => 10,
    }
}

/// How the channels lie in words: planes of one 32-bit channel, or of two 16-bit ones; each layer
/// begins a new plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Planes {
    pub per_layer: u32,
    pub channels_per_layer: u32,
    pub layers: u32,
    pub wide: bool,
}

impl Planes {
    pub fn new(settings: &Settings, channels: &Channels) -> Self {
        let channels_per_layer = channels.per_layer() as u32;
        let wide = settings.format == Format::F32;
        Self {
            per_layer: if wide { channels_per_layer } else { channels_per_layer.div_ceil(2) },
            channels_per_layer,
            layers: channels.layers().as_slice().len() as u32,
            wide,
        }
    }

    pub fn count(self) -> u32 {
        self.per_layer * self.layers
    }

    /// Plane and half (0 low, 1 high) of a channel.
    pub fn place(self, channel: u32) -> (u32, u32) {
        let (layer, within) =
            (channel / self.channels_per_layer, channel % self.channels_per_layer);
        let base = layer * self.per_layer;
        if self.wide { (base + within, 0) } else { (base + within / 2, within % 2) }
    }
}

/// `OP_*` of `common/window.wgsl` for each plane, 4 bits a channel.
pub(super) fn plane_ops(settings: &Settings, channels: &Channels, planes: Planes) -> Vec<u32> {
    // Exponentially warped channels span e^170: no texel is a good pivot for its neighbours.
    let warped = matches!(
        settings.estimator,
        Estimator::Esm { space: EsmSpace::Linear } | Estimator::Evsm { .. }
    );
    let mut ops = vec![0; planes.count() as usize];
    for channel in 0..planes.channels_per_layer * planes.layers {
        let op = match channels.reduction(channel as usize) {
            Reduction::Mean if warped => 1,
            Reduction::Mean => 0,
            Reduction::Min => 2,
            Reduction::Max => 3,
            Reduction::LogMean => 4,
        };
        let (plane, half) = planes.place(channel);
        ops[plane as usize] |= op << (4 * half);
    }
    ops
}

/// Weights of the filter passes: 1 for boxes, whose sum is divided instead.
pub(super) fn filter_weights(kernel: &Kernel) -> Vec<f32> {
    match kernel.shape() {
        KernelShape::Box => vec![1.0; kernel.support()],
        KernelShape::Gaussian => kernel.weights().iter().map(|&w| w as f32).collect(),
    }
}

pub(super) fn filter_params(
    settings: &Settings,
    kernel: &Kernel,
    width: u32,
    height: u32,
) -> FilterParams {
    let (scale, norm) = match kernel.shape() {
        KernelShape::Gaussian => (1.0, 1.0),
        KernelShape::Box => {
            let taps = kernel.support() as f64;
            let largest = match settings.estimator {
                Estimator::Esm { space: EsmSpace::Linear } => f64::from(settings.exponent),
                Estimator::Evsm { .. } => 2.0 * f64::from(settings.exponent),
                _ => 0.0,
            };
            // A window's sum stays below 2^127; no scaling where it does anyway, as it would
            // push the smallest warped depths below the normal range.
            let bits = (taps.log2() + largest * std::f64::consts::LOG2_E - 127.0).ceil().max(0.0);
            ((-bits).exp2() as f32, taps as f32)
        }
    };
    FilterParams {
        width,
        height,
        taps: kernel.support() as u32,
        scale,
        norm,
        exponent: settings.exponent,
        pad0: 0,
        pad1: 0,
    }
}

pub(super) fn shade_params(
    settings: &Settings,
    width: u32,
    height: u32,
    receivers: u32,
    layers: u32,
    taps: &[[f32; 2]],
) -> ShadeParams {
    let contiguous = taps.windows(2).all(|pair| pair[1][0] - pair[0][0] == 1.0);
    let plain = settings.estimator == Estimator::Vsm { variant: VsmVariant::Plain };
    ShadeParams {
        width,
        height,
        receivers,
        layers,
        taps: taps.len() as u32,
        contiguous: u32::from(contiguous),
        bias: settings.bias,
        min_variance: if plain { 0.0 } else { settings.min_variance },
        bleed_reduction: settings.bleed_reduction,
        exponent: settings.exponent,
        moment_bias: settings.moment_bias,
        moment_target: moments::bias_target(settings.format != Format::F32) as f32,
        degenerate_range: settings.format.degenerate_range(),
        pad0: 0.0,
        pad1: 0.0,
        pad2: 0.0,
    }
}

/// Pipeline constants of the filter passes. `workgroup_bytes` is the device's limit.
pub(super) fn row_constants(
    settings: &Settings,
    kernel: &Kernel,
    workgroup_bytes: u32,
) -> Vec<(&'static str, f64)> {
    let texels = ROW_RUN + kernel.support() as u32 - 1;
    // Rounded up, so that nearby widths share a pipeline.
    let words = (texels + texels / ROW_STRIP).next_multiple_of(216);
    let tiled = 4 * (words + ROW_RESULTS) <= workgroup_bytes.min(16_384);
    let mut constants = column_constants(settings, kernel);
    constants.push(("TILE_WORDS", f64::from(if tiled { words } else { 1 })));
    constants.push(("TILED", f64::from(u8::from(tiled))));
    constants
}

pub(super) fn column_constants(settings: &Settings, kernel: &Kernel) -> Vec<(&'static str, f64)> {
    let gaussian = kernel.shape() == KernelShape::Gaussian;
    vec![
        ("FORMAT", f64::from(format_code(settings.format))),
        ("GAUSSIAN", f64::from(u8::from(gaussian))),
    ]
}

pub(super) fn pack_constants(settings: &Settings) -> Vec<(&'static str, f64)> {
    vec![
        ("FORMAT", f64::from(format_code(settings.format))),
        ("PACK", f64::from(pack_code(settings.estimator))),
        ("LAYERED", f64::from(u8::from(settings.splits().is_some()))),
    ]
}

pub(super) fn shade_constants(settings: &Settings, planes: Planes) -> Vec<(&'static str, f64)> {
    vec![
        ("FORMAT", f64::from(format_code(settings.format))),
        ("ESTIMATOR", f64::from(shade_code(settings.estimator))),
        ("CHANNELS", f64::from(planes.channels_per_layer)),
        ("LAYERED", f64::from(u8::from(settings.splits().is_some()))),
        ("BILINEAR", f64::from(u8::from(settings.lookup == Lookup::Bilinear))),
        ("PLANE_BIAS", f64::from(u8::from(settings.plane_bias))),
    ]
}

#[cfg(test)]
mod tests {
    use super::super::super::{DepthMap, Splits};
    use super::*;

    fn planes(s: &Settings) -> (Planes, Vec<u32>) {
        let map = DepthMap { width: 1, height: 1, depths: vec![1.0] };
        let channels = Channels::new(s, &map);
        let planes = Planes::new(s, &channels);
        (planes, plane_ops(s, &channels, planes))
    }

    /// Checks size and every offset of a struct against its WGSL twin.
    macro_rules! same_layout {
        ($path:literal, $name:ident: $($field:ident),*) => {
            let source = dapple_shaders::source($path).unwrap();
            let layout = dapple_shaders::struct_layout(&source, stringify!($name)).unwrap();
            let fields =
                [$((stringify!($field).to_string(), std::mem::offset_of!($name, $field) as u32)),*];
            assert_eq!(layout.fields, fields);
            assert_eq!(layout.size as usize, size_of::<$name>());
        };
    }

    #[test]
    fn uniforms_have_the_layout_of_the_shaders() {
        use super::super::super::Receiver;
        same_layout!("shadows/pack.wgsl", PackParams: texels, channels, layers, exponent);
        same_layout!("shadows/filter_x.wgsl", FilterParams:
            width, height, taps, scale, norm, exponent, pad0, pad1);
        same_layout!("shadows/shade.wgsl", ShadeParams:
            width, height, receivers, layers, taps, contiguous, bias, min_variance,
            bleed_reduction, exponent, moment_bias, moment_target, degenerate_range,
            pad0, pad1, pad2);
        let source = dapple_shaders::source("shadows/shade.wgsl").unwrap();
        let receiver = dapple_shaders::struct_layout(&source, "Receiver").unwrap();
        assert_eq!(receiver.size as usize, size_of::<Receiver>());
        let names = ["u", "v", "z", "valid", "dz_du", "dz_dv", "pad0", "pad1"];
        for (i, (field, name)) in receiver.fields.iter().zip(names).enumerate() {
            assert_eq!((field.0.as_str(), field.1), (name, 4 * i as u32));
        }
        assert_eq!(std::mem::offset_of!(Receiver, dz_du), 16);
    }

    #[test]
    fn channels_lie_where_the_shaders_look() {
        let s = Settings::new(Estimator::PowerCdf);
        assert_eq!(planes(&s).1, [0, 2, 3]);
        let (p, ops) = planes(&s.with_format(Format::F16));
        assert_eq!(ops, [0x20, 0x03]);
        assert_eq!([p.place(0), p.place(1), p.place(2)], [(0, 0), (0, 1), (1, 0)]);
        let mut s = Settings::new(Estimator::LayeredPower { splits: Splits::Uniform });
        s.layers = 2;
        assert_eq!(planes(&s).1, [0, 2, 3, 0, 2, 3]);
        let (p, ops) = planes(&s.with_format(Format::U16));
        assert_eq!(ops, [0x20, 0x03, 0x20, 0x03]);
        assert_eq!(p.place(4), (2, 1));
        let s = Settings::new(Estimator::Evsm { components: EvsmComponents::Four });
        assert_eq!(planes(&s).1, [1, 1, 1, 1]);
        assert_eq!(planes(&s.with_format(Format::F16)).1, [0x11, 0x11]);
    }

    #[test]
    fn sums_of_warped_depths_stay_finite() {
        let mut s = Settings::new(Estimator::Evsm { components: EvsmComponents::Two });
        let params =
            |s: &Settings, width| filter_params(s, &Kernel::new(KernelShape::Box, width), 64, 64);
        assert_eq!(params(&s, 31).scale, 1.0);
        s.exponent = 44.0;
        let p = params(&s, 4095);
        assert!((f64::from(p.scale) * 4095.0 * 88.0f64.exp()) < 2.0f64.powi(127));
        assert_eq!(p.scale, f32::exp2(p.scale.log2().round()));
    }

    #[test]
    fn tiles_hold_every_texel_and_long_windows_do_without() {
        let s = Settings::new(Estimator::GaussianCdf);
        for width in [1, 31, 513, 2047, 4095] {
            let kernel = Kernel::new(KernelShape::Box, width);
            let constants = row_constants(&s, &kernel, 32_768);
            let get = |name| constants.iter().find(|c| c.0 == name).unwrap().1 as u32;
            let last = ROW_RUN + width - 2;
            if get("TILED") == 1 {
                assert!(last + last / ROW_STRIP < get("TILE_WORDS"), "{width}");
                assert!(4 * (get("TILE_WORDS") + ROW_RESULTS) <= 16_384);
            } else {
                assert!(width > 2047, "{width}");
            }
        }
    }
}
