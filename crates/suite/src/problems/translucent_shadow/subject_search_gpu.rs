//! The search for a split on a graphics adapter: trial maps are scored where they are, and nothing is
//! read back before the last frame.

use super::{
    case::TranslucentCase,
    port::{self, Grid},
    subject_gpu::{check_raster, refused},
    subject_search::{self, SETTLED},
};
use crate::{
    SuiteError,
    problem::{Checked, FrameTime, Picture, Setting, Subject},
};
use dapple_gpu::Gpu;
use dapple_opacity_maps::{
    Code, Format, Fragments,
    gpu::{self, SearchRenderer},
    reference::Reference,
    search::{Plan, Search, SplitTexture, criteria::is_better, with_lambda},
    taps::{self, MOST, Tap},
};
use rayon::prelude::*;

/// The renderer with what it is judged by.
pub struct GpuSearchSubject<'a, 'g> {
    case: &'a TranslucentCase<'g>,
    gpu: &'g Gpu,
    plan: Plan,
    grid: Grid,
    renderer: SearchRenderer,
    scored: u64,
    drawn: u64,
}

impl<'a, 'g> GpuSearchSubject<'a, 'g> {
    /// Makes every buffer and pipeline.
    ///
    /// # Errors
    /// Settings that are refused, a criterion that only the processor knows, or a device that is
    /// too small.
    pub fn new(
        case: &'a TranslucentCase<'g>,
        gpu: &'g Gpu,
        setting: &Setting,
    ) -> Result<Self, SuiteError> {
        let (grid, settings) = Grid::asked(case, setting)?;
        let plan = subject_search::plan(setting, settings)?;
        let (mesh, size) = (case.light_mesh(grid.crop), [grid.resolution; 2]);
        let renderer = SearchRenderer::new(gpu, &mesh, grid.model, &grid.receivers, size, &plan)
            .map_err(refused)?;
        Ok(Self { case, gpu, grid, renderer, plan, scored: 0, drawn: 0 })
    }

    /// Holds scores to the processor's on the same fragments, and what is adopted to the scores.
    fn check_search(
        &self,
        rasterised: &Fragments,
        lambdas: &[f32],
        checked: &mut Checked,
    ) -> Result<(), SuiteError> {
        let tiles = self.renderer.read_scores(self.gpu).map_err(refused)?;
        let steps = self.plan.steps;
        let best = |scores: &dyn Fn(usize) -> f64| {
            (1..tiles.len()).fold(0, |best, step| {
                let criterion = self.plan.scoring.criterion;
                if is_better(criterion, scores(step), scores(best)) { step } else { best }
            })
        };
        let wrong = lambdas.iter().enumerate().filter(|(tile, lambda)| {
            **lambda != steps.lambda(best(&|step| f64::from(tiles[step][*tile])) as u32)
        });
        let wrong = wrong.count();
        if wrong > 0 {
            checked.violations.push(format!("{wrong} tiles did not adopt the split scored best"));
        }
        // Of all tiles together.
        let got: Vec<f64> =
            tiles.iter().map(|step| step.iter().map(|s| f64::from(*s)).sum()).collect();
        let mut search = Search::new(rasterised.width, rasterised.height, self.plan.clone())?;
        let mut known = Vec::new();
        while search.is_searching() {
            known.extend(search.frame(rasterised)?.trial.map(|(_, score)| score));
        }
        let scale = known.iter().fold(f64::MIN_POSITIVE, |most, score| most.max(score.abs()));
        let apart = |(a, b): (&f64, &f64)| {
            let apart = (a - b).abs() / scale;
            if apart.is_nan() { f64::INFINITY } else { apart }
        };
        let worst = got.iter().zip(&known).map(apart).fold(0.0, f64::max);
        checked.port_errors.insert("score_max".into(), worst);
        let allowed = tolerance(&self.plan);
        if worst > allowed {
            checked.violations.push(format!(
                "port: scores lie up to {worst:.1e} of the greatest from the processor's \
                 (allowed: {allowed})"
            ));
        }
        if let [lambda] = lambdas {
            let at = (0..known.len()).find(|step| steps.lambda(*step as u32) == *lambda);
            let behind = at.map_or(f64::INFINITY, |at| {
                (known[at] - known[best(&|step| known[step])]).abs() / scale
            });
            checked.port_errors.insert("score_behind".into(), behind);
            if behind > 2.0 * allowed {
                checked.violations.push(format!(
                    "port: the processor scores the adopted split {behind:.1e} worse than the \
                     best (allowed: {})",
                    2.0 * allowed
                ));
            }
        }
        Ok(())
    }

