//! Triangles on the graphics device, and the pipelines that draw their depth.

use bytemuck::{Pod, Zeroable};
use dapple_gpu::light_space::{LightSpaceMesh, LightSpaceVertex};
use dapple_gpu::{Gpu, GpuError, wgpu};

use super::DepthRasterError;

/// Mirrors `DepthParams` of `shadows/depth.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct DepthParams {
    cutoff: f32,
    alpha_width: u32,
    alpha_height: u32,
    pad: u32,
}

/// The square of a light's map that is drawn. Mirrors `Crop` of `shadows/depth.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Crop {
    /// Map coordinate u of the square's corner.
    pub offset_u: f32,
    /// Map coordinate v of the square's corner.
    pub offset_v: f32,
    /// 1 / side of the square in map coordinates.
    pub per_side: f32,
    /// Fills the struct to 16 bytes.
    pub pad: f32,
}

impl Crop {
    /// The whole map.
    pub const WHOLE: Self = Self { offset_u: 0.0, offset_v: 0.0, per_side: 1.0, pad: 0.0 };
}

/// A crop as both pipelines bind it.
#[derive(Debug)]
pub struct BoundCrop {
    opaque: wgpu::BindGroup,
    cut_out: wgpu::BindGroup,
}

#[derive(Debug)]
struct Draw {
    indices: std::ops::Range<u32>,
    /// Parameters and alphas; `None` for opaque triangles.
    alpha: Option<wgpu::BindGroup>,
}

/// One set of triangles, to be drawn into any depth target of `Depth32Float`.
#[derive(Debug)]
pub struct DepthTriangles {
    opaque: wgpu::RenderPipeline,
    cut_out: wgpu::RenderPipeline,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    draws: Vec<Draw>,
}

impl DepthTriangles {
    /// Uploads the triangles.
    ///
    /// # Errors
    /// What [`LightSpaceMesh::check`] finds; [`DepthRasterError::Gpu`] where the mesh exceeds a
    /// named limit of the device.
    pub fn new(gpu: &Gpu, mesh: &LightSpaceMesh) -> Result<Self, DepthRasterError> {
        mesh.check()?;
        let module = gpu.module("shadows/depth.wgsl")?;
        let opaque = pipeline(gpu, &module, "opaque")?;
        let cut_out = pipeline(gpu, &module, "cut_out")?;
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
        Ok(Self { opaque, cut_out, vertices, indices, draws })
    }

    /// Uploads a crop.
    ///
    /// # Errors
    /// Those of [`Gpu::uniform`].
    pub fn bind(&self, gpu: &Gpu, crop: Crop) -> Result<BoundCrop, GpuError> {
        let crop = gpu.uniform("crop", &crop)?;
        Ok(BoundCrop {
            opaque: gpu.bind_raster(&self.opaque, 1, &[&crop]),
            cut_out: gpu.bind_raster(&self.cut_out, 1, &[&crop]),
        })
    }

    /// Draws every group into the pass's depth target.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, crop: &BoundCrop) {
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        for draw in &self.draws {
            match &draw.alpha {
                None => {
                    pass.set_pipeline(&self.opaque);
                    pass.set_bind_group(1, &crop.opaque, &[]);
                }
                Some(group) => {
                    pass.set_pipeline(&self.cut_out);
                    pass.set_bind_group(0, group, &[]);
                    pass.set_bind_group(1, &crop.cut_out, &[]);
                }
            }
            pass.draw_indexed(draw.indices.clone(), 0, 0..1);
        }
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
    fn uniforms_have_the_layout_of_the_shader() {
        let source = dapple_shaders::source("shadows/depth.wgsl").unwrap();
        let layout = dapple_shaders::struct_layout(&source, "DepthParams").unwrap();
        let names: Vec<_> = layout.fields.iter().map(|f| (f.0.as_str(), f.1)).collect();
        assert_eq!(names, [("cutoff", 0), ("alpha_width", 4), ("alpha_height", 8), ("pad", 12)]);
        assert_eq!(layout.size as usize, size_of::<DepthParams>());
        let layout = dapple_shaders::struct_layout(&source, "Crop").unwrap();
        let names: Vec<_> = layout.fields.iter().map(|f| (f.0.as_str(), f.1)).collect();
        assert_eq!(names, [("offset_u", 0), ("offset_v", 4), ("per_side", 8), ("pad", 12)]);
        assert_eq!(layout.size as usize, size_of::<Crop>());
    }
}
