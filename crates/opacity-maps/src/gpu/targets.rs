//! Stored numbers by the blending unit: an array of textures of four channels, up to eight of them
//! a pass.

use super::{
    OpacityGpuError,
    raster::Raster,
    stage::{Pipelines, Stage, depth_state, depth_texture},
};
use crate::Format;
use dapple_gpu::{Frame, Gpu, GpuError, Targets, wgpu};

/// Most textures of a pass.
pub(super) const MOST_TARGETS: u32 = 8;

/// What a technique stores in textures, and how it is drawn.
pub(super) struct Target<'a> {
    /// Shader file; its `override` TARGETS is the number of textures of the pass.
    pub path: &'a str,
    /// Entry point of the fragment stage.
    pub entry: &'a str,
    /// Its other `override`s.
    pub constants: &'a [(&'a str, f64)],
    /// Layout of group 1.
    pub slots: &'a wgpu::BindGroupLayout,
    /// Textures of the array.
    pub textures: u32,
    /// Textures of a pass.
    pub per_pass: u32,
    pub texel: Texel,
    pub blend: wgpu::BlendState,
    /// What every channel starts from.
    pub clear: f64,
    /// A depth test that must not be there: a deliberate fault.
    pub depth_tested: bool,
}

/// Four channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Texel {
    pub format: wgpu::TextureFormat,
    pub bytes: u32,
}

/// The texel of a format, `None` for fixed point, which the blending unit has not got.
pub(super) fn texel(format: Format) -> Option<Texel> {
    use wgpu::TextureFormat::{Rgba8Unorm, Rgba16Float, Rgba32Float};
    let (format, bytes) = match format {
        Format::F32 => (Rgba32Float, 16),
        Format::F16 => (Rgba16Float, 8),
        Format::Unorm8 | Format::Unorm8Scaled => (Rgba8Unorm, 4),
        Format::Fixed => return None,
    };
    Some(Texel { format, bytes })
}

#[derive(Debug)]
struct Pass {
    views: Vec<wgpu::TextureView>,
    group: wgpu::BindGroup,
    pipelines: usize,
}

/// The textures with the passes that fill them.
#[derive(Debug)]
pub(super) struct TargetMaps {
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    texel: Texel,
    clear: wgpu::Color,
    passes: Vec<Pass>,
    /// Of passes with as many textures as fit, and of the last.
    pipelines: Vec<Pipelines>,
    tested: Option<wgpu::TextureView>,
}

impl TargetMaps {
    /// Makes textures and passes; `group` binds what the pass over some of the textures reads.
    pub fn new(
        gpu: &Gpu,
        raster: &Raster,
        target: &Target<'_>,
        mut group: impl FnMut(std::ops::Range<u32>) -> Result<wgpu::BindGroup, GpuError>,
    ) -> Result<Self, OpacityGpuError> {
        check_limits(gpu, target)?;
        if target.texel.format == wgpu::TextureFormat::Rgba32Float {
            need_blendable(gpu, "blending in 32-bit floats")?;
        }
        let texture = texture_array(gpu, raster, target)?;
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        let mut pipelines = vec![make_pipelines(gpu, raster, target, target.per_pass)?];
        let last = target.textures % target.per_pass;
        if last != 0 {
            pipelines.push(make_pipelines(gpu, raster, target, last)?);
        }
        let one = |index: u32| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer: index,
                array_layer_count: Some(1),
                ..Default::default()
            })
        };
        let mut passes = Vec::new();
        for start in (0..target.textures).step_by(target.per_pass as usize) {
            let textures = start..(start + target.per_pass).min(target.textures);
            let full = textures.len() as u32 == target.per_pass;
            let views = textures.clone().map(one).collect();
            passes.push(Pass { views, group: group(textures)?, pipelines: usize::from(!full) });
        }
        let tested = match target.depth_tested {
            false => None,
            true => {
                let label = "depth test of the opacity pass";
                let texture = depth_texture(gpu, label, raster.width, raster.height)?;
                Some(texture.create_view(&wgpu::TextureViewDescriptor::default()))
            }
        };
        let c = target.clear;
        let clear = wgpu::Color { r: c, g: c, b: c, a: c };
        Ok(Self { texture, view, texel: target.texel, clear, passes, pipelines, tested })
    }

    /// Records the passes, each as `name`.
    pub fn record(&self, frame: &mut Frame<'_>, raster: &Raster, name: &'static str) {
        for pass in &self.passes {
            let mut colour = [const { None }; MOST_TARGETS as usize];
            for (slot, view) in colour.iter_mut().zip(&pass.views) {
                *slot = Targets::cleared(view, self.clear);
            }
            let targets = Targets {
                colour: &colour[..pass.views.len()],
                depth: self.tested.as_ref().and_then(|view| Targets::cleared_depth(view, 1.0)),
                ..Targets::default()
            };
            frame.raster(name, targets, |render| {
                raster.draw(render, &self.pipelines[pass.pipelines], &pass.group);
            });
        }
    }

    /// All textures.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.view
    }

    /// Passes over the geometry.
    pub fn passes(&self) -> u64 {
        self.passes.len() as u64
    }

    /// Textures of the array.
    pub fn textures(&self) -> u32 {
        self.texture.depth_or_array_layers()
    }

    /// Bytes of a texel of one texture.
    pub fn texel_bytes(&self) -> u64 {
        self.texel.bytes.into()
    }

    /// Bytes of all textures.
    pub fn bytes(&self) -> u64 {
        let texels = u64::from(self.texture.width()) * u64::from(self.texture.height());
        texels * u64::from(self.textures()) * self.texel_bytes()
    }

    /// The first `channels` channels of every texture, one map after the other.
    pub fn read_channels(&self, gpu: &Gpu, channels: usize) -> Result<Vec<Vec<f32>>, GpuError> {
        let mut maps = Vec::new();
        for index in 0..self.textures() {
            let texels = self.read(gpu, index)?;
            let channel = |c| texels.iter().copied().skip(c).step_by(4).collect();
            maps.extend((0..channels).map(channel));
        }
        Ok(maps)
    }

    /// The four channels of a texture, texel after texel.
    fn read(&self, gpu: &Gpu, index: u32) -> Result<Vec<f32>, GpuError> {
        let bytes = gpu.read_texture_layer(&self.texture, index)?;
        Ok(match self.texel.format {
            wgpu::TextureFormat::Rgba16Float => {
                let halves: Vec<half::f16> = bytemuck::pod_collect_to_vec(&bytes);
                halves.into_iter().map(half::f16::to_f32).collect()
            }
            wgpu::TextureFormat::Rgba8Unorm => {
                bytes.iter().map(|&byte| f32::from(byte) / 255.0).collect()
            }
            _ => bytemuck::pod_collect_to_vec(&bytes),
        })
    }
}

