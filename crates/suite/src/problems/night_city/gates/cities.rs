//! Small cities at night, and frames of them.

use crate::{
    SuiteError,
    case::Case,
    knob::{self, Knobs},
    problem::{Form, Setting, Technique},
    problems::night_city::{NightCase, SPEC},
};
use dapple_gpu::Gpu;
use dapple_many_lights::{Absolute, Shaded};
use dapple_night_city::{Night, Pipeline};
use glam::Vec3;
use serde_json::{Value, json};

/// Where a city is seen from, and how much of it.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Its name.
    pub scene: &'static str,
    /// View; empty for the first.
    pub view: &'static str,
    /// Columns.
    pub width: i64,
    /// Of the path.
    pub frames: i64,
    /// Pixels of a frame whose truth is known.
    pub truth_pixels: i64,
}

/// A few frames of the small city.
pub const SMALL: Seen =
    Seen { scene: "city_small", view: "", width: 24, frames: 3, truth_pixels: 16 };

/// A city, generated from a seed.
///
/// # Errors
/// None of a city that there is.
pub fn city<'g>(seen: Seen, seed: u64, gpu: Option<&'g Gpu>) -> Result<NightCase<'g>, SuiteError> {
    let given: Knobs = [
        ("width", json!(seen.width)),
        ("frames", json!(seen.frames)),
        ("truth_pixels", json!(seen.truth_pixels)),
    ]
    .map(|(name, value)| (name.to_string(), value))
    .into();
    let case = Case {
        problem: SPEC.id.into(),
        scene: seen.scene.into(),
        view: seen.view.into(),
        seed,
        parameters: knob::complete("parameter", SPEC.parameters, &given)?,
    };
    NightCase::prepare(&case, gpu)
}

/// A variant of a technique with a few knobs given; those that it has not are passed over.
///
/// # Errors
/// A value that a knob refuses.
pub fn setting(
    technique: &Technique,
    variant: &str,
    form: Form,
    given: &[(&str, Value)],
) -> Result<Setting, SuiteError> {
    let has = |name: &str| technique.knobs.iter().any(|knob| knob.name == name);
    let given = given.iter().filter(|(name, _)| has(name));
    let given = given.map(|(name, value)| ((*name).to_string(), value.clone())).collect();
    let knobs = knob::complete("knob", technique.knobs, &given)?;
    Ok(Setting { technique: technique.id.into(), variant: variant.into(), form, knobs })
}

/// All frames of a city by a setting.
///
/// # Errors
/// Settings that are refused, or the device's.
pub fn frames(case: &NightCase<'_>, setting: &Setting) -> Result<Vec<Vec<Vec3>>, SuiteError> {
    let mut method = case.method(setting)?;
    method.reset(SEED)?;
    let mut shaded = Shaded::default();
    let mut frames = Vec::new();
    for index in 0..case.night().town.views.len() {
        method.frame(index, false)?;
        method.read(&mut shaded)?;
        frames.push(shaded.radiance.clone());
    }
    Ok(frames)
}

/// The same by settings of the pipeline, with the evaluations of each frame.
///
/// # Errors
/// Settings that are refused.
pub fn lit(
    case: &NightCase<'_>,
    night: &Night,
    indices: &[usize],
) -> Result<(Vec<Vec<Vec3>>, Vec<u64>), SuiteError> {
    let mut pipeline = Pipeline::new(&case.night().town, night, None)?;
    let mut shaded = Shaded::default();
    let (mut frames, mut evaluations) = (Vec::new(), Vec::new());
    for &index in indices {
        evaluations.push(pipeline.frame(index, false)?.counts.evaluations);
        pipeline.read(&mut shaded)?;
        frames.push(shaded.radiance.clone());
    }
    Ok((frames, evaluations))
}

/// Cuts that divide every cluster that could show.
pub fn fine(night: Night) -> Night {
    Night { cut: Absolute { threshold: 1e-6, ..night.cut }, ..night }
}

/// Seed of a technique's own random numbers.
pub const SEED: u32 = 7;
