//! First and last depth of each texel, by five routes that agree.
//!
//! Opacity passes and shading read one texture of (-first, last), empty texels (-1, 0): what MAX
//! blending leaves as it is. The other routes need a further pass that joins what they leave.

use super::{
    OpacityGpuError,
    join::Join,
    raster::Raster,
    stage::{Pipelines, Stage, depth_state, depth_texture},
    targets::{blend_state, need_blendable},
};
use crate::EndMap;
use bytemuck::{Pod, Zeroable};
use dapple_gpu::bindings::{Slot, bind, layout, whole};
use dapple_gpu::{Frame, Gpu, GpuError, Targets, wgpu};

/// Mirrors `BoundsParams` of `opacity-maps/bounds.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct BoundsParams {
    width: u32,
    pad: [u32; 3],
}

/// Shader of the passes that find the ends.
pub(super) const PATH: &str = "opacity-maps/bounds.wgsl";

/// What is bound where there are no bounds.
pub(super) fn none(gpu: &Gpu) -> Result<wgpu::TextureView, GpuError> {
    let usage = wgpu::TextureUsages::TEXTURE_BINDING;
    let texture = gpu.texture("no bounds", 1, 1, wgpu::TextureFormat::R32Float, usage)?;
    Ok(texture.create_view(&wgpu::TextureViewDescriptor::default()))
}

/// Which ends a technique needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ends {
    /// The first alone.
    First,
    /// Both, by a route.
    Both(EndMap),
}

/// Passes over the geometry that find the ends.
pub(super) fn geometry_passes(ends: Ends) -> u64 {
    match ends {
        Ends::First | Ends::Both(EndMap::MaxBlend | EndMap::Atomic) => 1,
        Ends::Both(EndMap::Greater | EndMap::Swapped | EndMap::RangeFlip) => 2,
    }
}

#[derive(Debug)]
enum Route {
    Blend {
        pipelines: Pipelines,
    },
    Atomic {
        pipelines: Pipelines,
        words: wgpu::Buffer,
        join: Join,
    },
    Depths {
        near: Pipelines,
        far: Pipelines,
        views: [wgpu::TextureView; 2],
        clear: f32,
        join: Join,
    },
}

/// The bounds of one map.
#[derive(Debug)]
pub(super) struct Bounds {
    route: Route,
    group: wgpu::BindGroup,
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    bytes: u64,
}

