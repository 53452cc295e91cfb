//! The G-buffer.

use crate::OcclusionError;
use crate::camera::Image;
use dapple_gpu::{Gpu, GpuError, wgpu};
use wgpu::TextureFormat as Format;

/// Formats of the colour targets, in the order of the shader's locations: ids, normal, albedo.
pub(super) const COLOURS: [Format; 3] =
    [Format::Rg32Uint, Format::Rgba16Float, Format::Rgba8UnormSrgb];
/// Format of the depth target.
pub(super) const DEPTH: Format = Format::Depth32Float;

/// Bytes of a pixel of all targets.
const BYTES_PER_PIXEL: u64 = 8 + 8 + 4 + 4;

/// What the deferred pass keeps of each pixel beside ids and depth, rows top to bottom.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Unit normal towards the camera, local space (to about 1e-3); zero where nothing was drawn.
    pub normals: Vec<[f32; 3]>,
    /// Albedo, 8-bit sRGB; zero where nothing was drawn.
    pub albedo: Vec<[u8; 3]>,
}

/// Targets of one size.
#[derive(Debug)]
pub(crate) struct Targets {
    pub width: u32,
    pub height: u32,
    colour: [wgpu::Texture; 3],
    colour_views: [wgpu::TextureView; 3],
    depth: wgpu::Texture,
    pub depth_view: wgpu::TextureView,
}

impl Targets {
    pub fn new(gpu: &Gpu, width: u32, height: u32) -> Result<Self, OcclusionError> {
        if width == 0 || height == 0 {
            let limit = format!("{width} x {height} pixels, at least one of each");
            return Err(OcclusionError::value("image", limit));
        }
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC;
        let make = |label, format| gpu.texture(label, width, height, format, usage);
        let colour =
            [make("ids", COLOURS[0])?, make("normals", COLOURS[1])?, make("albedo", COLOURS[2])?];
        let depth = make("depth", DEPTH)?;
        Ok(Self {
            width,
            height,
            colour_views: colour.each_ref().map(view),
            depth_view: view(&depth),
            colour,
            depth,
        })
    }

    /// Colour attachments that are cleared or kept.
    pub fn colour(&self, clear: bool) -> [Option<wgpu::RenderPassColorAttachment<'_>>; 3] {
        let load = || match clear {
            true => wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
            false => wgpu::LoadOp::Load,
        };
        self.colour_views.each_ref().map(|view| {
            Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: load(), store: wgpu::StoreOp::Store },
            })
        })
    }

    /// The depth attachment, cleared to infinity or kept.
    pub fn depth(&self, clear: bool) -> wgpu::RenderPassDepthStencilAttachment<'_> {
        let load = if clear { wgpu::LoadOp::Clear(0.0) } else { wgpu::LoadOp::Load };
        wgpu::RenderPassDepthStencilAttachment {
            view: &self.depth_view,
            depth_ops: Some(wgpu::Operations { load, store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        }
    }

    /// The depth attachment, only read.
    pub fn depth_read_only(&self) -> wgpu::RenderPassDepthStencilAttachment<'_> {
        wgpu::RenderPassDepthStencilAttachment {
            view: &self.depth_view,
            depth_ops: None,
            stencil_ops: None,
        }
    }

    pub fn image(&self, gpu: &Gpu) -> Result<Image, GpuError> {
        Ok(Image {
            width: self.width,
            height: self.height,
            ids: bytemuck::pod_collect_to_vec(&gpu.read_texture(&self.colour[0])?),
            depth: gpu.read_f32(&self.depth)?,
        })
    }

    pub fn surface(&self, gpu: &Gpu) -> Result<Surface, GpuError> {
        let halves: Vec<[u16; 4]> =
            bytemuck::pod_collect_to_vec(&gpu.read_texture(&self.colour[1])?);
        let colours: Vec<[u8; 4]> =
            bytemuck::pod_collect_to_vec(&gpu.read_texture(&self.colour[2])?);
        let float = |half: u16| half::f16::from_bits(half).to_f32();
        Ok(Surface {
            normals: halves.iter().map(|n| [n[0], n[1], n[2]].map(float)).collect(),
            albedo: colours.iter().map(|c| [c[0], c[1], c[2]]).collect(),
        })
    }

    pub fn bytes(&self) -> u64 {
        BYTES_PER_PIXEL * u64::from(self.width) * u64::from(self.height)
    }
}

fn view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
