//! The pass that shades: one receiver an invocation, whatever the technique.

use super::OpacityGpuError;
use crate::{Blur, Opaque, Receiver, Settings, Taps};
use bytemuck::{Pod, Zeroable};
use dapple_gpu::bindings::{bind, whole};
use dapple_gpu::{Frame, Gpu, GpuError, wgpu};

/// Mirrors `ShadeParams` of `common/opacity_taps.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct ShadeParams {
    receivers: u32,
    width: u32,
    height: u32,
    pattern: u32,
    stored: u32,
    separate: u32,
    bias: f32,
    pad: u32,
}

/// What a technique adds to the pass.
pub(super) struct Decoder<'a> {
    /// Shader file; its entry point is `shade`.
    pub path: &'a str,
    /// Its `override`s.
    pub constants: &'a [(&'a str, f64)],
    /// Bindings 4.. of group 0.
    pub resources: &'a [wgpu::BindingResource<'a>],
}

/// The pass "shade".
#[derive(Debug)]
pub(super) struct Shade {
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    workgroups: [u32; 3],
    transmittances: wgpu::Buffer,
    receivers: usize,
}

impl Shade {
    /// Uploads the receivers.
    pub fn new(
        gpu: &Gpu,
        receivers: &[Receiver],
        settings: &Settings,
        [width, height]: [u32; 2],
        opaque_view: &wgpu::TextureView,
        decoder: &Decoder<'_>,
    ) -> Result<Self, OpacityGpuError> {
        let count = u32::try_from(receivers.len()).map_err(|_| {
            let asked = receivers.len() as u64;
            OpacityGpuError::too_large("receivers", asked, "u32 indices", u32::MAX.into())
        })?;
        let params = ShadeParams {
            receivers: count,
            width,
            height,
            pattern: match settings.taps {
                Taps::One => 0,
                Taps::Box3 => 1,
                Taps::Box4 => 2,
                Taps::Stochastic16 => 3,
            },
            stored: u32::from(settings.blur == Blur::Stored),
            separate: u32::from(settings.opaque == Opaque::Separate),
            bias: settings.bias,
            pad: 0,
        };
        // Shading languages may assume that no number is NaN: those are dealt with here. A binding
        // holds one receiver at least; the shader reads as many as there are.
        let mut clean: Vec<Receiver> = receivers.iter().map(cleaned).collect();
        if clean.is_empty() {
            clean.push(Receiver { flags: 0, ..Receiver::at(0.0, 0.0, 0.0) });
        }
        let pipeline = gpu.compute(decoder.path, "shade", decoder.constants)?;
        let transmittances = gpu.buffer("transmittances", 4 * u64::from(count))?;
        let (params, clean) = (gpu.uniform("shade", &params)?, gpu.upload("receivers", &clean)?);
        let mut resources = vec![
            whole(&params),
            whole(&clean),
            whole(&transmittances),
            wgpu::BindingResource::TextureView(opaque_view),
        ];
        resources.extend_from_slice(decoder.resources);
        let group = bind(gpu, &pipeline.get_bind_group_layout(0), &resources);
        let workgroups = gpu.workgroups(u64::from(count), 64)?;
        Ok(Self { pipeline, group, workgroups, transmittances, receivers: receivers.len() })
    }

    /// Records the pass "shade".
    pub fn record(&self, frame: &mut Frame<'_>) {
        let [x, y, z] = self.workgroups;
        frame.compute("shade", |pass| {
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &self.group, &[]);
            pass.dispatch_workgroups(x, y, z);
        });
    }

    /// Transmittances of the last frame.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<f32>, GpuError> {
        gpu.read(&self.transmittances, 0, self.receivers)
    }

    /// Bytes of receivers and results.
    pub fn bytes(&self) -> u64 {
        (self.receivers * (size_of::<Receiver>() + 4)) as u64
    }
}

/// A receiver without numbers that are none: it is not there where it is not in the map.
fn cleaned(receiver: &Receiver) -> Receiver {
    let slope = |s: f32| if s.is_finite() { s } else { 0.0 };
    if receiver.in_map() {
        let (slope_u, slope_v) = (slope(receiver.slope_u), slope(receiver.slope_v));
        Receiver { slope_u, slope_v, ..*receiver }
    } else {
        Receiver { flags: 0, ..Receiver::at(0.0, 0.0, 0.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn structs_have_the_layout_of_the_shader() {
        crate::gpu::mirror::<ShadeParams>(
            "opacity-maps/shade_lit.wgsl",
            "ShadeParams",
            &[
                ("receivers", 0),
                ("width", 4),
                ("height", 8),
                ("pattern", 12),
                ("stored", 16),
                ("separate", 20),
                ("bias", 24),
                ("pad0", 28),
            ],
        );
        crate::gpu::mirror::<Receiver>(
            "opacity-maps/shade_lit.wgsl",
            "Receiver",
            &[("u", 0), ("v", 4), ("depth", 8), ("slope_u", 12), ("slope_v", 16), ("flags", 20)],
        );
    }

    #[test]
    fn receivers_that_are_not_in_the_map_are_not_there() {
        let good = Receiver { slope_u: f32::NAN, ..Receiver::at(1.0, 0.0, 0.5) };
        assert_eq!(cleaned(&good), Receiver::at(1.0, 0.0, 0.5));
        for bad in [Receiver::at(f32::NAN, 0.5, 0.5), Receiver::at(0.5, 0.5, f32::INFINITY)] {
            assert_eq!(cleaned(&bad).flags, 0);
        }
    }
}
