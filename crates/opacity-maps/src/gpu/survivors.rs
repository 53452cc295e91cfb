//! Stochastic shadow maps: the nearest survivors of each texel, by atomic maxima in one pass.

use super::{
    OpacityGpuError,
    raster::Raster,
    shade::Decoder,
    stage::{Pipelines, Stage},
    technique::Cost,
};
use crate::{Stochastic, taps::hash};
use bytemuck::{Pod, Zeroable};
use dapple_gpu::bindings::{Slot, bind, layout, whole};
use dapple_gpu::{Frame, Gpu, GpuError, wgpu};

/// Mirrors `SurvivorParams` of `opacity-maps/survivors.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct SurvivorParams {
    samples: u32,
    seed: u32,
    width: u32,
    pad: u32,
}

/// Bits of the depth that nothing survived at, 2; survivors are stored as what they lack of it.
const NOTHING: u32 = 0x4000_0000;

/// The samples of each texel, side by side.
#[derive(Debug)]
pub(super) struct Survivors {
    samples: u32,
    texels: u64,
    words: wgpu::Buffer,
    pipelines: Pipelines,
    group: wgpu::BindGroup,
}

impl Survivors {
    /// Allocates the samples.
    pub fn new(gpu: &Gpu, raster: &Raster, code: Stochastic) -> Result<Self, OpacityGpuError> {
        let texels = u64::from(raster.width) * u64::from(raster.height);
        let words = gpu.buffer("survivors", 4 * texels * u64::from(code.samples))?;
        let (samples, seed) = (code.samples, hash(code.seed));
        let params = SurvivorParams { samples, seed, width: raster.width, pad: 0 };
        let slots = layout(gpu, "survivors", &[Slot::Uniform, Slot::Write]);
        let params = gpu.uniform("survivors", &params)?;
        let group = bind(gpu, &slots, &[whole(&params), whole(&words)]);
        let stage = Stage {
            path: "opacity-maps/survivors.wgsl",
            entry: "keep",
            constants: &[],
            pass: Some(&slots),
            targets: &[],
            depth: None,
            swapped: false,
            opaque_joins: true,
        };
        let pipelines = raster.pipelines(gpu, &stage)?;
        Ok(Self { samples, texels, words, pipelines, group })
    }

    /// Records "opacity-clear" and "opacity".
    pub fn record(&self, frame: &mut Frame<'_>, raster: &Raster) {
        frame.copies("opacity-clear", |encoder| encoder.clear_buffer(&self.words, 0, None));
        let targets = raster.no_targets();
        frame.raster("opacity", targets, |pass| raster.draw(pass, &self.pipelines, &self.group));
    }

    /// Hands what shading needs to `make`.
    pub fn with_decoder<R>(&self, make: impl FnOnce(&Decoder<'_>) -> R) -> R {
        let path = "opacity-maps/shade_survivors.wgsl";
        let constants = [("SAMPLES", f64::from(self.samples))];
        make(&Decoder { path, constants: &constants, resources: &[whole(&self.words)] })
    }

    /// What it costs; a fragment writes each sample at most.
    pub fn cost(&self, taps: u64) -> Cost {
        let samples = u64::from(self.samples);
        Cost {
            geometry_passes: 1,
            map_bytes: 4 * self.texels * samples,
            other_bytes: 0,
            bytes_per_fragment: 4 * samples,
            fetches: taps * samples,
        }
    }

    /// Depth of each sample, 2 where nothing survived, one map a sample.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<Vec<f32>>, GpuError> {
        let samples = self.samples as usize;
        let words: Vec<u32> = gpu.read(&self.words, 0, self.texels as usize * samples)?;
        let depth = |&word: &u32| f32::from_bits(NOTHING.saturating_sub(word));
        let map = |sample| words.iter().skip(sample).step_by(samples).map(depth).collect();
        Ok((0..samples).map(map).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_has_the_layout_of_the_shader() {
        crate::gpu::mirror::<SurvivorParams>(
            "opacity-maps/survivors.wgsl",
            "SurvivorParams",
            &[("samples", 0), ("seed", 4), ("width", 8), ("pad0", 12)],
        );
        assert_eq!(f32::from_bits(NOTHING), crate::NO_OPAQUE);
    }
}
