//! The graphics device's form: one depth pass a cascade, then one compute pass over receivers.
//!
//! The maps are the layers of one depth texture, which shade reads as it is drawn: no copy. One
//! upload of the triangles serves all passes; each has its crop. Passes of a frame: "depth-0",
//! "depth-1", ... and "shade". Nothing is created in [`Shadows::record`].

use bytemuck::{Pod, Zeroable};
use dapple_gpu::light_space::LightSpaceMesh;
use dapple_gpu::{Frame, Gpu, GpuError, Targets, wgpu};
use thiserror::Error;

use super::lookup::{MAX_SLOPE, Region};
use super::{
    Cascade, CascadeError, CascadeReceiver, Counters, MAX_CASCADES, Settings, check_settings,
};
use crate::filtering::DepthMap;
use crate::filtering::gpu_depth::{BoundCrop, Crop, DepthCopy, DepthRasterError, DepthTriangles};

/// Names of the depth passes.
pub const DEPTH_PASSES: [&str; MAX_CASCADES] =
    ["depth-0", "depth-1", "depth-2", "depth-3", "depth-4", "depth-5", "depth-6", "depth-7"];

/// Why cascades cannot be drawn.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum GpuCascadeError {
    /// Cascades or settings are not sound.
    #[error(transparent)]
    Cascade(#[from] CascadeError),
    /// The triangles cannot be rasterised.
    #[error(transparent)]
    Depth(#[from] DepthRasterError),
    /// The device refused, or a named limit of it is too small.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

/// Mirrors `CascadeParams` of `shadows/cascade.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct CascadeParams {
    side: u32,
    receivers: u32,
    cascades: u32,
    pad: u32,
    bias: f32,
    slope_bias: f32,
    max_slope: f32,
    pad0: f32,
}

/// Mirrors `Region` of `shadows/cascade.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct RegionWords {
    offset_u: f32,
    offset_v: f32,
    texels_per_unit: f32,
    texel: f32,
    far: f32,
    pad: [f32; 3],
}

/// One cascade's layer.
#[derive(Debug)]
struct Map {
    view: wgpu::TextureView,
    /// `None` where the cascade is empty: its map is cleared and nothing drawn.
    crop: Option<BoundCrop>,
}

/// Cascades over one set of triangles, and the receivers they shade.
#[derive(Debug)]
pub struct Shadows {
    side: u32,
    triangles: DepthTriangles,
    maps: Vec<Map>,
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    workgroups: [u32; 3],
    receivers: usize,
    visibilities: wgpu::Buffer,
    counters: Counters,
}

