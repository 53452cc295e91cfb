//! Passes over the light's triangles as pipelines.

use dapple_gpu::light_space::LightSpaceVertex;
use dapple_gpu::{Gpu, GpuError, wgpu};

/// Shader of the vertex stages.
const PLACE: &str = "opacity-maps/place.wgsl";

/// The vertex stage that covers the whole map, and takes no vertices.
pub(super) const COVER: &str = "cover";

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
    pub mesh: wgpu::RenderPipeline,
    pub cover: Option<wgpu::RenderPipeline>,
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

/// A stage as a pipeline; `vertex` is the entry point of its vertex stage, `surfaces` the layout of
/// group 0.
pub(super) fn pipeline(
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
                buffers: if vertex == COVER { &[] } else { &mesh },
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
