//! A technique that makes the frames of a path and is judged frame by frame.

use super::{
    SPEC,
    case::NightCase,
    errors::{Apart, Causes},
    method::Method,
    settings,
};
use crate::{
    SuiteError,
    problem::{self, Checked, FrameTime, Picture, Setting, Subject},
    problems::{
        many_lights::{errors::Score, port},
        region_light_visibility::counters,
    },
};
use dapple_many_lights::{
    Form, Shaded, Technique, Work,
    cut::{Given, starting},
};
use dapple_night_city::{Counts, FrameTimes};
use std::collections::BTreeMap;

/// Share of a device's pixels that may differ from the processor's, and of a form's from the clear sum:
/// those whose cut falls the other way by rounding.
const MOST_DIFFERING: f64 = 0.005;

/// A technique made ready.
pub struct NightSubject<'a, 'g> {
    case: &'a NightCase<'g>,
    setting: Setting,
    method: Method<'g>,
    shaded: Shaded,
    lit: bool,
}

impl<'a, 'g> NightSubject<'a, 'g> {
    /// Allocates what frames need.
    ///
    /// # Errors
    /// Settings that are refused, or a device that is too small.
    pub fn new(case: &'a NightCase<'g>, setting: &Setting) -> Result<Self, SuiteError> {
        SPEC.check(setting)?;
        let (method, setting) = (case.method(setting)?, setting.clone());
        Ok(Self { case, setting, method, shaded: Shaded::default(), lit: false })
    }

    fn seed(&self) -> u32 {
        (self.case.seed() ^ self.case.seed() >> 32) as u32
    }

    /// Holds the device's last frame against the processor's cut of the same lists. What the device
    /// saw may differ from what the processor sees, by the rounding of pixels, and its cells with it.
    fn hold(&self, checked: &mut Checked) -> Result<(), SuiteError> {
        let Some(starts) = self.method.starts() else { return Ok(()) };
        let night = settings::night(&self.setting, self.case.seed())?;
        let town = &self.case.night().town;
        let world = town.world(night.shadow_rays);
        let given = Given::new(&Technique::Absolute(night.cut), world, &town.lights)?;
        let mut cut = starting(Form::Cpu, &given, None)?;
        cut.start(starts)?;
        cut.shade(self.frames() - 1, false)?;
        let mut theirs = Shaded::default();
        cut.read(&mut theirs)?;
        let pairs = self.shaded.radiance.iter().zip(&theirs.radiance);
        let differ = pairs.filter(|(a, b)| !port::alike(**a, **b)).count();
        let share = differ as f64 / theirs.radiance.len().max(1) as f64;
        hold("pixels", share, checked);
        Ok(())
    }
}

fn hold(what: &str, share: f64, checked: &mut Checked) {
    checked.port_errors.insert(what.into(), share);
    if share > MOST_DIFFERING {
        checked.violations.push(format!(
            "port: {:.3} % of the {what} differ from the reference (allowed: {} %)",
            100.0 * share,
            100.0 * MOST_DIFFERING
        ));
    }
}

impl Subject for NightSubject<'_, '_> {
    fn frames(&self) -> usize {
        self.case.night().town.views.len()
    }

    fn reset(&mut self) -> Result<(), SuiteError> {
        self.method.reset(self.seed())
    }

    fn frame(&mut self, index: usize) -> Result<FrameTime, SuiteError> {
        self.lit = true;
        let times = self.method.frame(index, false)?;
        Ok(FrameTime { wall_ns: times.wall_ns, gpu_ns: None, passes: stages(&times) })
    }

