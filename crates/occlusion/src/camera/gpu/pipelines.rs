//! Pipelines, and the layouts of what they are bound to.
//!
//! Group 0 is the scene, group 1 the view with the list of what is drawn (objects, or a batch's
//! boxes), group 2 what counting fragments read and write.

use super::settings::{Counting, Fault};
use super::targets::{COLOURS, DEPTH};
use crate::camera::View;
use bytemuck::{Pod, Zeroable};
use dapple_gpu::bindings::{Slot, layout_of};
use dapple_gpu::{Gpu, GpuError, wgpu};
use wgpu::CompareFunction as Compare;

const DRAW: &str = "occlusion/draw.wgsl";
const BOXES: &str = "occlusion/boxes.wgsl";

/// Mirrors `View` of `common/occlusion_view.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct ViewParams {
    clip: [f32; 16],
    eye: [f32; 3],
    parallel: u32,
    forward: [f32; 3],
    pad: u32,
}

impl ViewParams {
    pub fn of(view: &View) -> Self {
        Self {
            clip: view.clip_f32.to_cols_array(),
            eye: view.eye_f32.into(),
            parallel: u32::from(view.parallel),
            forward: view.forward.as_vec3().into(),
            pad: 0,
        }
    }
}

#[derive(Debug)]
pub(crate) struct Pipelines {
    /// Draws templates without a mask, and with one.
    pub solid: wgpu::RenderPipeline,
    pub masked: wgpu::RenderPipeline,
    /// Rasterises boxes.
    pub boxes: wgpu::RenderPipeline,
    /// Group 1: view, and a list.
    pub list: wgpu::BindGroupLayout,
    /// Group 2: counts and depth.
    pub counts: wgpu::BindGroupLayout,
}

impl Pipelines {
    pub fn new(
        gpu: &Gpu,
        scene: &wgpu::BindGroupLayout,
        counting: Counting,
        fault: Option<Fault>,
    ) -> Result<Self, GpuError> {
        use wgpu::ShaderStages as Stage;
        let both = Stage::VERTEX_FRAGMENT;
        let list = layout_of(gpu, "view", &[(both, Slot::Uniform), (Stage::VERTEX, Slot::Read)]);
        let counts = [(Stage::FRAGMENT, Slot::Write), (Stage::FRAGMENT, Slot::Depth)];
        let counts = layout_of(gpu, "counts", &counts);
        let draw = |fragment| {
            let colours = COLOURS.map(|format| Some(format.into()));
            let stage = Stages { path: DRAW, vertex: "corner", fragment, constants: &[] };
            pipeline(gpu, &stage, &[Some(scene), Some(&list)], &colours, Compare::Greater, true)
        };
        let reversed = fault == Some(Fault::ReversedQuery);
        let boxes = Stages {
            path: BOXES,
            vertex: "face",
            fragment: (counting == Counting::Atomic).then_some("count"),
            constants: &[("reversed", f64::from(u8::from(reversed)))],
        };
        let compare = match (counting, reversed) {
            // Fragments compare depths themselves: those with effects may run before the test.
            (Counting::Atomic, _) => Compare::Always,
            (_, false) => Compare::GreaterEqual,
            (_, true) => Compare::Less,
        };
        let groups = [None, Some(&list), Some(&counts)];
        let groups = if counting == Counting::Atomic { &groups[..] } else { &groups[..2] };
        Ok(Self {
            solid: draw(Some("solid"))?,
            masked: draw(Some("masked"))?,
            boxes: pipeline(gpu, &boxes, groups, &[], compare, false)?,
            list,
            counts,
        })
    }
}

struct Stages<'a> {
    path: &'a str,
    vertex: &'a str,
    fragment: Option<&'a str>,
    /// Of the fragment stage.
    constants: &'a [(&'a str, f64)],
}

fn pipeline(
    gpu: &Gpu,
    stages: &Stages<'_>,
    groups: &[Option<&wgpu::BindGroupLayout>],
    colours: &[Option<wgpu::ColorTargetState>],
    compare: Compare,
    write: bool,
) -> Result<wgpu::RenderPipeline, GpuError> {
    let module = gpu.module(stages.path)?;
    let what = format!("{}:{}", stages.path, stages.fragment.unwrap_or(stages.vertex));
    let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(&what),
        bind_group_layouts: groups,
        immediate_size: 0,
    });
    gpu.raster(
        &what,
        &wgpu::RenderPipelineDescriptor {
            label: Some(&what),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some(stages.vertex),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            // Both sides are seen.
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(write),
                depth_compare: Some(compare),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState::default(),
            fragment: stages.fragment.map(|entry| wgpu::FragmentState {
                module: &module,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: stages.constants,
                    ..Default::default()
                },
                targets: colours,
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
    fn the_view_has_the_layout_of_the_shader() {
        let fields = [("clip", 0), ("eye", 64), ("parallel", 76), ("forward", 80), ("pad", 92)];
        crate::camera::gpu::mirror::<ViewParams>(BOXES, "View", &fields);
    }
}
