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
use dapple_gpu::{Frame, Gpu, GpuError, Targets, wgpu};
use thiserror::Error;

/// A corner of a triangle, seen from the light. 24 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct LightSpaceVertex {
    /// `[u * w, v * w, w]`: map coordinates (0..=1 inside the map, v down) times `w`. `w` is 1 for
    /// parallel light, and the distance along the light's axis, in any unit, for a perspective
    /// one: affine in world space, negative behind the light.
    pub position: [f32; 3],
    /// Linear depth, 0 at the near plane and 1 at the far plane; fragments outside are dropped.
    pub z: f32,
    /// Texture coordinates for the alpha test.
    pub uv: [f32; 2],
}

/// A cut-out texture, read at the nearest texel and repeated.
#[derive(Clone, Debug, PartialEq)]
pub struct AlphaTexture {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height` alphas in 0..=1, from v = 0 on.
    pub alpha: Vec<f32>,
}

/// Triangles that share an alpha test.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleGroup {
    /// First index of the group.
    pub first: u32,
    /// Number of indices, a multiple of 3.
    pub count: u32,
    /// Index into [`LightSpaceMesh::textures`] and the alpha below which there is a hole.
    pub alpha: Option<(u32, f32)>,
}

/// What a light sees.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightSpaceMesh {
    /// Corners.
    pub vertices: Vec<LightSpaceVertex>,
    /// Three a triangle, of either winding.
    pub indices: Vec<u32>,
    /// Ranges of `indices`; those in no group are not drawn.
    pub groups: Vec<TriangleGroup>,
    /// Cut-out textures.
    pub textures: Vec<AlphaTexture>,
}

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
    /// A vertex with a NaN or infinite component.
    #[error("vertex {vertex} is not finite")]
    Vertex {
        /// Index into the vertices.
        vertex: usize,
    },
    /// An index beyond the vertices.
    #[error("index {place} is {index}, but there are {vertices} vertices")]
    Index {
        /// Place in the indices.
        place: usize,
        /// What stands there.
        index: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A group whose range is not whole triangles of the mesh, or whose texture does not exist.
    #[error("triangle group {group} does not fit the mesh: {why}")]
    Group {
        /// Index into the groups.
        group: usize,
        /// What is wrong.
        why: &'static str,
    },
    /// A texture whose size and alphas disagree, or that is empty.
    #[error(
        "alpha texture {texture} should hold {expected} (and at least 1) alphas and holds {actual}"
    )]
    Texture {
        /// Index into the textures.
        texture: usize,
        /// `width * height`, which must not be 0.
        expected: u64,
        /// Alphas given.
        actual: usize,
    },
    /// The graphics device refused.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

impl LightSpaceMesh {
    /// Checks every vertex, index, group and texture.
    ///
    /// # Errors
    /// The [`DepthRasterError`] that names the first bad element.
    pub fn check(&self) -> Result<(), DepthRasterError> {
        let finite = |v: &LightSpaceVertex| {
            v.position.iter().chain(&[v.z]).chain(&v.uv).all(|component| component.is_finite())
        };
        if let Some(vertex) = self.vertices.iter().position(|v| !finite(v)) {
            return Err(DepthRasterError::Vertex { vertex });
        }
        let vertices = self.vertices.len();
        if let Some(place) = self.indices.iter().position(|&i| i as usize >= vertices) {
            return Err(DepthRasterError::Index { place, index: self.indices[place], vertices });
        }
        for (texture, t) in self.textures.iter().enumerate() {
            let expected = u64::from(t.width) * u64::from(t.height);
            if expected == 0 || t.alpha.len() as u64 != expected {
                return Err(DepthRasterError::Texture { texture, expected, actual: t.alpha.len() });
            }
        }
        for (group, g) in self.groups.iter().enumerate() {
            let end = u64::from(g.first) + u64::from(g.count);
            let why = if end > self.indices.len() as u64 {
                "it reaches beyond the last index"
            } else if !g.count.is_multiple_of(3) {
                "its indices are no whole triangles"
            } else if g.alpha.is_some_and(|(texture, _)| texture as usize >= self.textures.len()) {
                "its alpha texture does not exist"
            } else if g.alpha.is_some_and(|(_, cutoff)| !cutoff.is_finite()) {
                "its alpha cutoff is not finite"
            } else {
                continue;
            };
            return Err(DepthRasterError::Group { group, why });
        }
        Ok(())
    }
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

    fn mesh() -> LightSpaceMesh {
        let corner = LightSpaceVertex { position: [0.5, 0.5, 1.0], z: 0.5, uv: [0.0; 2] };
        LightSpaceMesh {
            vertices: vec![corner; 3],
            indices: vec![0, 1, 2],
            groups: vec![TriangleGroup { first: 0, count: 3, alpha: None }],
            textures: Vec::new(),
        }
    }

    #[test]
    fn uniform_has_the_layout_of_the_shader() {
        let source = dapple_shaders::source("shadows/depth.wgsl").unwrap();
        let layout = dapple_shaders::struct_layout(&source, "DepthParams").unwrap();
        let names: Vec<_> = layout.fields.iter().map(|f| (f.0.as_str(), f.1)).collect();
        assert_eq!(names, [("cutoff", 0), ("alpha_width", 4), ("alpha_height", 8), ("pad", 12)]);
        assert_eq!(layout.size as usize, size_of::<DepthParams>());
        assert_eq!(size_of::<LightSpaceVertex>(), 24);
    }

    #[test]
    fn bad_meshes_are_refused_with_the_element() {
        assert_eq!(mesh().check(), Ok(()));
        let mut m = mesh();
        m.vertices[2].z = f32::NAN;
        assert_eq!(m.check(), Err(DepthRasterError::Vertex { vertex: 2 }));
        let mut m = mesh();
        m.indices[1] = 3;
        let error = DepthRasterError::Index { place: 1, index: 3, vertices: 3 };
        assert_eq!(m.check(), Err(error));
        for (first, count, alpha) in
            [(0, 6, None), (1, 3, None), (0, 2, None), (0, 3, Some((0, 0.5))), (u32::MAX, 3, None)]
        {
            let mut m = mesh();
            m.groups.push(TriangleGroup { first, count, alpha });
            assert!(matches!(m.check(), Err(DepthRasterError::Group { group: 1, .. })));
        }
        let mut m = mesh();
        m.textures.push(AlphaTexture { width: 2, height: 2, alpha: vec![1.0; 3] });
        let error = DepthRasterError::Texture { texture: 0, expected: 4, actual: 3 };
        assert_eq!(m.check(), Err(error));
        m.textures[0] = AlphaTexture { width: 0, height: 2, alpha: Vec::new() };
        assert!(matches!(m.check(), Err(DepthRasterError::Texture { .. })));
        m.textures[0] = AlphaTexture { width: 0, height: 2, alpha: vec![1.0] };
        assert!(matches!(m.check(), Err(DepthRasterError::Texture { .. })));
    }
}
