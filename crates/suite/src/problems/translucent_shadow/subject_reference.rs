//! The oracle itself, held against truth: its error is the method's own, without a port's. Never
//! timed.

use super::{case::TranslucentCase, port, settings};
use crate::{
    SuiteError,
    problem::{Checked, FrameTime, Picture, Setting, Subject},
};
use dapple_opacity_maps::{Fragments, Receiver, Settings, exact::Exact, reference::Reference};
use rayon::prelude::*;
use std::rc::Rc;

/// The reference with its input and result.
pub struct ReferenceSubject<'a, 'g> {
    case: &'a TranslucentCase<'g>,
    settings: Settings,
    fragments: Rc<Fragments>,
    own: Rc<Exact>,
    law: Rc<Exact>,
    receivers: Rc<Vec<Receiver>>,
    result: Vec<f32>,
}

impl<'a, 'g> ReferenceSubject<'a, 'g> {
    /// Finds the map's fragments if no other setting has.
    ///
    /// # Errors
    /// Settings that are refused.
    pub fn new(case: &'a TranslucentCase<'g>, setting: &Setting) -> Result<Self, SuiteError> {
        let (resolution, crop) = (settings::resolution(setting)?, settings::crop(setting)?);
        let model = settings::model(setting)?;
        let own = case.exact(crop, resolution, model)?;
        Ok(Self {
            case,
            settings: settings::settings(setting, || Ok(own.deepest_span()))?,
            fragments: case.fragments(crop, resolution, model)?,
            law: case.exact(crop, resolution, case.law())?,
            own,
            receivers: case.receivers(crop),
            result: Vec::new(),
        })
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
        let reference = Reference::new(&self.settings, &self.fragments)?;
        let one = |receiver: &Receiver| reference.transmittance(receiver) as f32;
        self.result = self.receivers.par_iter().map(one).collect();
        Ok(FrameTime::default())
    }

    fn check(&mut self) -> Result<Checked, SuiteError> {
        self.frame(0)?;
        let mut checked = Checked::default();
        let grid = port::Grid {
            fragments: &self.fragments,
            own: &self.own,
            law: &self.law,
            receivers: &self.receivers,
        };
        port::measure(self.case, &grid, &self.settings, &self.result, &mut checked)?;
        Ok(checked)
    }

    fn picture(&mut self) -> Result<Option<Picture>, SuiteError> {
        Ok(Some(self.case.picture(&self.result)))
    }
}
