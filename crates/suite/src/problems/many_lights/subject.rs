//! A technique that lights the path and is judged frame by frame.

use super::{SPEC, case::LightsCase, errors::Score, port, replicas, settings};
use crate::{
    SuiteError,
    problem::{Checked, FrameTime, Picture, Setting, Subject},
};
use dapple_many_lights::{Lighting, Shaded, Technique, Work};
use std::time::Instant;

/// A technique made ready.
pub struct LightsSubject<'a, 'g> {
    case: &'a LightsCase<'g>,
    setting: Setting,
    technique: Technique,
    lighting: Box<dyn Lighting + 'g>,
    shaded: Shaded,
    lit: bool,
}

impl<'a, 'g> LightsSubject<'a, 'g> {
    /// Allocates what a frame needs; builds the tree if no other setting has.
    ///
    /// # Errors
    /// Settings that are refused, or a device that is too small.
    pub fn new(case: &'a LightsCase<'g>, setting: &Setting) -> Result<Self, SuiteError> {
        SPEC.check(setting)?;
        Ok(Self {
            technique: settings::technique(setting)?,
            lighting: case.lighting(setting)?,
            case,
            setting: setting.clone(),
            shaded: Shaded::default(),
            lit: false,
        })
    }
}

impl Subject for LightsSubject<'_, '_> {
    fn frames(&self) -> usize {
        self.case.world().frames.len()
    }

    fn reset(&mut self) -> Result<(), SuiteError> {
        Ok(self.lighting.reset(self.case.seed())?)
    }

    fn frame(&mut self, index: usize) -> Result<FrameTime, SuiteError> {
        self.lit = true;
        let start = Instant::now();
        let passes = self.lighting.shade(index, false)?;
        let wall_ns = start.elapsed().as_nanos() as u64;
        let gpu_ns = (!passes.is_empty()).then(|| passes.iter().map(|(_, ns)| ns).sum());
        Ok(FrameTime { wall_ns, gpu_ns, passes })
    }

    fn check(&mut self) -> Result<Checked, SuiteError> {
        self.reset()?;
        let mut checked = Checked::default();
        let (mut score, mut work) = (Score::default(), Work::default());
        for index in 0..self.frames() {
            self.lighting.shade(index, true)?;
            self.lighting.read(&mut self.shaded)?;
            let bad = self
                .shaded
                .radiance
                .iter()
                .position(|r| !(r.is_finite() && r.min_element() >= 0.0));
            if let Some(pixel) = bad {
                checked.violations.push(format!(
                    "frame {index}: pixel {pixel} is lit by {}",
                    self.shaded.radiance[pixel]
                ));
                return Ok(checked);
            }
            score.add(self.case.truth(), index, &self.shaded.radiance);
            work += self.shaded.work;
        }
        self.lit = true;
        checked.errors = score.errors()?;
        let mut spread =
            replicas::Spread { bias: score.relative_bias().abs(), ..Default::default() };
        if settings::is_random(&self.technique) {
            spread = replicas::spread(self.case, &mut *self.lighting, self.case.seed())?;
            if settings::is_unbiased(&self.technique) && spread.z > replicas::MOST_Z {
                checked.violations.push(format!(
                    "the mean of {} repetitions misses the truth by {:.2e} of it, {:.0} standard \
                     errors (allowed: {})",
                    replicas::REPETITIONS,
                    spread.bias,
                    spread.z,
                    replicas::MOST_Z
                ));
            }
        }
        checked.errors.insert("bias".into(), spread.bias);
        checked.errors.insert("noise".into(), spread.noise);
        port::hold(self.case, &self.setting, &mut checked)?;
        checked.counters = port::counters(&work, self.frames());
        checked.memory_bytes = self.lighting.bytes();
        Ok(checked)
    }

    fn picture(&mut self) -> Result<Option<Picture>, SuiteError> {
        if !self.lit {
            self.reset()?;
            for index in 0..self.frames() {
                self.frame(index)?;
            }
        }
        self.lighting.read(&mut self.shaded)?;
        Ok(Some(self.case.picture(&self.shaded.radiance)?))
    }
}
