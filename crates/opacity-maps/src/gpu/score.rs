//! The passes that score trial maps and adopt the best: nothing leaves the device.
//!
//! Sums are of 32-bit floats in a fixed order (lanes, then parts), correlations about the means of
//! parts, which do not cancel. Scores are those of the processor to about 1e-5 of their size; splits
//! whose scores are nearer than that are ties, and either may be adopted.

use super::{
    OpacityGpuError,
    layered::{LayeredMaps, Maps, no_form, scale},
    raster::Raster,
    tiled::Tiles,
};
use crate::{
    Blend, Criterion, Layered, Packing,
    search::{Precision, Scoring, Steps},
};
use bytemuck::{Pod, Zeroable};
use dapple_gpu::bindings::{bind, whole};
use dapple_gpu::{Frame, Gpu, GpuError, wgpu};

/// Texels of a part: 64 lanes of 16.
const PART: u64 = 1024;

/// Mirrors `ScoreParams` of `common/opacity_score.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct ScoreParams {
    width: u32,
    height: u32,
    layers: u32,
    tile: u32,
    across: u32,
    tiles: u32,
    parts: u32,
    step: u32,
    scale: f32,
    pad: [u32; 3],
}

/// Mirrors `DecideParams` of `opacity-maps/search_decide.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct DecideParams {
    layers: u32,
    tiles: u32,
    parts: u32,
    step: u32,
    values: u32,
    pad: [u32; 3],
}

/// A compute pass with what it reads.
#[derive(Debug)]
struct Dispatch {
    pipeline: wgpu::ComputePipeline,
    workgroups: [u32; 3],
}

impl Dispatch {
    fn record(&self, frame: &mut Frame<'_>, name: &'static str, group: &wgpu::BindGroup) {
        let [x, y, z] = self.workgroups;
        frame.compute(name, |pass| {
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, group, &[]);
            pass.dispatch_workgroups(x, y, z);
        });
    }
}

/// The passes "search-score" and "search-decide".
#[derive(Debug)]
pub(super) struct Score {
    score: Dispatch,
    score_group: wgpu::BindGroup,
    decide: Dispatch,
    /// One a step.
    decide_groups: Vec<wgpu::BindGroup>,
    lambdas: wgpu::Buffer,
    scores: wgpu::Buffer,
    partial_bytes: u64,
    tiles: usize,
    texels: u64,
}

