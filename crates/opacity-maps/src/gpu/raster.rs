//! The light's triangles on the device, and the one way in which every pass over them is drawn.
//!
//! Group 0 of every pipeline belongs to the surfaces (alpha test, thickness, opaque map), group 1
//! to the pass. Translucent passes read the opaque map in the fragment shader instead of testing
//! depths: what lies at or behind the nearest opaque surface is dropped.

use super::OpacityGpuError;
use crate::{Model, OpacityError, Opaque};
use bytemuck::{Pod, Zeroable};
use dapple_gpu::light_space::{LightSpaceMesh, LightSpaceVertex, TriangleGroup};
use dapple_gpu::{Frame, Gpu, GpuError, Targets, wgpu};

/// Mirrors `SurfaceParams` of `common/opacity_surface.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Default, Pod, Zeroable)]
struct SurfaceParams {
    cutoff: f32,
    alpha_width: u32,
    alpha_height: u32,
    flags: u32,
    omega: f32,
    opacity: f32,
    pad: [u32; 2],
}

impl SurfaceParams {
    fn of(omega: f32, flags: u32) -> Self {
        Self { omega, opacity: -(-f64::from(omega)).exp_m1() as f32, flags, ..Self::default() }
    }
}

const ALPHA_TESTED: u32 = 1;
const FROM_OPAQUE_MAP: u32 = 2;

/// Shader of the vertex stages.
const PLACE: &str = "opacity-maps/place.wgsl";

#[derive(Debug)]
struct Draw {
    indices: std::ops::Range<u32>,
    group: wgpu::BindGroup,
}

/// What a binding of a pass is.
#[derive(Clone, Copy, Debug)]
pub(super) enum Slot {
    /// A uniform buffer.
    Uniform,
    /// A storage buffer that is only read.
    Read,
    /// A storage buffer that is also written.
    Write,
    /// A depth texture.
    Depth,
    /// A texture of unfiltered floats.
    Floats,
}

/// A layout of bindings 0.. for fragment shaders.
pub(super) fn layout(gpu: &Gpu, label: &str, slots: &[Slot]) -> wgpu::BindGroupLayout {
    let buffer =
        |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    let texture = |sample_type| wgpu::BindingType::Texture {
        sample_type,
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let entries: Vec<_> = (0..)
        .zip(slots)
        .map(|(binding, slot)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: match slot {
                Slot::Uniform => buffer(wgpu::BufferBindingType::Uniform),
                Slot::Read => buffer(wgpu::BufferBindingType::Storage { read_only: true }),
                Slot::Write => buffer(wgpu::BufferBindingType::Storage { read_only: false }),
                Slot::Depth => texture(wgpu::TextureSampleType::Depth),
                Slot::Floats => texture(wgpu::TextureSampleType::Float { filterable: false }),
            },
            count: None,
        })
        .collect();
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some(label),
        entries: &entries,
    })
}

/// A bind group, binding i = the i-th resource.
pub(super) fn bind(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    resources: &[wgpu::BindingResource<'_>],
) -> wgpu::BindGroup {
    let entries: Vec<_> = (0..)
        .zip(resources)
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource: resource.clone() })
        .collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout,
        entries: &entries,
    })
}

/// A buffer bound whole, its size spelled out (see [`Gpu::bind`]).
pub(super) fn whole(buffer: &wgpu::Buffer) -> wgpu::BindingResource<'_> {
    wgpu::BindingResource::Buffer(wgpu::BufferBinding {
        buffer,
        offset: 0,
        size: std::num::NonZeroU64::new(buffer.size()),
    })
}

/// What a pass does with fragments.
pub(super) struct Stage<'a> {
    /// Shader file.
    pub path: &'a str,
    /// Entry point of the fragment stage.
    pub entry: &'a str,
    /// Its `override`s.
    pub constants: &'a [(&'a str, f64)],
    /// Layout of group 1, where the stage has one.
    pub pass: Option<&'a wgpu::BindGroupLayout>,
    /// Render targets.
    pub targets: &'a [Option<wgpu::ColorTargetState>],
    /// Depth test; `None` attaches the opaque map without touching it where there are no targets.
    pub depth: Option<wgpu::DepthStencilState>,
    /// Whether near and far plane change places.
    pub swapped: bool,
    /// Whether the nearest opaque surface of each texel takes part as a fragment.
    pub opaque_joins: bool,
}

/// A stage as pipelines: over the mesh, and over the opaque map where that takes part.
#[derive(Debug)]
pub(super) struct Pipelines {
    mesh: wgpu::RenderPipeline,
    cover: Option<wgpu::RenderPipeline>,
}

