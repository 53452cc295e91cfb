//! The oracle itself, held against truth: its error is the method's own, without a port's. Never
//! timed.

use super::{
    case::TranslucentCase,
    port::{self, Grid},
};
use crate::{
    SuiteError,
    problem::{Checked, FrameTime, Picture, Setting, Subject},
};
use dapple_opacity_maps::{Receiver, Settings, reference::Reference};
use rayon::prelude::*;

/// The reference with its input and result.
pub struct ReferenceSubject<'a, 'g> {
    case: &'a TranslucentCase<'g>,
    settings: Settings,
    grid: Grid,
    result: Vec<f32>,
}

impl<'a, 'g> ReferenceSubject<'a, 'g> {
    /// Finds the map's fragments if no other setting has.
    ///
    /// # Errors
    /// Settings that are refused.
    pub fn new(case: &'a TranslucentCase<'g>, setting: &Setting) -> Result<Self, SuiteError> {
        let (grid, settings) = Grid::asked(case, setting)?;
        Ok(Self { case, settings, grid, result: Vec::new() })
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
        let reference = Reference::new(&self.settings, &self.grid.fragments)?;
        let one = |receiver: &Receiver| reference.transmittance(receiver) as f32;
        self.result = self.grid.receivers.par_iter().map(one).collect();
        Ok(FrameTime::default())
    }

    fn check(&mut self) -> Result<Checked, SuiteError> {
        self.frame(0)?;
        let mut checked = Checked::default();
        port::measure(self.case, &self.grid, &self.settings, &self.result, &mut checked)?;
        Ok(checked)
    }

    fn picture(&mut self) -> Result<Option<Picture>, SuiteError> {
        Ok(Some(self.case.picture(&self.result)))
    }
}
