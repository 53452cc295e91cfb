//! OSM, DOM and BOM: layers of opacity, by the blending unit into textures or by atomics into bins.
//!
//! Blending writes cumulative sums: a fragment of layer k is added to every map from k on. Atomics
//! add in fixed point whatever the format (of [`Format::F32`] and [`Format::Fixed`]), to one bin a
//! fragment and in one pass whatever the packing.

use super::{
    OpacityGpuError,
    bins::Bins,
    bounds::{self, Bounds, Ends},
    fragments,
    layers::{Inputs, PATH, Placed, place},
    raster::Raster,
    shade::Decoder,
    targets::{self, MOST_TARGETS, Target, TargetMaps, blend_state},
    technique::Cost,
};
use crate::{
    Blend, Blur, Format, Layered, Layout, Lookup, Opaque, Packing, Settings, Slicing, Storage,
};
use dapple_gpu::bindings::{Slot, bind, layout, whole};
use dapple_gpu::{Frame, Gpu, GpuError, wgpu};
use std::sync::Arc;

/// What layers are kept in.
#[derive(Debug)]
pub(super) enum Maps {
    Blended(Box<TargetMaps>),
    Bins(Box<Bins>),
}

/// OSM, DOM and BOM on the device.
#[derive(Debug)]
pub(super) struct LayeredMaps {
    layered: Layered,
    bounds: Option<Arc<Bounds>>,
    ends: Option<Ends>,
    /// What is bound where there are no bounds.
    no_bounds: wgpu::TextureView,
    maps: Maps,
    placed: Placed,
    params: wgpu::Buffer,
    table: wgpu::Buffer,
    texels: u64,
}

impl LayeredMaps {
    /// Allocates bounds and maps. `depth_tested` lets fragments behind one drawn before be
    /// dropped: a deliberate fault.
    pub fn new(
        gpu: &Gpu,
        raster: &Raster,
        layered: &Layered,
        settings: &Settings,
        depth_tested: bool,
    ) -> Result<Self, OpacityGpuError> {
        let stretches = matches!(settings.opaque, Opaque::Weight { in_bounds: true, .. });
        let bounds = ends(layered)
            .map(|ends| Bounds::new(gpu, raster, ends, stretches))
            .transpose()?
            .map(Arc::new);
        let placed =
            place(layered, settings.opaque, [raster.width, raster.height], scale(layered), || {
                // Quantiles take every fragment, even and growing planes the outermost alone.
                match layered.layout {
                    Layout::Planes(Slicing::Density) => fragments::of(gpu, raster),
                    _ => fragments::extremes(gpu, raster),
                }
            })?;
        Self::placed(gpu, raster, layered, bounds, placed, depth_tested)
    }

    /// Allocates maps between bounds at hand.
    pub(super) fn placed(
        gpu: &Gpu,
        raster: &Raster,
        layered: &Layered,
        bounds: Option<Arc<Bounds>>,
        placed: Placed,
        depth_tested: bool,
    ) -> Result<Self, OpacityGpuError> {
        let ends = ends(layered);
        let no_bounds = bounds::none(gpu)?;
        let table = gpu.upload("layer table", &placed.table)?;
        let params = gpu.uniform("layers", &placed.params)?;
        let view = bounds.as_ref().map_or(&no_bounds, |bounds| bounds.view());
        let inputs = Inputs { placed: &placed, bounds: view, table: &table };
        let maps = match layered.storage {
            Storage::Blend => {
                Maps::Blended(Box::new(blended(gpu, raster, layered, &inputs, depth_tested)?))
            }
            Storage::Atomic if depth_tested => {
                return Err(no_form("a depth test", "bins have no targets to test for"));
            }
            Storage::Atomic => {
                check_bins(layered)?;
                Maps::Bins(Box::new(Bins::new(gpu, raster, layered.layers, &inputs)?))
            }
        };
        let texels = u64::from(raster.width) * u64::from(raster.height);
        let layered = layered.clone();
        Ok(Self { layered, bounds, ends, no_bounds, maps, placed, params, table, texels })
    }

    /// Records the passes of the bounds and of the maps.
    pub fn record(&self, frame: &mut Frame<'_>, raster: &Raster) {
        if let Some(bounds) = &self.bounds {
            bounds.record(frame, raster);
        }
        self.record_maps(frame, raster, "opacity");
    }

    /// Records the passes of the maps alone, those over the geometry as `name`.
    pub fn record_maps(&self, frame: &mut Frame<'_>, raster: &Raster, name: &'static str) {
        match &self.maps {
            Maps::Blended(maps) => maps.record(frame, raster, name),
            Maps::Bins(bins) => bins.record(frame, raster, name),
        }
    }

