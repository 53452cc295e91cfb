//! The depth map of light-space triangles by rasterisation.
//!
//! Pixel centres are texel centres, v grows downwards. The depth buffer keeps the smallest
//! *linear* depth: each fragment writes its own instead of the clip-space one, which would be
//! hyperbolic for a perspective light. A compute pass then copies it to the buffer that
//! [`gpu::Filter`](super::gpu::Filter) reads.
//!
//! Against depths of rays through texel centres, results differ by the interpolation's rounding,
//! and where a texel centre lies within the rasteriser's sub-pixel step (1/256 texel) of an edge.

mod triangles;

use dapple_gpu::light_space::{LightSpaceError, LightSpaceMesh};
use dapple_gpu::{Frame, Gpu, GpuError, Targets, wgpu};
use thiserror::Error;

pub use triangles::{BoundCrop, Crop, DepthTriangles};

/// Why triangles cannot be rasterised.
#[derive(Debug, Error, Clone, PartialEq)]
pub enum DepthRasterError {
    /// A side of the map is 0.
    #[error("the depth map is empty ({width} x {height} texels)")]
    EmptyMap {
        /// Texels in a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// The mesh is not sound.
    #[error(transparent)]
    Mesh(#[from] LightSpaceError),
    /// The graphics device refused.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

/// Copies a depth texture to a buffer.
#[derive(Debug)]
pub struct DepthCopy {
    width: u32,
    height: u32,
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    depths: wgpu::Buffer,
}

impl DepthCopy {
    /// A copy of `source`, a view of `width` x `height` texels of `Depth32Float`.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`], [`GpuError::OutOfMemory`].
    pub fn new(
        gpu: &Gpu,
        source: &wgpu::TextureView,
        width: u32,
        height: u32,
    ) -> Result<Self, GpuError> {
        let depths = gpu.buffer("depths", u64::from(width) * u64::from(height) * 4)?;
        let pipeline = gpu.compute("shadows/depth_copy.wgsl", "copy_depth", &[])?;
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("depth-copy"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(source),
                },
                wgpu::BindGroupEntry { binding: 1, resource: depths.as_entire_binding() },
            ],
        });
        Ok(Self { width, height, pipeline, group, depths })
    }

    /// Records the pass "depth-copy".
    pub fn record(&self, frame: &mut Frame<'_>) {
        frame.compute("depth-copy", |pass| {
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &self.group, &[]);
            pass.dispatch_workgroups(self.width.div_ceil(64), self.height, 1);
        });
    }

    /// The depths, row-major, `width * height` f32.
    pub fn depths(&self) -> &wgpu::Buffer {
        &self.depths
    }

    /// Reads the depths back.
    ///
    /// # Errors
    /// Those of [`Gpu::read`].
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<f32>, GpuError> {
        gpu.read(&self.depths, 0, self.width as usize * self.height as usize)
    }
}

/// Draws one set of triangles into one depth map, frame after frame.
#[derive(Debug)]
pub struct DepthRaster {
    triangles: DepthTriangles,
    crop: BoundCrop,
    target: wgpu::TextureView,
    copy: DepthCopy,
}

impl DepthRaster {
    /// Uploads the triangles and makes everything a frame needs.
    ///
    /// # Errors
    /// What [`LightSpaceMesh::check`] finds; [`DepthRasterError::EmptyMap`];
    /// [`DepthRasterError::Gpu`] where the map or mesh exceeds a named limit of the device.
    pub fn new(
        gpu: &Gpu,
        mesh: &LightSpaceMesh,
        width: u32,
        height: u32,
    ) -> Result<Self, DepthRasterError> {
        if width == 0 || height == 0 {
            return Err(DepthRasterError::EmptyMap { width, height });
        }
        let triangles = DepthTriangles::new(gpu, mesh)?;
        let crop = triangles.bind(gpu, Crop::WHOLE)?;
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
        let texture =
            gpu.texture("depth", width, height, wgpu::TextureFormat::Depth32Float, usage)?;
        let target = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let copy = DepthCopy::new(gpu, &target, width, height)?;
        gpu.check()?;
        Ok(Self { triangles, crop, target, copy })
    }

    /// Records the passes "depth" and "depth-copy".
    pub fn record(&self, frame: &mut Frame<'_>) {
        let targets =
            Targets { depth: Targets::cleared_depth(&self.target, 1.0), ..Targets::default() };
        frame.raster("depth", targets, |pass| self.triangles.draw(pass, &self.crop));
        self.copy.record(frame);
    }

    /// The depths, row-major, `width * height` f32: what the filters read.
    pub fn depths(&self) -> &wgpu::Buffer {
        self.copy.depths()
    }

    /// Reads the depths back.
    ///
    /// # Errors
    /// Those of [`Gpu::read`].
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<f32>, GpuError> {
        self.copy.read(gpu)
    }
}