impl Shadows {
    /// Uploads triangles (seen in the base map) and receivers and makes everything a frame needs,
    /// for maps of `side` x `side` texels.
    ///
    /// # Errors
    /// What [`Settings::check`] refuses; a side out of range; cascades that do not fit together;
    /// what [`LightSpaceMesh::check`] finds; [`GpuCascadeError::Gpu`] where maps, mesh or
    /// receivers exceed a named limit of the device.
    pub fn new(
        gpu: &Gpu,
        mesh: &LightSpaceMesh,
        cascades: &[Cascade],
        side: u32,
        receivers: &[CascadeReceiver],
        settings: &Settings,
    ) -> Result<Self, GpuCascadeError> {
        check_settings(side, cascades, settings)?;
        let count = u32::try_from(receivers.len()).map_err(|_| GpuError::TooLarge {
            what: "receivers".into(),
            asked: receivers.len() as u64,
            limit: "u32 indices",
            max: u32::MAX.into(),
        })?;
        let regions: Vec<Region> = cascades.iter().map(|c| Region::new(c, side)).collect();
        let triangles = DepthTriangles::new(gpu, mesh)?;
        let texture = gpu.texture_array(
            "cascades",
            side,
            side,
            cascades.len() as u32,
            wgpu::TextureFormat::Depth32Float,
            wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        )?;
        let map = |(layer, cascade): (u32, &Cascade)| -> Result<Map, GpuError> {
            let view = texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer: layer,
                array_layer_count: Some(1),
                ..Default::default()
            });
            let crop = if cascade.is_empty() {
                None
            } else {
                Some(triangles.bind(gpu, crop_of(cascade))?)
            };
            Ok(Map { view, crop })
        };
        let maps = (0..).zip(cascades).map(map).collect::<Result<Vec<_>, _>>()?;

        let params = CascadeParams {
            side,
            receivers: count,
            cascades: cascades.len() as u32,
            pad: 0,
            bias: settings.bias,
            slope_bias: settings.slope_bias,
            max_slope: MAX_SLOPE,
            pad0: 0.0,
        };
        let constants = [
            ("TAPS", f64::from(settings.taps.side())),
            ("PLANE_BIAS", f64::from(u8::from(settings.plane_bias))),
        ];
        let pipeline = gpu.compute("shadows/cascade.wgsl", "shade_cascades", &constants)?;
        let words: Vec<RegionWords> = regions.iter().map(words_of).collect();
        // A binding holds one receiver at least; the shader reads as many as there are.
        let no_receiver = [CascadeReceiver::at(0.0, 0.0, 0.0, 0.0)];
        let shown = if receivers.is_empty() { &no_receiver } else { receivers };
        let params = gpu.uniform("cascades", &params)?;
        let regions_buffer = gpu.upload("regions", &words)?;
        let receivers_buffer = gpu.upload("receivers", shown)?;
        let visibilities = gpu.buffer("visibilities", 4 * u64::from(count))?;
        let layers = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        let resources = [
            params.as_entire_binding(),
            regions_buffer.as_entire_binding(),
            receivers_buffer.as_entire_binding(),
            wgpu::BindingResource::TextureView(&layers),
            visibilities.as_entire_binding(),
        ];
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("cascades"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let workgroups = gpu.workgroups(u64::from(count), 64)?;
        gpu.check()?;
        Ok(Self {
            side,
            triangles,
            maps,
            pipeline,
            group,
            workgroups,
            receivers: receivers.len(),
            visibilities,
            counters: Counters::of(&regions, side, settings, receivers),
        })
    }

    /// Records the passes of a frame: one of [`DEPTH_PASSES`] for each cascade, and "shade".
    pub fn record(&self, frame: &mut Frame<'_>) {
        for (name, map) in DEPTH_PASSES.into_iter().zip(&self.maps) {
            let targets =
                Targets { depth: Targets::cleared_depth(&map.view, 1.0), ..Targets::default() };
            frame.raster(name, targets, |pass| {
                if let Some(crop) = &map.crop {
                    self.triangles.draw(pass, crop);
                }
            });
        }
        frame.compute("shade", |pass| {
            let [x, y, z] = self.workgroups;
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &self.group, &[]);
            pass.dispatch_workgroups(x, y, z);
        });
    }

    /// Visibilities of the last frame, one a receiver.
    ///
    /// # Errors
    /// Those of [`Gpu::read`].
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<f32>, GpuError> {
        gpu.read(&self.visibilities, 0, self.receivers)
    }

    /// The maps of the last frame, in the order of the cascades.
    ///
    /// # Errors
    /// As [`Frame::finish`] and [`Gpu::read`].
    pub fn read_maps(&self, gpu: &Gpu) -> Result<Vec<DepthMap>, GpuError> {
        let (width, height) = (self.side, self.side);
        let read = |map: &Map| {
            let copy = DepthCopy::new(gpu, &map.view, width, height)?;
            let mut frame = gpu.frame();
            copy.record(&mut frame);
            frame.finish()?;
            Ok(DepthMap { width, height, depths: copy.read(gpu)? })
        };
        self.maps.iter().map(read).collect()
    }

    /// Work of a frame.
    #[must_use]
    pub fn counters(&self) -> Counters {
        self.counters
    }
}

fn crop_of(cascade: &Cascade) -> Crop {
    Crop {
        offset_u: cascade.offset[0] as f32,
        offset_v: cascade.offset[1] as f32,
        per_side: (1.0 / cascade.scale) as f32,
        pad: 0.0,
    }
}

fn words_of(region: &Region) -> RegionWords {
    RegionWords {
        offset_u: region.offset[0],
        offset_v: region.offset[1],
        texels_per_unit: region.texels_per_unit,
        texel: region.texel,
        far: region.far,
        pad: [0.0; 3],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn offsets(name: &str) -> (Vec<(String, u32)>, usize) {
        let source = dapple_shaders::source("shadows/cascade.wgsl").unwrap();
        let layout = dapple_shaders::struct_layout(&source, name).unwrap();
        (layout.fields, layout.size as usize)
    }

    #[test]
    fn structs_have_the_layout_of_the_shader() {
        let check = |name, names: &[&str], size| {
            let (fields, in_shader) = offsets(name);
            assert_eq!(in_shader, size, "{name}");
            let want: Vec<_> =
                names.iter().enumerate().map(|(i, n)| ((*n).to_string(), 4 * i as u32)).collect();
            assert_eq!(fields, want, "{name}");
        };
        let params =
            ["side", "receivers", "cascades", "pad", "bias", "slope_bias", "max_slope", "pad0"];
        check("CascadeParams", &params, size_of::<CascadeParams>());
        let region =
            ["offset_u", "offset_v", "texels_per_unit", "texel", "far", "pad0", "pad1", "pad2"];
        check("Region", &region, size_of::<RegionWords>());
        let receiver = ["u", "v", "depth", "slope_u", "slope_v", "view_depth", "flags", "pad"];
        check("Receiver", &receiver, size_of::<CascadeReceiver>());
        assert_eq!(std::mem::offset_of!(CascadeParams, bias), 16);
        assert_eq!(std::mem::offset_of!(RegionWords, far), 16);
        assert_eq!(std::mem::offset_of!(CascadeReceiver, flags), 24);
    }
}