/// A depth test that keeps what passes `compare`.
pub(super) fn depth_state(compare: wgpu::CompareFunction, write: bool) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: wgpu::TextureFormat::Depth32Float,
        depth_write_enabled: Some(write),
        depth_compare: Some(compare),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState::default(),
    }
}

/// A mesh uploaded once, with its opaque map.
#[derive(Debug)]
pub(super) struct Raster {
    pub width: u32,
    pub height: u32,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    opaque: Vec<Draw>,
    translucent: Vec<Draw>,
    /// The nearest opaque surface as a fragment.
    cover: Option<wgpu::BindGroup>,
    surfaces: wgpu::BindGroupLayout,
    opaque_pipeline: wgpu::RenderPipeline,
    opaque_map: wgpu::Texture,
    opaque_view: wgpu::TextureView,
}

impl Raster {
    /// Uploads the mesh and makes the opaque map.
    pub fn new(
        gpu: &Gpu,
        mesh: &LightSpaceMesh,
        model: Model,
        [width, height]: [u32; 2],
        opaque: Opaque,
    ) -> Result<Self, OpacityGpuError> {
        if width == 0 || height == 0 {
            return Err(OpacityError::EmptyMap { width, height }.into());
        }
        mesh.check()?;
        let opaque_map = depth_texture(gpu, "opaque map", width, height)?;
        let opaque_view = opaque_map.create_view(&wgpu::TextureViewDescriptor::default());
        let own = layout(gpu, "opaque surfaces", &[Slot::Uniform, Slot::Read]);
        let surfaces =
            layout(gpu, "translucent surfaces", &[Slot::Uniform, Slot::Read, Slot::Depth]);
        let no_alpha = gpu.upload("no alpha", &[1.0f32])?;
        let alphas = mesh
            .textures
            .iter()
            .map(|texture| gpu.upload("alpha", &texture.alpha))
            .collect::<Result<Vec<_>, GpuError>>()?;
        let (mut opaque_draws, mut translucent) = (Vec::new(), Vec::new());
        for group in &mesh.groups {
            let params = gpu.uniform("surface", &surface(mesh, group, model))?;
            let alpha = group.alpha.map_or(&no_alpha, |(texture, _)| &alphas[texture as usize]);
            let indices = group.first..group.first + group.count;
            if group.opacity >= 1.0 {
                let group = bind(gpu, &own, &[whole(&params), whole(alpha)]);
                opaque_draws.push(Draw { indices, group });
            } else {
                let view = wgpu::BindingResource::TextureView(&opaque_view);
                let group = bind(gpu, &surfaces, &[whole(&params), whole(alpha), view]);
                translucent.push(Draw { indices, group });
            }
        }
        let cover = match opaque {
            Opaque::Separate => None,
            Opaque::Weight { weight, .. } => {
                let params = SurfaceParams::of(weight, FROM_OPAQUE_MAP);
                let params = gpu.uniform("opaque weight", &params)?;
                let view = wgpu::BindingResource::TextureView(&opaque_view);
                Some(bind(gpu, &surfaces, &[whole(&params), whole(&no_alpha), view]))
            }
        };
        let stage = Stage {
            path: "opacity-maps/opaque.wgsl",
            entry: "opaque",
            constants: &[],
            pass: None,
            targets: &[],
            depth: Some(depth_state(wgpu::CompareFunction::Less, true)),
            swapped: false,
            opaque_joins: false,
        };
        let opaque_pipeline = pipeline(gpu, &own, &stage, "place")?;
        Ok(Self {
            width,
            height,
            vertices: gpu.upload("light-space vertices", &mesh.vertices)?,
            indices: gpu.upload("light-space indices", &mesh.indices)?,
            opaque: opaque_draws,
            translucent,
            cover,
            surfaces,
            opaque_pipeline,
            opaque_map,
            opaque_view,
        })
    }

    /// The pipelines of a stage.
    pub fn pipelines(&self, gpu: &Gpu, stage: &Stage<'_>) -> Result<Pipelines, GpuError> {
        let vertex = if stage.swapped { "place_swapped" } else { "place" };
        let mesh = pipeline(gpu, &self.surfaces, stage, vertex)?;
        let cover = (stage.opaque_joins && self.cover.is_some())
            .then(|| pipeline(gpu, &self.surfaces, stage, "cover"))
            .transpose()?;
        Ok(Pipelines { mesh, cover })
    }

    /// Records the pass "opaque": the nearest opaque depth of each texel.
    pub fn record_opaque(&self, frame: &mut Frame<'_>) {
        let depth = Targets::cleared_depth(&self.opaque_view, 1.0);
        frame.raster("opaque", Targets { depth, ..Targets::default() }, |pass| {
            pass.set_pipeline(&self.opaque_pipeline);
            self.draw_all(pass, &self.opaque);
        });
    }

