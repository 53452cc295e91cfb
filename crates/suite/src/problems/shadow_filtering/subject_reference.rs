//! The oracle itself, held against truth: brute force over the window of every pixel in `f64`.
//! Its error is the method's own, without a port's. Never timed.

use super::{case::ShadowCase, port};
use crate::{
    SuiteError,
    problem::{Checked, FrameTime, Picture, Subject},
};
use dapple_shadows::filtering::{DepthMap, FilterError, Settings, reference};
use rayon::prelude::*;
use std::rc::Rc;

/// Receivers one call works on: few enough to keep all threads busy to the end.
const CHUNK: usize = 4096;

/// The reference with its map and result.
pub struct ReferenceSubject<'a, 'g> {
    case: &'a ShadowCase<'g>,
    settings: Settings,
    map: Rc<DepthMap>,
    result: Vec<f32>,
}

impl<'a, 'g> ReferenceSubject<'a, 'g> {
    /// Casts the map's rays if no other setting has.
    pub fn new(case: &'a ShadowCase<'g>, resolution: u32, settings: Settings) -> Self {
        Self { case, settings, map: case.depth_map(resolution), result: Vec::new() }
    }
}

impl Subject for ReferenceSubject<'_, '_> {
    fn frames(&self) -> usize {
        1
    }

    fn reset(&mut self) -> Result<(), SuiteError> {
        self.result.clear();
        Ok(())
    }

    fn frame(&mut self, _index: usize) -> Result<FrameTime, SuiteError> {
        let (map, settings): (&DepthMap, &Settings) = (&self.map, &self.settings);
        let chunks: Vec<Vec<f64>> = self
            .case
            .receivers()
            .par_chunks(CHUNK)
            .map(|receivers| reference::visibility(map, receivers, settings))
            .collect::<Result<_, FilterError>>()?;
        self.result = chunks.concat().into_iter().map(|v| v as f32).collect();
        Ok(FrameTime::default())
    }

    fn check(&mut self) -> Result<Checked, SuiteError> {
        self.frame(0)?;
        let mut checked = Checked { errors: self.case.errors(&self.result)?, ..Checked::default() };
        port::check_range(&self.result, &mut checked);
        let subset = self.case.subset(self.map.width);
        let (map, s) = (&self.map, &self.settings);
        port::estimator_error(self.case, s, map, &self.result, &subset, &mut checked)?;
        Ok(checked)
    }

    fn picture(&mut self) -> Result<Option<Picture>, SuiteError> {
        Ok(Some(port::picture(self.case, &self.result)))
    }
}
