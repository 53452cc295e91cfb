//! Layers of opacity: by the blending unit into textures, or by atomics into bins.
//!
//! Blending writes cumulative sums (a fragment of layer k is added to every map from k on), a pass
//! into up to eight textures of four layers. Atomics add a fragment to the one bin it belongs to,
//! in fixed point whatever the format, and a second pass sums the bins from the light on: the same bits in any order,
//! and one pass over the geometry for any number of layers.

use super::{
    OpacityGpuError,
    bounds::{self, Bounds, Ends, need_blendable},
    layers::{Placed, place},
    raster::{Pipelines, Raster, Slot, Stage, bind, depth_state, layout, whole},
    shade::Decoder,
};
use crate::{Blend, Blur, Format, Layered, Layout, Lookup, Opaque, Packing, Settings, Storage};
use bytemuck::{Pod, Zeroable};
use dapple_gpu::{Frame, Gpu, GpuError, Targets, wgpu};

const PATH: &str = "opacity-maps/layers.wgsl";

/// Most textures of a pass.
const MOST_TARGETS: u32 = 8;

/// Mirrors `PrefixParams` of `opacity-maps/prefix.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct PrefixParams {
    texels: u32,
    layers: u32,
    pad: [u32; 2],
}

/// How layers lie in textures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Plan {
    /// Layers of a texture of four channels: 1 or 4.
    per_texture: u32,
    /// Textures of the array.
    textures: u32,
    /// Textures of a pass.
    per_pass: u32,
    format: wgpu::TextureFormat,
    /// Bytes of a texel of a texture.
    bytes: u32,
    /// Whether a texture holds its own layers alone.
    slabs: bool,
}

impl Plan {
    fn passes(self) -> u32 {
        self.textures.div_ceil(self.per_pass)
    }
}

#[derive(Debug)]
struct Pass {
    views: Vec<wgpu::TextureView>,
    group: wgpu::BindGroup,
    pipelines: usize,
}

#[derive(Debug)]
enum Maps {
    Blended {
        plan: Plan,
        texture: wgpu::Texture,
        view: wgpu::TextureView,
        passes: Vec<Pass>,
        /// Of passes with as many textures as fit, and of the last.
        pipelines: Vec<Pipelines>,
        /// A depth test that must not be there.
        tested: Option<wgpu::TextureView>,
    },
    Bins {
        sums: wgpu::Buffer,
        overrun: wgpu::Buffer,
        pipelines: Pipelines,
        group: wgpu::BindGroup,
        prefix: wgpu::ComputePipeline,
        prefix_group: wgpu::BindGroup,
        workgroups: [u32; 3],
    },
}

