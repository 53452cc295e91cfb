//! The depth map of light-space triangles by rasterisation.
//!
//! Pixel centres are texel centres, v grows downwards. The depth buffer keeps the smallest
//! *linear* depth: each fragment writes its own instead of the clip-space one, which would be
//! hyperbolic for a perspective light. A compute pass then copies it to the buffer that
//! [`gpu::Filter`](super::gpu::Filter) reads.
//!
//! Against depths of rays through texel centres, results differ by the interpolation's rounding,
//! and where a texel centre lies within the rasteriser's sub-pixel step (1/256 texel) of an edge.

use bytemuck::{Pod, Zeroable};
use dapple_gpu::light_space::{LightSpaceError, LightSpaceMesh, LightSpaceVertex};
use dapple_gpu::{Frame, Gpu, GpuError, Targets, wgpu};
use thiserror::Error;

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

/// Mirrors `DepthParams` of `shadows/depth.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct DepthParams {
    cutoff: f32,
    alpha_width: u32,
    alpha_height: u32,
    pad: u32,
}

#[derive(Debug)]
struct Draw {
    indices: std::ops::Range<u32>,
    /// Parameters and alphas; `None` for opaque triangles.
    alpha: Option<wgpu::BindGroup>,
}

/// Draws one set of triangles into one depth map, frame after frame.
#[derive(Debug)]
pub struct DepthRaster {
    width: u32,
    height: u32,
    opaque: wgpu::RenderPipeline,
    cut_out: wgpu::RenderPipeline,
    copy: wgpu::ComputePipeline,
    copy_group: wgpu::BindGroup,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    draws: Vec<Draw>,
    target: wgpu::TextureView,
    depths: wgpu::Buffer,
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
        mesh.check()?;
        let depths = gpu.buffer("depths", u64::from(width) * u64::from(height) * 4)?;
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
        let texture =
            gpu.texture("depth", width, height, wgpu::TextureFormat::Depth32Float, usage)?;
        let target = texture.create_view(&wgpu::TextureViewDescriptor::default());

        let module = gpu.module("shadows/depth.wgsl")?;
        let opaque = pipeline(gpu, &module, "opaque")?;
        let cut_out = pipeline(gpu, &module, "cut_out")?;
        let copy = gpu.compute("shadows/depth_copy.wgsl", "copy_depth", &[])?;
        let copy_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("depth-copy"),
            layout: &copy.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(&target),
                },
                wgpu::BindGroupEntry { binding: 1, resource: depths.as_entire_binding() },
            ],
        });

        let alphas = mesh
            .textures
            .iter()
            .map(|texture| gpu.upload("alpha", &texture.alpha))
            .collect::<Result<Vec<_>, _>>()?;
        let mut draws = Vec::with_capacity(mesh.groups.len());
        for group in &mesh.groups {
            let alpha = match group.alpha {
                None => None,
                Some((texture, cutoff)) => {
                    let texture = texture as usize;
                    let size = &mesh.textures[texture];
                    let params = DepthParams {
                        cutoff,
                        alpha_width: size.width,
                        alpha_height: size.height,
                        pad: 0,
                    };
                    let params = gpu.uniform("alpha test", &params)?;
                    Some(gpu.bind_raster(&cut_out, 0, &[&params, &alphas[texture]]))
                }
            };
            draws.push(Draw { indices: group.first..group.first + group.count, alpha });
        }
        let vertices = gpu.upload("light-space vertices", &mesh.vertices)?;
        let indices = gpu.upload("light-space indices", &mesh.indices)?;
        gpu.check()?;
        Ok(Self {
            width,
            height,
            opaque,
            cut_out,
            copy,
            copy_group,
            vertices,
            indices,
            draws,
            target,
            depths,
        })
    }

    /// Records the passes "depth" and "depth-copy".
    pub fn record(&self, frame: &mut Frame<'_>) {
        let targets =
            Targets { depth: Targets::cleared_depth(&self.target, 1.0), ..Targets::default() };
        frame.raster("depth", targets, |pass| {
            pass.set_vertex_buffer(0, self.vertices.slice(..));
            pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
            for draw in &self.draws {
                match &draw.alpha {
                    None => pass.set_pipeline(&self.opaque),
                    Some(group) => {
                        pass.set_pipeline(&self.cut_out);
                        pass.set_bind_group(0, group, &[]);
                    }
                }
                pass.draw_indexed(draw.indices.clone(), 0, 0..1);
            }
        });
        frame.compute("depth-copy", |pass| {
            pass.set_pipeline(&self.copy);
            pass.set_bind_group(0, &self.copy_group, &[]);
            pass.dispatch_workgroups(self.width.div_ceil(64), self.height, 1);
        });
    }

    /// The depths, row-major, `width * height` f32: what the filters read.
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

fn pipeline(
    gpu: &Gpu,
    module: &wgpu::ShaderModule,
    fragment: &str,
) -> Result<wgpu::RenderPipeline, GpuError> {
    let attributes = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32, 2 => Float32x2];
    gpu.raster(
        "shadows/depth.wgsl",
        &wgpu::RenderPipelineDescriptor {
            label: Some(fragment),
            layout: None,
            vertex: wgpu::VertexState {
                module,
                entry_point: Some("place"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[Some(wgpu::VertexBufferLayout {
                    array_stride: size_of::<LightSpaceVertex>() as u64,
                    step_mode: wgpu::VertexStepMode::Vertex,
                    attributes: &attributes,
                })],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: wgpu::TextureFormat::Depth32Float,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Less),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some(fragment),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[],
            }),
            multiview_mask: None,
            cache: None,
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_has_the_layout_of_the_shader() {
        let source = dapple_shaders::source("shadows/depth.wgsl").unwrap();
        let layout = dapple_shaders::struct_layout(&source, "DepthParams").unwrap();
        let names: Vec<_> = layout.fields.iter().map(|f| (f.0.as_str(), f.1)).collect();
        assert_eq!(names, [("cutoff", 0), ("alpha_width", 4), ("alpha_height", 8), ("pad", 12)]);
        assert_eq!(layout.size as usize, size_of::<DepthParams>());
    }
}
