//! Textures to draw to or sample, and their read-back.

use crate::{Gpu, GpuError};

impl Gpu {
    /// A 2-D texture of one mip level with `usage`.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] naming the limit, [`GpuError::Validation`] for a size of 0 or a
    /// usage that the format has not got, [`GpuError::OutOfMemory`].
    pub fn texture(
        &self,
        label: &str,
        width: u32,
        height: u32,
        format: wgpu::TextureFormat,
        usage: wgpu::TextureUsages,
    ) -> Result<wgpu::Texture, GpuError> {
        self.texture_array(label, width, height, 1, format, usage)
    }

    /// The same with `layers` layers.
    ///
    /// # Errors
    /// As [`Gpu::texture`].
    pub fn texture_array(
        &self,
        label: &str,
        width: u32,
        height: u32,
        layers: u32,
        format: wgpu::TextureFormat,
        usage: wgpu::TextureUsages,
    ) -> Result<wgpu::Texture, GpuError> {
        let what = format!("texture `{label}`");
        let max = self.limits().max_texture_dimension_2d;
        if width.max(height) > max {
            return Err(GpuError::TooLarge {
                what,
                asked: width.max(height).into(),
                limit: "max_texture_dimension_2d",
                max: max.into(),
            });
        }
        let max = self.limits().max_texture_array_layers;
        if layers > max {
            return Err(GpuError::TooLarge {
                what,
                asked: layers.into(),
                limit: "max_texture_array_layers",
                max: max.into(),
            });
        }
        self.scoped(&what, || {
            self.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        })
    }

    /// The texels of a 2-D texture, row by row from the top without padding, as raw bytes.
    ///
    /// # Errors
    /// [`GpuError::Validation`] for a format that cannot be copied, and as [`Gpu::read`].
    pub fn read_texture(&self, texture: &wgpu::Texture) -> Result<Vec<u8>, GpuError> {
        self.read_texture_layer(texture, 0)
    }

    /// The same of one layer of an array.
    ///
    /// # Errors
    /// As [`Gpu::read_texture`]; [`GpuError::Validation`] for a layer that is not there.
    pub fn read_texture_layer(
        &self,
        texture: &wgpu::Texture,
        layer: u32,
    ) -> Result<Vec<u8>, GpuError> {
        let aspect = wgpu::TextureAspect::All;
        let texel =
            texture.format().block_copy_size(Some(aspect)).ok_or_else(|| GpuError::Validation {
                what: "texture read-back".into(),
                message: format!("{:?} cannot be copied", texture.format()),
            })?;
        let (width, height) = (texture.width(), texture.height());
        let row = width * texel;
        let stride = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let bytes = u64::from(stride) * u64::from(height);
        let staging = self.create("texture read-back", bytes, usage, false)?;
        let submission = self.scoped("texture read-back", || {
            let mut encoder = self.device.create_command_encoder(&Default::default());
            encoder.copy_texture_to_buffer(
                wgpu::TexelCopyTextureInfo {
                    origin: wgpu::Origin3d { x: 0, y: 0, z: layer },
                    ..texture.as_image_copy()
                },
                wgpu::TexelCopyBufferInfo {
                    buffer: &staging,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(stride),
                        rows_per_image: None,
                    },
                },
                wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            );
            self.queue.submit([encoder.finish()])
        })?;
        self.read_mapped(&staging, submission, |mapped| {
            mapped
                .chunks_exact(stride as usize)
                .take(height as usize)
                .flat_map(|line| &line[..row as usize])
                .copied()
                .collect()
        })
    }

    /// The texels of a texture of one 32-bit float a texel (`R32Float`, `Depth32Float`).
    ///
    /// # Errors
    /// [`GpuError::Validation`] for another format, and as [`Gpu::read`].
    pub fn read_f32(&self, texture: &wgpu::Texture) -> Result<Vec<f32>, GpuError> {
        use wgpu::TextureFormat::{Depth32Float, R32Float};
        if !matches!(texture.format(), R32Float | Depth32Float) {
            return Err(GpuError::Validation {
                what: "texture read-back as f32".into(),
                message: format!("the texture is {:?}", texture.format()),
            });
        }
        Ok(bytemuck::pod_collect_to_vec(&self.read_texture(texture)?))
    }
}