/// OSM, DOM and BOM on the device.
#[derive(Debug)]
pub(super) struct LayeredMaps {
    layered: Layered,
    bounds: Option<Bounds>,
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
        let ends = match layered.layout {
            Layout::Planes(_) => None,
            Layout::Deep { .. } => Some(Ends::First),
            Layout::Bounded { .. } => Some(Ends::Both(layered.end_map)),
        };
        let stretches = matches!(settings.opaque, Opaque::Weight { in_bounds: true, .. });
        let bounds = ends.map(|ends| Bounds::new(gpu, raster, ends, stretches)).transpose()?;
        let usage = wgpu::TextureUsages::TEXTURE_BINDING;
        let empty = gpu.texture("no bounds", 1, 1, wgpu::TextureFormat::R32Float, usage)?;
        let no_bounds = empty.create_view(&wgpu::TextureViewDescriptor::default());
        let placed = place(layered, settings.opaque, raster.width, scale(layered), || {
            super::fragments::of(gpu, raster)
        })?;
        let table = gpu.upload("layer table", &placed.table)?;
        let params = gpu.uniform("layers", &placed.params)?;
        let view = bounds.as_ref().map_or(&no_bounds, Bounds::view);
        let inputs = Inputs { layered, placed: &placed, bounds: view, table: &table };
        let maps = match layered.storage {
            Storage::Blend => blended(gpu, raster, &inputs, depth_tested)?,
            Storage::Atomic if depth_tested => {
                return Err(no_form("a depth test", "bins have no targets to test for"));
            }
            Storage::Atomic => bins(gpu, raster, &inputs)?,
        };
        let texels = u64::from(raster.width) * u64::from(raster.height);
        let layered = layered.clone();
        Ok(Self { layered, bounds, ends, no_bounds, maps, placed, params, table, texels })
    }

    /// Records the passes of the bounds, "opacity", and for bins "opacity-clear" and "prefix".
    pub fn record(&self, frame: &mut Frame<'_>, raster: &Raster) {
        if let Some(bounds) = &self.bounds {
            bounds.record(frame, raster);
        }
        match &self.maps {
            Maps::Blended { passes, pipelines, tested, .. } => {
                for pass in passes {
                    let mut colour = [const { None }; MOST_TARGETS as usize];
                    for (slot, view) in colour.iter_mut().zip(&pass.views) {
                        *slot = Targets::cleared(view, wgpu::Color::TRANSPARENT);
                    }
                    let targets = Targets {
                        colour: &colour[..pass.views.len()],
                        depth: tested.as_ref().and_then(|view| Targets::cleared_depth(view, 1.0)),
                        ..Targets::default()
                    };
                    frame.raster("opacity", targets, |render| {
                        raster.draw(render, &pipelines[pass.pipelines], &pass.group);
                    });
                }
            }
            Maps::Bins {
                sums,
                overrun,
                pipelines,
                group,
                prefix,
                prefix_group,
                workgroups: [x, y, z],
            } => {
                frame.copies("opacity-clear", |encoder| {
                    encoder.clear_buffer(sums, 0, None);
                    encoder.clear_buffer(overrun, 0, None);
                });
                let targets = raster.no_targets();
                frame.raster("opacity", targets, |pass| raster.draw(pass, pipelines, group));
                frame.compute("prefix", |pass| {
                    pass.set_pipeline(prefix);
                    pass.set_bind_group(0, prefix_group, &[]);
                    pass.dispatch_workgroups(*x, *y, *z);
                });
            }
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
        let bounds = self.bounds.as_ref().map_or(&self.no_bounds, Bounds::view);
        let common =
            [whole(&self.params), wgpu::BindingResource::TextureView(bounds), whole(&self.table)];
        let [params, bounds, table] = common;
        let (path, maps) = match &self.maps {
            Maps::Blended { view, plan, .. } => {
                constants.push(("SINGLE", flag(plan.per_texture == 1)));
                constants.push(("SLABS", flag(plan.slabs)));
                ("opacity-maps/shade_targets.wgsl", wgpu::BindingResource::TextureView(view))
            }
            Maps::Bins { sums, .. } => ("opacity-maps/shade_bins.wgsl", whole(sums)),
        };
        let resources = [params, bounds, table, maps];
        make(&Decoder { path, constants: &constants, resources: &resources })
    }

    /// Passes over the geometry.
    pub fn geometry_passes(&self) -> u64 {
        let opacity = match &self.maps {
            Maps::Blended { plan, .. } => plan.passes().into(),
            Maps::Bins { .. } => 1,
        };
        opacity + self.ends.map_or(0, bounds::geometry_passes)
    }

    /// Bytes of bounds and maps, with what their making needs besides.
    pub fn memory_bytes(&self) -> u64 {
        let maps = match &self.maps {
            Maps::Blended { plan, .. } => {
                self.texels * u64::from(plan.textures) * u64::from(plan.bytes)
            }
            Maps::Bins { sums, overrun, .. } => sums.size() + overrun.size(),
        };
        maps + self.bounds.as_ref().map_or(0, Bounds::bytes)
    }

    /// Bytes of bounds and maps as shading reads them.
    pub fn map_bytes(&self) -> u64 {
        self.texels * crate::layered::bytes_per_texel(&self.layered)
    }

    /// Bytes that the opacity passes write for a fragment of the first layer.
    pub fn bytes_per_fragment(&self) -> u64 {
        match &self.maps {
            Maps::Blended { plan, .. } if plan.slabs => plan.bytes.into(),
            Maps::Blended { plan, .. } => u64::from(plan.textures) * u64::from(plan.bytes),
            Maps::Bins { .. } => 4,
        }
    }

    /// Texels that a receiver between the bounds, and not in the first layer, asks for: of bounds
    /// and of layers, over `taps` taps.
    pub fn fetches(&self, taps: u64, blur: Blur) -> u64 {
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
        self.bounds.as_ref()
    }

    /// Stored numbers of every layer, one map after the other: as they are in the textures, fixed
    /// point as thickness.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<Vec<f32>>, GpuError> {
        let texels = self.texels as usize;
        match &self.maps {
            Maps::Bins { sums, .. } => {
                let words: Vec<u32> = gpu.read(sums, 0, texels * self.layered.layers as usize)?;
                let map = |map: &[u32]| map.iter().map(|&w| w as f32 / 1_048_576.0).collect();
                Ok(words.chunks_exact(texels).map(map).collect())
            }
            Maps::Blended { texture, plan, .. } => {
                let mut maps = Vec::new();
                for index in 0..plan.textures {
                    let bytes = gpu.read_texture_layer(texture, index)?;
                    let values = floats(&bytes, plan.format);
                    for channel in 0..plan.per_texture as usize {
                        maps.push(values.iter().copied().skip(channel).step_by(4).collect());
                    }
                }
                maps.truncate(self.layered.layers as usize);
                Ok(maps)
            }
        }
    }
}

