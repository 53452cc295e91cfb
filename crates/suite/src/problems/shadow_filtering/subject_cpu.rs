//! A filter on the processor: a frame filters a given depth map and shades every pixel.

use super::{case::ShadowCase, memory, port};
use crate::{
    SuiteError,
    problem::{Checked, FrameTime, Picture, Subject},
};
use dapple_shadows::filtering::{DepthMap, Settings, cpu, reference::Rounding};
use std::{rc::Rc, time::Instant};

/// The filter with its map and result.
pub struct CpuSubject<'a, 'g> {
    case: &'a ShadowCase<'g>,
    settings: Settings,
    map: Rc<DepthMap>,
    filter: cpu::Filter,
    result: Vec<f32>,
}

impl<'a, 'g> CpuSubject<'a, 'g> {
    /// Allocates everything a frame needs; casts the map's rays if no other setting has.
    ///
    /// # Errors
    /// Settings that the filter refuses, or that need more memory than there is.
    pub fn new(
        case: &'a ShadowCase<'g>,
        resolution: u32,
        settings: Settings,
    ) -> Result<Self, SuiteError> {
        memory::check_host(resolution, &settings, memory::host_bytes(resolution, &settings))?;
        let map = case.depth_map(resolution);
        let filter = cpu::Filter::new(resolution, resolution, &settings)?;
        let result = vec![0.0; case.receivers().len()];
        Ok(Self { case, settings, map, filter, result })
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
        self.filter.prefilter(&self.map)?;
        let filtered = start.elapsed();
        self.filter.shade(&self.map, self.case.receivers(), &mut self.result)?;
        let all = start.elapsed();
        let ns = |d: std::time::Duration| d.as_nanos() as u64;
        let passes = vec![("prefilter", ns(filtered)), ("shade", ns(all - filtered))];
        Ok(FrameTime { wall_ns: ns(all), gpu_ns: None, passes })
    }

    fn check(&mut self) -> Result<Checked, SuiteError> {
        self.frame(0)?;
        let s = &self.settings;
        let mut checked = Checked {
            errors: self.case.errors(&self.result)?,
            counters: port::counters(self.case, s, &self.filter.counters()),
            // A receiver is 32 bytes and its visibility 4.
            memory_bytes: memory::host_bytes(self.map.width, s) + 36 * self.result.len() as u64,
            ..Checked::default()
        };
        port::check_range(&self.result, &mut checked);
        let subset = self.case.subset(self.map.width);
        let (map, result, rounding) = (&self.map, &self.result, Rounding::cpu());
        port::check_port(self.case, s, map, result, &subset, &rounding, &mut checked)?;
        port::estimator_error(self.case, s, &self.map, &self.result, &subset, &mut checked)?;
        Ok(checked)
    }

    fn picture(&mut self) -> Result<Option<Picture>, SuiteError> {
        Ok(Some(port::picture(self.case, &self.result)))
    }
}
