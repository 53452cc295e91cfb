//! Layouts and groups of bindings that several pipelines share.

use crate::Gpu;

/// What a binding of a pass is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
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

/// A layout of bindings 0.., each seen by its `stages`.
pub fn layout_of(
    gpu: &Gpu,
    label: &str,
    slots: &[(wgpu::ShaderStages, Slot)],
) -> wgpu::BindGroupLayout {
    let buffer =
        |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    let texture = |sample_type| wgpu::BindingType::Texture {
        sample_type,
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let entries: Vec<_> = (0..)
        .zip(slots)
        .map(|(binding, (stages, slot))| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: *stages,
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

/// A layout of bindings 0.. for fragment shaders.
pub fn layout(gpu: &Gpu, label: &str, slots: &[Slot]) -> wgpu::BindGroupLayout {
    let slots: Vec<_> = slots.iter().map(|slot| (wgpu::ShaderStages::FRAGMENT, *slot)).collect();
    layout_of(gpu, label, &slots)
}

/// A bind group, binding i = the i-th resource.
pub fn bind(
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
pub fn whole(buffer: &wgpu::Buffer) -> wgpu::BindingResource<'_> {
    wgpu::BindingResource::Buffer(wgpu::BufferBinding {
        buffer,
        offset: 0,
        size: std::num::NonZeroU64::new(buffer.size()),
    })
}