struct Inputs<'a> {
    layered: &'a Layered,
    placed: &'a Placed,
    bounds: &'a wgpu::TextureView,
    table: &'a wgpu::Buffer,
}

fn no_form(what: impl Into<String>, why: &'static str) -> OpacityGpuError {
    OpacityGpuError::NoForm { what: what.into(), why }
}

/// Stored numbers per thickness.
fn scale(layered: &Layered) -> f32 {
    match layered.format {
        Format::Unorm8Scaled => (1.0 / crate::layered::unit::SCALE) as f32,
        _ => 1.0,
    }
}

fn plan(layered: &Layered) -> Result<Plan, OpacityGpuError> {
    use wgpu::TextureFormat as T;
    let (format, bytes) = match layered.format {
        Format::F32 => (T::Rgba32Float, 16),
        Format::F16 => (T::Rgba16Float, 8),
        Format::Unorm8 | Format::Unorm8Scaled => (T::Rgba8Unorm, 4),
        Format::Fixed => {
            return Err(no_form("blending in fixed point", "the blending unit adds no integers"));
        }
    };
    let per_texture = if layered.packing == Packing::Single { 1 } else { 4 };
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
    let slabs = layered.packing == Packing::Slabs;
    Ok(Plan { per_texture, textures, per_pass, format, bytes, slabs })
}

fn check_limits(gpu: &Gpu, plan: Plan) -> Result<(), OpacityGpuError> {
    let limits = gpu.limits();
    let checks = [
        ("max_color_attachments", plan.per_pass, limits.max_color_attachments),
        (
            "max_color_attachment_bytes_per_sample",
            plan.per_pass * plan.bytes,
            limits.max_color_attachment_bytes_per_sample,
        ),
        ("max_texture_array_layers", plan.textures, limits.max_texture_array_layers),
    ];
    for (limit, asked, max) in checks {
        if asked > max {
            let error = OpacityGpuError::too_large("opacity maps", asked.into(), limit, max.into());
            return Err(error);
        }
    }
    Ok(())
}