/// Refuses 32-bit blending where the device has not got it.
pub(super) fn need_blendable(gpu: &Gpu, what: &str) -> Result<(), GpuError> {
    if gpu.device.features().contains(wgpu::Features::FLOAT32_BLENDABLE) {
        Ok(())
    } else {
        Err(GpuError::Missing { what: what.into(), feature: "FLOAT32_BLENDABLE" })
    }
}

/// Source and destination factors of colour and alpha, added.
pub(super) fn blend_state(
    color: (wgpu::BlendFactor, wgpu::BlendFactor),
    alpha: (wgpu::BlendFactor, wgpu::BlendFactor),
    operation: wgpu::BlendOperation,
) -> wgpu::BlendState {
    let state =
        |(src_factor, dst_factor)| wgpu::BlendComponent { src_factor, dst_factor, operation };
    wgpu::BlendState { color: state(color), alpha: state(alpha) }
}

fn make_pipelines(
    gpu: &Gpu,
    raster: &Raster,
    target: &Target<'_>,
    count: u32,
) -> Result<Pipelines, GpuError> {
    let state = wgpu::ColorTargetState {
        format: target.texel.format,
        blend: Some(target.blend),
        write_mask: wgpu::ColorWrites::ALL,
    };
    let mut constants = target.constants.to_vec();
    constants.push(("TARGETS", f64::from(count)));
    let stage = Stage {
        path: target.path,
        entry: target.entry,
        constants: &constants,
        pass: Some(target.slots),
        targets: &vec![Some(state); count as usize],
        depth: target.depth_tested.then(|| depth_state(wgpu::CompareFunction::Less, true)),
        swapped: false,
        opaque_joins: true,
    };
    raster.pipelines(gpu, &stage)
}

fn check_limits(gpu: &Gpu, target: &Target<'_>) -> Result<(), OpacityGpuError> {
    let limits = gpu.limits();
    let bytes = "max_color_attachment_bytes_per_sample";
    let passes = target.textures.div_ceil(target.per_pass);
    let checks = [
        ("max_color_attachments", target.per_pass, limits.max_color_attachments),
        (bytes, target.per_pass * target.texel.bytes, limits.max_color_attachment_bytes_per_sample),
        ("max_texture_array_layers", target.textures, limits.max_texture_array_layers),
        // Some are left for the bounds, the opaque map and shading.
        ("MAX_PASSES", passes + 16, dapple_gpu::MAX_PASSES),
    ];
    for (limit, asked, max) in checks {
        if asked > max {
            let error = OpacityGpuError::too_large("opacity maps", asked.into(), limit, max.into());
            return Err(error);
        }
    }
    Ok(())
}

fn texture_array(
    gpu: &Gpu,
    raster: &Raster,
    target: &Target<'_>,
) -> Result<wgpu::Texture, GpuError> {
    gpu.scoped("texture `opacity maps`", || {
        gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("opacity maps"),
            size: wgpu::Extent3d {
                width: raster.width,
                height: raster.height,
                depth_or_array_layers: target.textures,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: target.texel.format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    })
}
