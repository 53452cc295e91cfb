//! The light's triangles on the device, and the one way in which every pass over them is drawn.
//!
//! Group 0 of every pipeline belongs to the surfaces (alpha test, thickness, opaque map), group 1
//! to the pass. Translucent passes read the opaque map in the fragment shader instead of testing
//! depths: what lies at or behind the nearest opaque surface is dropped.

use super::{
    OpacityGpuError,
    stage::{COVER, Pipelines, Stage, depth_state, depth_texture, pipeline},
};
use crate::{Model, OpacityError, Opaque};
use bytemuck::{Pod, Zeroable};
use dapple_gpu::bindings::{Slot, bind, layout, whole};
use dapple_gpu::light_space::{LightSpaceMesh, TriangleGroup};
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

#[derive(Debug)]
struct Draw {
    indices: std::ops::Range<u32>,
    group: wgpu::BindGroup,
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
            .then(|| pipeline(gpu, &self.surfaces, stage, COVER))
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