fn blend_state(blend: Blend) -> wgpu::BlendState {
    use wgpu::BlendFactor::{One, OneMinusSrc, OneMinusSrcAlpha, SrcAlpha};
    let state = |source, destination| wgpu::BlendComponent {
        src_factor: source,
        dst_factor: destination,
        operation: wgpu::BlendOperation::Add,
    };
    let (color, alpha) = match blend {
        Blend::Add => (state(One, One), state(One, One)),
        Blend::Over => (state(One, OneMinusSrc), state(One, OneMinusSrcAlpha)),
        Blend::Alpha => (state(SrcAlpha, OneMinusSrcAlpha), state(One, OneMinusSrcAlpha)),
        Blend::Premultiplied => (state(One, OneMinusSrcAlpha), state(One, OneMinusSrcAlpha)),
    };
    wgpu::BlendState { color, alpha }
}

fn blended(
    gpu: &Gpu,
    raster: &Raster,
    inputs: &Inputs<'_>,
    depth_tested: bool,
) -> Result<Maps, OpacityGpuError> {
    let layered = inputs.layered;
    let plan = plan(layered)?;
    check_limits(gpu, plan)?;
    if layered.format == Format::F32 {
        need_blendable(gpu, "blending opacity in 32-bit floats")?;
    }
    let texture = texture_array(gpu, raster, plan)?;
    let view = texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    });
    let slots = layout(gpu, "layers", &[Slot::Uniform, Slot::Floats, Slot::Read]);
    let tested = match depth_tested {
        false => None,
        true => {
            let label = "depth test of the opacity pass";
            let texture = super::raster::depth_texture(gpu, label, raster.width, raster.height)?;
            Some(texture.create_view(&wgpu::TextureViewDescriptor::default()))
        }
    };
    let by_alpha = matches!(layered.blend, Blend::Alpha | Blend::Premultiplied);
    let make = |targets: u32| {
        let target = wgpu::ColorTargetState {
            format: plan.format,
            blend: Some(blend_state(layered.blend)),
            write_mask: wgpu::ColorWrites::ALL,
        };
        let targets_of_pass = vec![Some(target); targets as usize];
        let flag = |on: bool| f64::from(u8::from(on));
        let listing = matches!(layered.layout, Layout::Deep { listing: true, .. });
        let blend = match layered.blend {
            Blend::Add => 0.0,
            Blend::Over => 1.0,
            Blend::Alpha | Blend::Premultiplied => 2.0,
        };
        let mut constants = inputs.placed.constants.to_vec();
        constants.extend([
            ("TARGETS", f64::from(targets)),
            ("SLABS", flag(plan.slabs)),
            ("LISTING", flag(listing)),
            ("BLEND", blend),
        ]);
        let stage = Stage {
            path: PATH,
            entry: if depth_tested { "tested_targets" } else { "targets" },
            constants: &constants,
            pass: Some(&slots),
            targets: &targets_of_pass,
            depth: depth_tested.then(|| depth_state(wgpu::CompareFunction::Less, true)),
            swapped: false,
            opaque_joins: true,
        };
        raster.pipelines(gpu, &stage)
    };
    let mut pipelines = vec![make(plan.per_pass)?];
    let last = plan.textures % plan.per_pass;
    if last != 0 {
        pipelines.push(make(last)?);
    }
    let mut passes = Vec::new();
    for pass in 0..plan.passes() {
        let textures = pass * plan.per_pass..((pass + 1) * plan.per_pass).min(plan.textures);
        // In states whose channels are not independent, a texture of one layer still darkens by
        // what its unused channels hold.
        let unused = if by_alpha { 4 - plan.per_texture } else { 0 };
        let (first, end) = (textures.start * plan.per_texture, textures.end * plan.per_texture);
        let params = inputs.placed.params.of_pass(first, end + unused);
        let params = gpu.uniform("layers of a pass", &params)?;
        let bounds = wgpu::BindingResource::TextureView(inputs.bounds);
        let group = bind(gpu, &slots, &[whole(&params), bounds, whole(inputs.table)]);
        let full = textures.len() as u32 == plan.per_pass;
        let one = |index: u32| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer: index,
                array_layer_count: Some(1),
                ..Default::default()
            })
        };
        let views = textures.map(one).collect();
        passes.push(Pass { views, group, pipelines: usize::from(!full) });
    }
    Ok(Maps::Blended { plan, texture, view, passes, pipelines, tested })
}