    /// Hands what shading needs to `make`.
    pub fn with_decoder<R>(&self, make: impl FnOnce(&Decoder<'_>) -> R) -> R {
        let lookup = match self.layered.lookup {
            Lookup::Lerp => 0.0,
            Lookup::Nearest => 1.0,
            Lookup::Exclusive => 2.0,
        };
        let flag = |on: bool| f64::from(u8::from(on));
        let mut constants = self.placed.constants.to_vec();
        constants.extend([
            ("LOOKUP", lookup),
            ("OPACITIES", flag(self.layered.blend != Blend::Add)),
            ("SOFT_START", flag(self.layered.soft_start)),
        ]);
        let bounds = self.bounds.as_ref().map_or(&self.no_bounds, |bounds| bounds.view());
        let resource = wgpu::BindingResource::TextureView;
        let (path, maps) = match &self.maps {
            Maps::Blended(maps) => {
                constants.push(("SINGLE", flag(self.layered.packing == Packing::Single)));
                constants.push(("SLABS", flag(is_slabs(&self.layered))));
                ("opacity-maps/shade_targets.wgsl", resource(maps.view()))
            }
            Maps::Bins(bins) => ("opacity-maps/shade_bins.wgsl", whole(bins.sums())),
        };
        let resources = [whole(&self.params), resource(bounds), whole(&self.table), maps];
        make(&Decoder { path, constants: &constants, resources: &resources })
    }

    /// What it costs; of receivers, one between the bounds and not in the first layer, of
    /// fragments, one of the first layer.
    pub fn cost(&self, taps: u64, blur: Blur) -> Cost {
        let bounds = self.bounds.as_ref().map_or(0, |bounds| bounds.bytes());
        let (passes, bytes, bytes_per_fragment) = match &self.maps {
            Maps::Blended(maps) if is_slabs(&self.layered) => {
                (maps.passes(), maps.bytes(), maps.texel_bytes())
            }
            Maps::Blended(maps) => {
                let all = u64::from(maps.textures()) * maps.texel_bytes();
                (maps.passes(), maps.bytes(), all)
            }
            Maps::Bins(bins) => (1, bins.bytes(), 4),
        };
        let map_bytes = self.texels * crate::layered::bytes_per_texel(&self.layered);
        Cost {
            geometry_passes: passes + self.ends.map_or(0, bounds::geometry_passes),
            map_bytes,
            other_bytes: (bytes + bounds).saturating_sub(map_bytes),
            bytes_per_fragment,
            fetches: self.fetches(taps, blur),
        }
    }

    fn fetches(&self, taps: u64, blur: Blur) -> u64 {
        let layers = match self.layered.lookup {
            Lookup::Lerp => 2,
            Lookup::Nearest | Lookup::Exclusive => 1,
        };
        let bounds = u64::from(self.bounds.is_some());
        match blur {
            Blur::Transmittance => taps * (bounds + layers),
            Blur::Stored => {
                let soft = if self.layered.soft_start { taps } else { 0 };
                bounds + soft + taps * layers
            }
        }
    }

    /// The bounds, where the layout has any.
    pub fn bounds(&self) -> Option<&Bounds> {
        self.bounds.as_deref()
    }

    /// The same to share.
    pub(super) fn shared_bounds(&self) -> Option<Arc<Bounds>> {
        self.bounds.clone()
    }

    /// Passes over the geometry that fill the maps.
    pub(super) fn map_passes(&self) -> u64 {
        match &self.maps {
            Maps::Blended(maps) => maps.passes(),
            Maps::Bins(_) => 1,
        }
    }

    /// What layers are kept in.
    pub(super) fn maps(&self) -> &Maps {
        &self.maps
    }

    /// The table of layers.
    pub(super) fn table(&self) -> &wgpu::Buffer {
        &self.table
    }

    /// Stored numbers of every layer, one map after the other: as they are in the textures, fixed
    /// point as thickness.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<Vec<f32>>, GpuError> {
        let layers = self.layered.layers as usize;
        let maps = match &self.maps {
            Maps::Bins(bins) => return bins.read(gpu, layers),
            Maps::Blended(maps) => maps,
        };
        let mut out = maps.read_channels(gpu, per_texture(&self.layered) as usize)?;
        out.truncate(layers);
        Ok(out)
    }
}