    /// Draws what takes part in the opacity maps.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipelines: &Pipelines,
        group: &wgpu::BindGroup,
    ) {
        pass.set_pipeline(&pipelines.mesh);
        pass.set_bind_group(1, group, &[]);
        self.draw_all(pass, &self.translucent);
        if let (Some(cover), Some(surface)) = (&pipelines.cover, &self.cover) {
            pass.set_pipeline(cover);
            pass.set_bind_group(0, surface, &[]);
            pass.set_bind_group(1, group, &[]);
            pass.draw(0..3, 0..1);
        }
    }

    /// A pass without targets of its own: the opaque map is attached, and left as it is.
    pub fn no_targets(&self) -> Targets<'_> {
        Targets {
            depth: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.opaque_view,
                depth_ops: None,
                stencil_ops: None,
            }),
            ..Targets::default()
        }
    }

    /// Nearest opaque depths, 1 where there is none.
    pub fn opaque_view(&self) -> &wgpu::TextureView {
        &self.opaque_view
    }

    /// The same as a texture.
    pub fn opaque_map(&self) -> &wgpu::Texture {
        &self.opaque_map
    }

    /// Bytes of the opaque map.
    pub fn opaque_bytes(&self) -> u64 {
        4 * u64::from(self.width) * u64::from(self.height)
    }

    /// Bytes of mesh and opaque map.
    pub fn bytes(&self) -> u64 {
        self.opaque_bytes() + self.vertices.size() + self.indices.size()
    }

    fn draw_all(&self, pass: &mut wgpu::RenderPass<'_>, draws: &[Draw]) {
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        for draw in draws {
            pass.set_bind_group(0, &draw.group, &[]);
            pass.draw_indexed(draw.indices.clone(), 0, 0..1);
        }
    }
}

/// A depth texture that passes can draw to, read, and copy.
pub(super) fn depth_texture(
    gpu: &Gpu,
    label: &str,
    width: u32,
    height: u32,
) -> Result<wgpu::Texture, GpuError> {
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT
        | wgpu::TextureUsages::TEXTURE_BINDING
        | wgpu::TextureUsages::COPY_SRC;
    gpu.texture(label, width, height, wgpu::TextureFormat::Depth32Float, usage)
}

fn surface(mesh: &LightSpaceMesh, group: &TriangleGroup, model: Model) -> SurfaceParams {
    let omega = model.omega(f64::from(group.opacity)) as f32;
    match group.alpha {
        None => SurfaceParams::of(omega, 0),
        Some((texture, cutoff)) => {
            let texture = &mesh.textures[texture as usize];
            SurfaceParams {
                cutoff,
                alpha_width: texture.width,
                alpha_height: texture.height,
                ..SurfaceParams::of(omega, ALPHA_TESTED)
            }
        }
    }
}

fn pipeline(
    gpu: &Gpu,
    surfaces: &wgpu::BindGroupLayout,
    stage: &Stage<'_>,
    vertex: &str,
) -> Result<wgpu::RenderPipeline, GpuError> {
    let place = gpu.module(PLACE)?;
    let module = gpu.module(stage.path)?;
    let mut groups = vec![Some(surfaces)];
    groups.extend(stage.pass.map(Some));
    let pipeline_layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(stage.entry),
        bind_group_layouts: &groups,
        immediate_size: 0,
    });
    let attributes = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32, 2 => Float32x2];
    let mesh = [Some(wgpu::VertexBufferLayout {
        array_stride: size_of::<LightSpaceVertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &attributes,
    })];
    let untouched = || depth_state(wgpu::CompareFunction::Always, false);
    let depth = match &stage.depth {
        None if stage.targets.is_empty() => Some(untouched()),
        depth => depth.clone(),
    };
    gpu.raster(
        &format!("{}:{}", stage.path, stage.entry),
        &wgpu::RenderPipelineDescriptor {
            label: Some(stage.entry),
            layout: Some(&pipeline_layout),
            vertex: wgpu::VertexState {
                module: &place,
                entry_point: Some(vertex),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: if vertex == "cover" { &[] } else { &mesh },
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: depth,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some(stage.entry),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: stage.constants,
                    ..Default::default()
                },
                targets: stage.targets,
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
        crate::gpu::mirror::<SurfaceParams>(
            "opacity-maps/opaque.wgsl",
            "SurfaceParams",
            &[
                ("cutoff", 0),
                ("alpha_width", 4),
                ("alpha_height", 8),
                ("flags", 12),
                ("omega", 16),
                ("opacity", 20),
                ("pad0", 24),
                ("pad1", 28),
            ],
        );
    }
}