fn texture_array(gpu: &Gpu, raster: &Raster, plan: Plan) -> Result<wgpu::Texture, GpuError> {
    gpu.scoped("texture `opacity maps`", || {
        gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("opacity maps"),
            size: wgpu::Extent3d {
                width: raster.width,
                height: raster.height,
                depth_or_array_layers: plan.textures,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: plan.format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    })
}

fn bins(gpu: &Gpu, raster: &Raster, inputs: &Inputs<'_>) -> Result<Maps, OpacityGpuError> {
    let layered = inputs.layered;
    if layered.blend != Blend::Add {
        return Err(no_form("atomic blending other than by addition", "atomics add"));
    }
    if !matches!(layered.format, Format::Fixed | Format::F32) {
        let what = format!("atomic addition in {:?}", layered.format);
        return Err(no_form(what, "atomics add integers"));
    }
    if matches!(layered.layout, Layout::Deep { listing: true, .. }) {
        return Err(no_form("the listing's masks in bins", "a bin is summed into all later maps"));
    }
    let texels = u64::from(raster.width) * u64::from(raster.height);
    let sums = gpu.buffer("bins", 4 * texels * u64::from(layered.layers))?;
    // Exactly a word a texel: the shader takes the number of texels from its length.
    let overrun = gpu.upload("overrun bins", &vec![0u32; texels as usize])?;
    let slots = [Slot::Uniform, Slot::Floats, Slot::Read, Slot::Write, Slot::Write];
    let slots = layout(gpu, "bins", &slots);
    let params = gpu.uniform("layers", &inputs.placed.params)?;
    let bounds = wgpu::BindingResource::TextureView(inputs.bounds);
    let resources = [whole(&params), bounds, whole(inputs.table), whole(&sums), whole(&overrun)];
    let group = bind(gpu, &slots, &resources);
    let stage = Stage {
        path: PATH,
        entry: "add_to_bin",
        constants: &inputs.placed.constants,
        pass: Some(&slots),
        targets: &[],
        depth: None,
        swapped: false,
        opaque_joins: true,
    };
    let pipelines = raster.pipelines(gpu, &stage)?;
    let prefix = gpu.compute("opacity-maps/prefix.wgsl", "prefix", &[])?;
    let sizes = PrefixParams { texels: texels as u32, layers: layered.layers, pad: [0; 2] };
    let prefix_group = gpu.bind(&prefix, 0, &[&gpu.uniform("prefix", &sizes)?, &sums, &overrun]);
    let workgroups = gpu.workgroups(texels, 64)?;
    Ok(Maps::Bins { sums, overrun, pipelines, group, prefix, prefix_group, workgroups })
}

/// Numbers of a texture as it is read back.
fn floats(bytes: &[u8], format: wgpu::TextureFormat) -> Vec<f32> {
    match format {
        wgpu::TextureFormat::Rgba16Float => {
            let halves: Vec<half::f16> = bytemuck::pod_collect_to_vec(bytes);
            halves.into_iter().map(half::f16::to_f32).collect()
        }
        wgpu::TextureFormat::Rgba8Unorm => {
            bytes.iter().map(|&byte| f32::from(byte) / 255.0).collect()
        }
        _ => bytemuck::pod_collect_to_vec(bytes),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_has_the_layout_of_the_shader() {
        crate::gpu::mirror::<PrefixParams>(
            "opacity-maps/prefix.wgsl",
            "PrefixParams",
            &[("texels", 0), ("layers", 4), ("pad0", 8), ("pad1", 12)],
        );
    }
}