impl Score {
    /// Scores the maps of `trial` in `tiles`, whose best λ go to `splits`.
    pub fn new(
        gpu: &Gpu,
        raster: &Raster,
        (layered, trial): (&Layered, &LayeredMaps),
        scoring: Scoring,
        steps: Steps,
        tiles: Tiles,
        splits: &wgpu::Buffer,
    ) -> Result<Self, OpacityGpuError> {
        let criterion = match scoring.criterion {
            Criterion::Sad => 0,
            Criterion::Correlation => 1,
            Criterion::EqualOpacity => 2,
            Criterion::EqualTransmittance => 3,
            Criterion::MutualInformation => {
                return Err(no_form("a search by mutual information", "histograms are not built"));
            }
            Criterion::Oracle => {
                return Err(no_form("a search by an oracle", "the device does not know the truth"));
            }
        };
        let [width, height] = [raster.width, raster.height];
        // Only whole maps are thinned, as on the processor.
        let whole_map = tiles.all == 1;
        let step = match scoring.side {
            side if side > 0 && whole_map => width.max(height).div_ceil(side),
            _ => 1,
        };
        let looked_at = |size: u32| u64::from(size.min(tiles.side).div_ceil(step));
        let parts = (looked_at(width) * looked_at(height)).div_ceil(PART);
        let groups = u64::from(tiles.all) * parts;
        let moments = scoring.criterion == Criterion::Correlation;
        let numbers = if moments { 1 + 3 * u64::from(layered.layers) } else { 1 };
        let (parts_u32, groups_u32) = (parts as u32, u32::try_from(groups));
        if groups_u32.is_err() {
            let what = "parts of tiles";
            return Err(OpacityGpuError::too_large(what, groups, "u32", u32::MAX.into()));
        }
        let partials = gpu.buffer("partial scores", 4 * groups * numbers)?;
        let values = steps.values();
        let scores = gpu.buffer("scores", 4 * u64::from(tiles.all) * u64::from(values))?;
        let lambdas: Vec<f32> = (0..values).map(|step| steps.lambda(step)).collect();
        let lambdas = gpu.upload("splits on trial", &lambdas)?;

        let flag = |on: bool| f64::from(u8::from(on));
        let mut constants = vec![
            ("CRITERION", f64::from(criterion)),
            ("BYTES", flag(scoring.precision == Precision::Bytes)),
            ("MASKED", flag(scoring.mask)),
            ("OPACITIES", flag(layered.blend != Blend::Add)),
        ];
        let (path, maps) = match trial.maps() {
            Maps::Blended(maps) => {
                constants.push(("SINGLE", flag(layered.packing == Packing::Single)));
                let view = wgpu::BindingResource::TextureView(maps.view());
                ("opacity-maps/search_targets.wgsl", view)
            }
            Maps::Bins(bins) => ("opacity-maps/search_bins.wgsl", whole(bins.sums())),
        };
        let params = ScoreParams {
            width,
            height,
            layers: layered.layers,
            tile: tiles.side,
            across: tiles.across,
            tiles: tiles.all,
            parts: parts_u32,
            step,
            scale: scale(layered),
            pad: [0; 3],
        };
        let params = gpu.uniform("score", &params)?;
        let score = Dispatch {
            pipeline: gpu.compute(path, "score", &constants)?,
            workgroups: gpu.workgroups(groups, 1)?,
        };
        let score_layout = score.pipeline.get_bind_group_layout(0);
        let score_group = bind(gpu, &score_layout, &[whole(&params), whole(&partials), maps]);

        let greatest = scoring.criterion == Criterion::Sad;
        let constants = [("MOMENTS", flag(moments)), ("GREATEST", flag(greatest))];
        let decide = Dispatch {
            pipeline: gpu.compute("opacity-maps/search_decide.wgsl", "decide", &constants)?,
            workgroups: gpu.workgroups(tiles.all.into(), 1)?,
        };
        let mut decide_groups = Vec::new();
        for step in 0..values {
            let (layers, tiles, parts) = (layered.layers, tiles.all, parts_u32);
            let params = DecideParams { layers, tiles, parts, step, values, pad: [0; 3] };
            let params = gpu.uniform("decision", &params)?;
            let buffers = [&params, &partials, &scores, &lambdas, splits];
            decide_groups.push(gpu.bind(&decide.pipeline, 0, &buffers));
        }
        Ok(Self {
            score,
            score_group,
            decide,
            decide_groups,
            lambdas,
            scores,
            partial_bytes: partials.size(),
            tiles: tiles.all as usize,
            texels: u64::from(width.div_ceil(step)) * u64::from(height.div_ceil(step)),
        })
    }

    /// Records "search-step": the λ of `step` becomes that of the trial maps.
    pub fn record_step(&self, frame: &mut Frame<'_>, step: u32, trial: &LayeredMaps) {
        frame.copies("search-step", |encoder| {
            let from = 4 * u64::from(step);
            encoder.copy_buffer_to_buffer(&self.lambdas, from, trial.table(), 0, 4);
        });
    }

    /// Records "search-score" and "search-decide" for the maps of `step`; the last step's adopts.
    pub fn record(&self, frame: &mut Frame<'_>, step: u32) {
        self.score.record(frame, "search-score", &self.score_group);
        // There is a group for every step of a search.
        if let Some(group) = self.decide_groups.get(step as usize) {
            self.decide.record(frame, "search-decide", group);
        }
    }

    /// Texels that a scored frame looks at.
    pub fn texels(&self) -> u64 {
        self.texels
    }

    /// Bytes of scores, whole and partial.
    pub fn bytes(&self) -> u64 {
        self.partial_bytes + self.scores.size() + self.lambdas.size()
    }

    /// Scores of the last search, step after step, of every tile.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<Vec<f32>>, GpuError> {
        let scores: Vec<f32> = gpu.read(&self.scores, 0, self.decide_groups.len() * self.tiles)?;
        Ok(scores.chunks_exact(self.tiles).map(<[f32]>::to_vec).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniforms_have_the_layout_of_the_shaders() {
        for path in ["opacity-maps/search_targets.wgsl", "opacity-maps/search_bins.wgsl"] {
            let fields = [
                ("width", 0),
                ("height", 4),
                ("layers", 8),
                ("tile", 12),
                ("across", 16),
                ("tiles", 20),
                ("parts", 24),
                ("step", 28),
                ("scale", 32),
                ("pad0", 36),
                ("pad1", 40),
                ("pad2", 44),
            ];
            crate::gpu::mirror::<ScoreParams>(path, "ScoreParams", &fields);
        }
        let fields = [
            ("layers", 0),
            ("tiles", 4),
            ("parts", 8),
            ("step", 12),
            ("values", 16),
            ("pad0", 20),
            ("pad1", 24),
            ("pad2", 28),
        ];
        let path = "opacity-maps/search_decide.wgsl";
        crate::gpu::mirror::<DecideParams>(path, "DecideParams", &fields);
    }
}
