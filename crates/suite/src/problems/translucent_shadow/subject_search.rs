//! Bounding opacity maps whose split is searched for: eleven frames try a λ each, then the best is
//! kept, for the whole map or tile by tile.

use super::{
    case::TranslucentCase,
    port::{self, Grid},
    settings,
};
use crate::{
    SuiteError,
    knob::{Get, choice},
    problem::{Checked, FrameTime, Picture, Setting, Subject},
};
use dapple_opacity_maps::{
    Code, Criterion, Settings,
    search::{Plan, Precision, Scoring, Search, Steps},
};
use std::time::Instant;

/// Frames after the search: what a scene at rest costs.
pub const SETTLED: usize = 3;

/// A search with its input and result.
pub struct SearchSubject<'a, 'g> {
    case: &'a TranslucentCase<'g>,
    plan: Plan,
    grid: Grid,
    search: Search,
    map_sets: u64,
    scored: u64,
    result: Vec<f32>,
}

impl<'a, 'g> SearchSubject<'a, 'g> {
    /// Allocates everything a frame needs.
    ///
    /// # Errors
    /// Settings that are refused, or a criterion that says nothing of a tile that small.
    pub fn new(case: &'a TranslucentCase<'g>, setting: &Setting) -> Result<Self, SuiteError> {
        let (grid, settings) = Grid::asked(case, setting)?;
        port::check_host(grid.resolution, &settings)?;
        let plan = plan(setting, settings)?;
        Ok(Self {
            case,
            search: Search::new(grid.resolution, grid.resolution, plan.clone())?,
            plan,
            result: vec![0.0; grid.receivers.len()],
            map_sets: 0,
            scored: 0,
            grid,
        })
    }
}

/// What a setting searches for.
///
/// # Errors
/// A knob out of range.
pub fn plan(setting: &Setting, settings: Settings) -> Result<Plan, SuiteError> {
    let criterion = match setting.variant.as_str() {
        "sad" => Criterion::Sad,
        "correlation" => Criterion::Correlation,
        "mutual-information" => Criterion::MutualInformation,
        "equal-opacity" => Criterion::EqualOpacity,
        "oracle" => Criterion::Oracle,
        _ => Criterion::EqualTransmittance,
    };
    let precisions = [("float", Precision::Float), ("bytes", Precision::Bytes)];
    let precision = choice(&setting.knobs, "scoring", &precisions)?;
    let mut plan = Plan::plain(settings, criterion);
    plan.scoring = Scoring { precision, ..plan.scoring };
    plan.steps = Steps::of(setting.knobs.float("lambda_step")? as f32)?;
    plan.tile = settings::whole(&setting.knobs, "tile", 0, 4096)?;
    Ok(plan)
}

impl Subject for SearchSubject<'_, '_> {
    fn frames(&self) -> usize {
        self.plan.steps.values() as usize + SETTLED
    }

    fn reset(&mut self) -> Result<(), SuiteError> {
        (self.map_sets, self.scored) = (0, 0);
        self.search.needs_recompute();
        Ok(())
    }

    fn frame(&mut self, _index: usize) -> Result<FrameTime, SuiteError> {
        let start = Instant::now();
        let report = self.search.frame(&self.grid.fragments)?;
        let searched = start.elapsed();
        self.search.maps().shade(&self.grid.receivers, &mut self.result)?;
        let all = start.elapsed();
        self.map_sets += u64::from(report.map_sets);
        self.scored += u64::from(report.trial.is_some());
        let ns = |d: std::time::Duration| d.as_nanos() as u64;
        let passes = vec![("search", ns(searched)), ("shade", ns(all - searched))];
        Ok(FrameTime { wall_ns: ns(all), gpu_ns: None, passes })
    }

    fn check(&mut self) -> Result<Checked, SuiteError> {
        self.reset()?;
        for index in 0..self.frames() {
            self.frame(index)?;
        }
        let mut checked = Checked::default();
        port::measure(self.case, &self.grid, &self.plan.settings, &self.result, &mut checked)?;
        let maps = self.search.maps();
        let along = |texel: usize, depth: f32| maps.code().decode(texel, maps.texel(texel), depth);
        if let Some(banding) = port::banding(&self.grid, along) {
            checked.errors.insert("banding".into(), banding);
        }
        let values = u64::from(self.plan.steps.values());
        if self.scored != values {
            checked.violations.push(format!(
                "the search scored {} frames, not one for each of its {values} values",
                self.scored
            ));
        }
        checked.counters = port::counters(&self.grid, &self.plan.settings, maps);
        let lambda = self.search.texture().lambda(0);
        let layers = match &self.plan.settings.code {
            Code::Layered(layered) => u64::from(layered.layers),
            _ => 0,
        };
        let scored_bytes = 4 * layers * u64::from(self.grid.resolution).pow(2);
        for (name, value) in [
            ("search_frames", self.scored),
            ("map_sets", self.map_sets),
            ("scored_bytes_a_frame", scored_bytes),
            ("lambda_percent", (100.0 * lambda).round() as u64),
        ] {
            checked.counters.insert(name.into(), value);
        }
        // Trial maps beside those that are drawn.
        checked.memory_bytes = 2 * maps.map_bytes() + 28 * self.result.len() as u64;
        Ok(checked)
    }

    fn picture(&mut self) -> Result<Option<Picture>, SuiteError> {
        Ok(Some(self.case.picture(&self.result)))
    }
}