impl Bounds {
    /// Makes everything that the route needs; `opaque_joins` lets the nearest opaque surface
    /// stretch the bounds.
    pub fn new(
        gpu: &Gpu,
        raster: &Raster,
        ends: Ends,
        opaque_joins: bool,
    ) -> Result<Self, OpacityGpuError> {
        let [width, height] = [raster.width, raster.height];
        let texels = u64::from(width) * u64::from(height);
        let end_map = match ends {
            Ends::First => EndMap::MaxBlend,
            Ends::Both(end_map) => end_map,
        };
        let (format, usage) = match end_map {
            EndMap::MaxBlend => {
                need_blendable(gpu, "bounds by MAX blending")?;
                let format = match ends {
                    Ends::First => wgpu::TextureFormat::R32Float,
                    Ends::Both(_) => wgpu::TextureFormat::Rg32Float,
                };
                (format, wgpu::TextureUsages::RENDER_ATTACHMENT)
            }
            _ => (wgpu::TextureFormat::Rg32Float, wgpu::TextureUsages::STORAGE_BINDING),
        };
        let usage = usage | wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC;
        let texture = gpu.texture("bounds", width, height, format, usage)?;
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut bytes = texels * if ends == Ends::First { 4 } else { 8 };

        let slots = layout(gpu, "bounds", &[Slot::Uniform, Slot::Write]);
        let words = if end_map == EndMap::Atomic { 8 * texels } else { 16 };
        let words = gpu.buffer("ends", words)?;
        let params = gpu.uniform("bounds", &BoundsParams { width, pad: [0; 3] })?;
        let group = bind(gpu, &slots, &[whole(&params), whole(&words)]);
        let stage = Stage {
            path: PATH,
            entry: "one_end",
            constants: &[],
            pass: Some(&slots),
            targets: &[],
            depth: None,
            swapped: false,
            opaque_joins,
        };
        let route = match end_map {
            EndMap::MaxBlend => {
                let one = (wgpu::BlendFactor::One, wgpu::BlendFactor::One);
                let target = wgpu::ColorTargetState {
                    format,
                    blend: Some(blend_state(one, one, wgpu::BlendOperation::Max)),
                    write_mask: wgpu::ColorWrites::ALL,
                };
                let targets = [Some(target)];
                let stage = Stage { entry: "both_ends", targets: &targets, ..stage };
                Route::Blend { pipelines: raster.pipelines(gpu, &stage)? }
            }
            EndMap::Atomic => {
                bytes += 8 * texels;
                let stage = Stage { entry: "atomic_ends", ..stage };
                let pipelines = raster.pipelines(gpu, &stage)?;
                let join = Join::of_words(gpu, [width, height], &view, &words)?;
                Route::Atomic { pipelines, words, join }
            }
            EndMap::Greater | EndMap::Swapped | EndMap::RangeFlip => {
                bytes += 8 * texels;
                let less = || Some(depth_state(wgpu::CompareFunction::Less, true));
                let near = raster.pipelines(gpu, &Stage { depth: less(), ..stage })?;
                let far = match end_map {
                    EndMap::Greater => {
                        let depth = Some(depth_state(wgpu::CompareFunction::Greater, true));
                        Stage { depth, ..stage }
                    }
                    EndMap::Swapped => {
                        let constants = &[("SWAPPED", 1.0)];
                        Stage { depth: less(), swapped: true, constants, ..stage }
                    }
                    _ => Stage { depth: less(), constants: &[("REVERSED", 1.0)], ..stage },
                };
                let far = raster.pipelines(gpu, &far)?;
                let mut views = Vec::new();
                for label in ["near map", "far map"] {
                    let texture = depth_texture(gpu, label, width, height)?;
                    views.push(texture.create_view(&wgpu::TextureViewDescriptor::default()));
                }
                let views = [views.swap_remove(0), views.swap_remove(0)];
                let mirrored = end_map != EndMap::Greater;
                let join = Join::of_depths(gpu, [width, height], &view, &views, mirrored)?;
                let clear = if end_map == EndMap::Greater { 0.0 } else { 1.0 };
                Route::Depths { near, far, views, clear, join }
            }
        };
        Ok(Self { route, group, texture, view, bytes })
    }

    /// Records the route's passes: "bounds", and for some "bounds-far" and "bounds-join".
    pub fn record(&self, frame: &mut Frame<'_>, raster: &Raster) {
        match &self.route {
            Route::Blend { pipelines } => {
                let clear = wgpu::Color { r: -1.0, g: 0.0, b: 0.0, a: 0.0 };
                let colour = [Targets::cleared(&self.view, clear)];
                let targets = Targets { colour: &colour, ..Targets::default() };
                frame.raster("bounds", targets, |pass| raster.draw(pass, pipelines, &self.group));
            }
            Route::Atomic { pipelines, words, join } => {
                frame.copies("bounds-clear", |encoder| encoder.clear_buffer(words, 0, None));
                let targets = raster.no_targets();
                frame.raster("bounds", targets, |pass| raster.draw(pass, pipelines, &self.group));
                join.record(frame);
            }
            Route::Depths { near, far, views, clear, join } => {
                let mut draw = |name, view, clear, pipelines| {
                    let depth = Targets::cleared_depth(view, clear);
                    let targets = Targets { depth, ..Targets::default() };
                    frame.raster(name, targets, |pass| raster.draw(pass, pipelines, &self.group));
                };
                draw("bounds", &views[0], 1.0, near);
                draw("bounds-far", &views[1], *clear, far);
                join.record(frame);
            }
        }
    }

    /// (-first, last) of each texel.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.view
    }

    /// Bytes of everything the route keeps.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// (first, last) of each texel, (1, 0) without any; the last is 0 where only the first is kept.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<[f32; 2]>, GpuError> {
        let channels = if self.texture.format() == wgpu::TextureFormat::R32Float { 1 } else { 2 };
        let words: Vec<f32> = bytemuck::pod_collect_to_vec(&gpu.read_texture(&self.texture)?);
        let ends = words.chunks_exact(channels);
        Ok(ends.map(|end| [-end[0], end.get(1).copied().unwrap_or(0.0)]).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_has_the_layout_of_the_shader() {
        crate::gpu::mirror::<BoundsParams>(
            PATH,
            "BoundsParams",
            &[("width", 0), ("pad0", 4), ("pad1", 8), ("pad2", 12)],
        );
    }
}