    /// Holds receivers whose texels share a split to the reference at that split.
    fn check_receivers(
        &self,
        rasterised: &Fragments,
        lambdas: &[f32],
        result: &[f32],
        checked: &mut Checked,
    ) -> Result<(), SuiteError> {
        let texture = self.texture()?;
        let settings = &self.plan.settings;
        let (width, height) = (rasterised.width, rasterised.height);
        let split = |i: &usize| -> Option<f32> {
            let receiver = &self.grid.receivers[*i];
            if !receiver.in_map() {
                return lambdas.first().copied();
            }
            let mut found = [Tap { texel: 0, du: 0.0, dv: 0.0 }; MOST];
            let n = taps::taps(settings.taps, receiver, width, height, &mut found);
            let mut of_taps = found[..n].iter().map(|tap| lambdas[texture.tile_of(tap.texel)]);
            let first = of_taps.next()?;
            of_taps.all(|lambda| lambda == first).then_some(first)
        };
        let subset = self.case.subset(port::MOST_CHECKED);
        let splits: Vec<Option<f32>> = subset.iter().map(split).collect();
        let (mut got, mut allowed) = (Vec::new(), Vec::new());
        for step in 0..self.plan.steps.values() {
            let lambda = self.plan.steps.lambda(step);
            let of_step: Vec<usize> = subset
                .iter()
                .zip(&splits)
                .filter(|(_, split)| **split == Some(lambda))
                .map(|(i, _)| *i)
                .collect();
            if of_step.is_empty() {
                continue;
            }
            let settings = with_lambda(settings, lambda)?;
            let reference = Reference::new(&settings, rasterised)?;
            let receivers = &self.grid.receivers[..];
            let one = |i: &usize| reference.interval(&receivers[*i]);
            allowed.extend(of_step.par_iter().map(one).collect::<Vec<_>>());
            got.extend(of_step.iter().map(|i| result[*i]));
        }
        port::check_port(settings, rasterised, &got, &allowed, checked);
        Ok(())
    }

    fn texture(&self) -> Result<SplitTexture, SuiteError> {
        let (width, height) = (self.grid.fragments.width, self.grid.fragments.height);
        Ok(SplitTexture::new(width, height, self.plan.tile, self.plan.steps)?)
    }
}

/// How far scores may lie from the processor's, in parts of the greatest: sums of 32-bit floats stay
/// two decades below, other formats round as the device likes.
fn tolerance(plan: &Plan) -> f64 {
    match &plan.settings.code {
        Code::Layered(layered) if matches!(layered.format, Format::F32 | Format::Fixed) => 1e-4,
        _ => 5e-2,
    }
}

impl Subject for GpuSearchSubject<'_, '_> {
    fn frames(&self) -> usize {
        self.plan.steps.values() as usize + SETTLED
    }

    fn reset(&mut self) -> Result<(), SuiteError> {
        (self.scored, self.drawn) = (0, 0);
        self.renderer.needs_recompute();
        Ok(())
    }

    fn frame(&mut self, _index: usize) -> Result<FrameTime, SuiteError> {
        let mut frame = self.gpu.frame();
        let tried = self.renderer.record(&mut frame);
        let times = frame.finish()?;
        self.drawn += 1;
        self.scored += u64::from(tried.is_some());
        Ok(FrameTime { wall_ns: times.wall_ns, gpu_ns: times.gpu_ns, passes: times.passes })
    }

    fn check(&mut self) -> Result<Checked, SuiteError> {
        self.reset()?;
        let read_before = self.renderer.read_backs();
        for index in 0..self.frames() {
            self.frame(index)?;
        }
        let read_backs = self.renderer.read_backs() - read_before;
        let result = self.renderer.read(self.gpu).map_err(refused)?;
        let lambdas = self.renderer.read_lambdas(self.gpu).map_err(refused)?;
        let mut checked = Checked::default();
        port::measure(self.case, &self.grid, &self.plan.settings, &result, &mut checked)?;
        let size = [self.grid.fragments.width, self.grid.fragments.height];
        let mesh = self.case.light_mesh(self.grid.crop);
        let rasterised = gpu::fragments(self.gpu, &mesh, self.grid.model, size).map_err(refused)?;
        check_raster(&self.grid.fragments, &rasterised, &mut checked);
        self.check_search(&rasterised, &lambdas, &mut checked)?;
        self.check_receivers(&rasterised, &lambdas, &result, &mut checked)?;
        let values = u64::from(self.plan.steps.values());
        if self.scored != values {
            checked.violations.push(format!(
                "the search scored {} frames, not one for each of its {values} values",
                self.scored
            ));
        }
        let search = self.renderer.counters();
        let settled = search.settled;
        let lambda = lambdas.first().copied().unwrap_or(0.0);
        checked.counters = [
            ("fragments", rasterised.items.len() as u64),
            ("geometry_passes", settled.geometry_passes),
            ("map_bytes", settled.map_bytes),
            ("bytes_per_fragment", settled.bytes_per_fragment),
            ("receivers", settled.receivers),
            ("texels_fetched", settled.texture_fetches),
            ("search_frames", self.scored),
            ("search_passes_a_frame", search.trial_passes),
            ("read_backs", read_backs),
            ("map_sets", self.drawn + self.scored),
            ("scored_bytes_a_frame", search.scored_bytes),
            ("lambda_percent", (100.0 * lambda).round() as u64),
        ]
        .map(|(name, value)| (name.to_string(), value))
        .into();
        checked.memory_bytes = self.renderer.memory_bytes();
        Ok(checked)
    }

    fn picture(&mut self) -> Result<Option<Picture>, SuiteError> {
        if self.drawn == 0 || self.renderer.is_searching() {
            self.reset()?;
            for index in 0..self.frames() {
                self.frame(index)?;
            }
        }
        let result = self.renderer.read(self.gpu).map_err(refused)?;
        Ok(Some(self.case.picture(&result)))
    }
}
