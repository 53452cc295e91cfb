//! A shadow map of everything, by the depth test.

use super::{
    OpacityGpuError,
    raster::Raster,
    shade::Decoder,
    stage::{Pipelines, Stage, depth_state, depth_texture},
    technique::Cost,
};
use dapple_gpu::bindings::{bind, layout};
use dapple_gpu::{Frame, Gpu, GpuError, Targets, wgpu};

/// The nearest depth of each texel.
#[derive(Debug)]
pub(super) struct Nearest {
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    pipelines: Pipelines,
    /// Of no bindings.
    group: wgpu::BindGroup,
}

impl Nearest {
    /// Allocates the map.
    pub fn new(gpu: &Gpu, raster: &Raster) -> Result<Self, OpacityGpuError> {
        let texture = depth_texture(gpu, "nearest depths", raster.width, raster.height)?;
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let slots = layout(gpu, "nearest depths", &[]);
        let group = bind(gpu, &slots, &[]);
        let stage = Stage {
            path: super::bounds::PATH,
            entry: "one_end",
            constants: &[],
            pass: Some(&slots),
            targets: &[],
            depth: Some(depth_state(wgpu::CompareFunction::Less, true)),
            swapped: false,
            opaque_joins: true,
        };
        let pipelines = raster.pipelines(gpu, &stage)?;
        Ok(Self { texture, view, pipelines, group })
    }

    /// Records "opacity".
    pub fn record(&self, frame: &mut Frame<'_>, raster: &Raster) {
        let depth = Targets::cleared_depth(&self.view, 1.0);
        let targets = Targets { depth, ..Targets::default() };
        frame.raster("opacity", targets, |pass| raster.draw(pass, &self.pipelines, &self.group));
    }

    /// Hands what shading needs to `make`.
    pub fn with_decoder<R>(&self, make: impl FnOnce(&Decoder<'_>) -> R) -> R {
        let path = "opacity-maps/shade_nearest.wgsl";
        let resources = [wgpu::BindingResource::TextureView(&self.view)];
        make(&Decoder { path, constants: &[], resources: &resources })
    }

    /// What it costs.
    pub fn cost(&self, taps: u64) -> Cost {
        let texels = u64::from(self.texture.width()) * u64::from(self.texture.height());
        Cost {
            geometry_passes: 1,
            map_bytes: 4 * texels,
            other_bytes: 0,
            bytes_per_fragment: 4,
            fetches: taps,
        }
    }

    /// The nearest depths, 1 where there is nothing.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<Vec<f32>>, GpuError> {
        Ok(vec![gpu.read_f32(&self.texture)?])
    }
}