    fn check(&mut self) -> Result<Checked, SuiteError> {
        self.method = self.case.method(&self.setting)?;
        self.reset()?;
        let mut checked = Checked::default();
        let mut apart = Apart::of(self.case, &self.setting)?;
        let (mut score, mut causes) = (Score::default(), Causes::default());
        let (mut work, mut counts) = (Work::default(), Vec::new());
        let (mut clear, mut differ) = (0_usize, 0_usize);
        for index in 0..self.frames() {
            counts.push(self.method.frame(index, true)?);
            work += self.method.read(&mut self.shaded)?;
            let radiance = &self.shaded.radiance;
            let bad = radiance.iter().position(|r| !(r.is_finite() && r.min_element() >= 0.0));
            if let Some(pixel) = bad {
                let found = radiance[pixel];
                checked.violations.push(format!("frame {index}: pixel {pixel} is lit by {found}"));
                return Ok(checked);
            }
            score.add(self.case.truth(), index, radiance);
            if let (Some(apart), Some(starts)) = (&mut apart, self.method.starts()) {
                let results = apart.add(self.case, index, starts, &mut causes)?;
                clear += results.len();
                let wrong = |(pixel, result): &&(u32, glam::DVec3)| {
                    !port::alike(radiance[*pixel as usize], result.as_vec3())
                };
                differ += results.iter().filter(wrong).count();
            }
        }
        self.lit = true;
        checked.errors = score.errors()?;
        checked.errors.extend(causes.errors());
        if apart.is_none() {
            // It takes nothing for hidden; what causes its errors is chance.
            checked.errors.retain(|name, _| !name.starts_with("e_") && name != "leak");
        } else if clear >= 1000 || differ > 2 {
            // A pixel or two of few may fall the other way.
            hold("pixels_taken_apart", differ as f64 / clear as f64, &mut checked);
        }
        if self.setting.form == problem::Form::Gpu {
            self.hold(&mut checked)?;
        }
        checked.counters = self.counters(&work, &counts);
        checked.memory_bytes = self.method.bytes();
        Ok(checked)
    }

    fn picture(&mut self) -> Result<Option<Picture>, SuiteError> {
        if !self.lit {
            self.reset()?;
            for index in 0..self.frames() {
                self.frame(index)?;
            }
        }
        self.method.read(&mut self.shaded)?;
        Ok(Some(self.case.picture(&self.shaded.radiance)?))
    }
}

impl NightSubject<'_, '_> {
    fn counters(&self, work: &Work, frames: &[FrameTimes]) -> BTreeMap<String, u64> {
        let mut counters = port::counters(work, frames.len());
        counters.extend(counters_of_regions(self));
        let sum = |of: fn(&Counts) -> u64| frames.iter().map(|f| of(&f.counts)).sum::<u64>();
        let most = |of: fn(&Counts) -> u64| frames.iter().map(|f| of(&f.counts)).max().unwrap_or(0);
        let last = |of: fn(&Counts) -> u64| frames.last().map_or(0, |f| of(&f.counts));
        let first = frames.first().map_or(0, |f| f.counts.evaluations);
        let more = [
            ("objects_drawn", sum(|c| c.drawn)),
            ("cells", sum(|c| c.cells)),
            ("evaluations", sum(|c| c.evaluations)),
            ("evaluations_at_start", first),
            ("late_cells", sum(|c| c.late)),
            ("lists", sum(|c| c.lists)),
            ("list_nodes", sum(|c| c.list_nodes)),
            ("most_list_bytes", most(|c| c.list_bytes)),
            ("kept_bytes", last(|c| c.kept_bytes)),
            ("uploaded_bytes", frames.iter().map(|f| f.uploaded).sum()),
        ];
        counters.extend(more.into_iter().filter(|(_, n)| *n > 0).map(|(k, n)| (k.to_string(), n)));
        counters
    }
}

fn counters_of_regions(subject: &NightSubject<'_, '_>) -> BTreeMap<String, u64> {
    counters(&subject.method.front().steps())
}

/// Stages of a frame by name.
fn stages(times: &FrameTimes) -> Vec<(&'static str, u64)> {
    vec![
        ("visibility", times.visibility_ns),
        ("cells", times.cells_ns),
        ("regions", times.region_ns),
        ("upload", times.upload_ns),
        ("shading", times.shading_ns),
    ]
}