/// The ends that layers lie between.
fn ends(layered: &Layered) -> Option<Ends> {
    match layered.layout {
        Layout::Planes(_) => None,
        Layout::Deep { .. } => Some(Ends::First),
        Layout::Bounded { .. } => Some(Ends::Both(layered.end_map)),
    }
}

pub(super) fn no_form(what: impl Into<String>, why: &'static str) -> OpacityGpuError {
    OpacityGpuError::NoForm { what: what.into(), why }
}

/// Stored numbers per thickness.
pub(super) fn scale(layered: &Layered) -> f32 {
    match layered.format {
        Format::Unorm8Scaled => (1.0 / crate::layered::unit::SCALE) as f32,
        _ => 1.0,
    }
}

/// Layers of a texture of four channels.
fn per_texture(layered: &Layered) -> u32 {
    if layered.packing == Packing::Single { 1 } else { 4 }
}

fn is_listing(layered: &Layered) -> bool {
    matches!(layered.layout, Layout::Deep { listing: true, .. })
}

/// Whether a texture holds its own layers alone. The listing's masks are for all later ones.
fn is_slabs(layered: &Layered) -> bool {
    layered.packing == Packing::Slabs && !is_listing(layered)
}

fn state(blend: Blend) -> wgpu::BlendState {
    use wgpu::BlendFactor::{One, OneMinusSrc, OneMinusSrcAlpha, SrcAlpha};
    let (color, alpha) = match blend {
        Blend::Add => ((One, One), (One, One)),
        Blend::Over => ((One, OneMinusSrc), (One, OneMinusSrcAlpha)),
        Blend::Alpha => ((SrcAlpha, OneMinusSrcAlpha), (One, OneMinusSrcAlpha)),
        Blend::Premultiplied => ((One, OneMinusSrcAlpha), (One, OneMinusSrcAlpha)),
    };
    blend_state(color, alpha, wgpu::BlendOperation::Add)
}

fn blended(
    gpu: &Gpu,
    raster: &Raster,
    layered: &Layered,
    inputs: &Inputs<'_>,
    depth_tested: bool,
) -> Result<TargetMaps, OpacityGpuError> {
    let Some(texel) = targets::texel(layered.format) else {
        return Err(no_form("blending in fixed point", "the blending unit adds no integers"));
    };
    let per_texture = per_texture(layered);
    let textures = layered.layers.div_ceil(per_texture);
    let per_pass = match layered.packing {
        Packing::Single | Packing::Slabs => 1,
        Packing::Targets(targets) => targets.clamp(1, MOST_TARGETS).min(textures),
        Packing::Sorted => {
            return Err(no_form(
                "sorting fragments into slabs with blending",
                "triangles are not sorted; bins of atomics touch each fragment once",
            ));
        }
    };
    let flag = |on: bool| f64::from(u8::from(on));
    let mode = match layered.blend {
        Blend::Add => 0.0,
        Blend::Over => 1.0,
        Blend::Alpha | Blend::Premultiplied => 2.0,
    };
    let mut constants = inputs.placed.constants.to_vec();
    constants.extend([
        ("SLABS", flag(is_slabs(layered))),
        ("LISTING", flag(is_listing(layered))),
        ("BLEND", mode),
    ]);
    let slots = layout(gpu, "layers", &[Slot::Uniform, Slot::Floats, Slot::Read]);
    let target = Target {
        path: PATH,
        entry: if depth_tested { "tested_targets" } else { "targets" },
        constants: &constants,
        slots: &slots,
        textures,
        per_pass,
        texel,
        blend: state(layered.blend),
        clear: 0.0,
        depth_tested,
    };
    TargetMaps::new(gpu, raster, &target, |drawn| {
        let params =
            inputs.placed.params.of_pass(drawn.start * per_texture, drawn.end * per_texture);
        let params = gpu.uniform("layers of a pass", &params)?;
        let bounds = wgpu::BindingResource::TextureView(inputs.bounds);
        Ok(bind(gpu, &slots, &[whole(&params), bounds, whole(inputs.table)]))
    })
}

fn check_bins(layered: &Layered) -> Result<(), OpacityGpuError> {
    if layered.blend != Blend::Add {
        return Err(no_form("atomic blending other than by addition", "atomics add"));
    }
    if !matches!(layered.format, Format::Fixed | Format::F32) {
        let what = format!("atomic addition in {:?}", layered.format);
        return Err(no_form(what, "atomics add integers"));
    }
    if is_listing(layered) {
        return Err(no_form("the listing's masks in bins", "a bin is summed into all later maps"));
    }
    Ok(())
}
