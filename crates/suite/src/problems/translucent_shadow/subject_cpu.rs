//! A technique on the processor: a frame encodes given fragments and shades every receiver.

use super::{
    case::TranslucentCase,
    port::{self, Grid},
};
use crate::{
    SuiteError,
    problem::{Checked, FrameTime, Picture, Setting, Subject},
};
use dapple_opacity_maps::{Code, Settings, cpu::Maps};
use std::time::Instant;

/// The maps with their input and result.
pub struct CpuSubject<'a, 'g> {
    case: &'a TranslucentCase<'g>,
    settings: Settings,
    grid: Grid,
    maps: Maps,
    result: Vec<f32>,
}

impl<'a, 'g> CpuSubject<'a, 'g> {
    /// Allocates everything a frame needs; finds the map's fragments if no other setting has.
    ///
    /// # Errors
    /// Settings that are refused, or a map of more fragments than memory allows.
    pub fn new(case: &'a TranslucentCase<'g>, setting: &Setting) -> Result<Self, SuiteError> {
        let (grid, settings) = Grid::asked(case, setting)?;
        port::check_host(grid.resolution, &settings)?;
        Ok(Self {
            case,
            maps: Maps::new(grid.resolution, grid.resolution, &settings)?,
            result: vec![0.0; case.truth().len()],
            settings,
            grid,
        })
    }
}

impl Subject for CpuSubject<'_, '_> {
    fn frames(&self) -> usize {
        1
    }

    /// A still view: no frame depends on an earlier one.
    fn reset(&mut self) -> Result<(), SuiteError> {
        Ok(())
    }

    fn frame(&mut self, _index: usize) -> Result<FrameTime, SuiteError> {
        let start = Instant::now();
        self.maps.build(&self.grid.fragments)?;
        let built = start.elapsed();
        self.maps.shade(&self.grid.receivers, &mut self.result)?;
        let all = start.elapsed();
        let ns = |d: std::time::Duration| d.as_nanos() as u64;
        let passes = vec![("encode", ns(built)), ("shade", ns(all - built))];
        Ok(FrameTime { wall_ns: ns(all), gpu_ns: None, passes })
    }

    fn check(&mut self) -> Result<Checked, SuiteError> {
        self.frame(0)?;
        let mut checked = Checked::default();
        port::measure(self.case, &self.grid, &self.settings, &self.result, &mut checked)?;
        let maps = &self.maps;
        let along = |texel: usize, depth: f32| maps.code().decode(texel, maps.texel(texel), depth);
        if let Some(banding) = port::banding(&self.grid, along) {
            checked.errors.insert("banding".into(), banding);
        }
        if let Code::Layered(layered) = &self.settings.code {
            let layers = layered.layers as usize;
            let sums = |texel: usize| {
                let words = maps.texel(texel);
                &words[words.len() - layers..]
            };
            if let Some(idle) = port::idle_layers(&self.grid.fragments, layers, sums) {
                checked.errors.insert("idle_layers".into(), idle);
            }
        }
        port::hold(
            self.case,
            &self.grid,
            &self.settings,
            &self.grid.fragments,
            &self.result,
            &mut checked,
        )?;
        checked.counters = port::counters(&self.grid, &self.settings, maps);
        // A receiver is 24 bytes and its transmittance 4.
        checked.memory_bytes = maps.map_bytes() + 28 * self.result.len() as u64;
        Ok(checked)
    }

    fn picture(&mut self) -> Result<Option<Picture>, SuiteError> {
        Ok(Some(self.case.picture(&self.result)))
    }
}
