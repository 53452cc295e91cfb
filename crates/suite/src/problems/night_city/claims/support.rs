//! Cases as the judges see them, made once and shared, and techniques run on them.

use super::super::{NightCase, SPEC, settings};
use crate::{
    SuiteError,
    case::Case,
    claims::Verdict,
    knob::{self, Knobs},
    night,
    problem::{Checked, Form, Prepared as _, Setting},
};
use dapple_many_lights::region::{Occluders, Steps};
use dapple_metrics::stats::median;
use dapple_night_city::{Drawer, Front, Night, Pipeline, Prepared};
use serde_json::{Value, json};
use std::{cell::RefCell, collections::BTreeMap, rc::Rc, sync::Arc};

pub use crate::problems::many_lights::claims::support::{
    COARSE, FINE, PAIRS, RGB, VIEWS, open_without_data,
};

/// What "about so many times" allows, both ways.
pub const ABOUT: f64 = 1.5;

/// Frames that the source keeps precuts for.
pub const KEPT: u32 = 50;

type Given<'a> = &'a [(&'a str, Value)];

/// A case of this problem: 96 columns, one frame and 64 pixels of truth where nothing else is given.
///
/// # Errors
/// A parameter that there is not, or out of range.
pub fn case_of(scene: &str, view: &str, given: Given<'_>) -> Result<Case, SuiteError> {
    let usual = [("width", json!(96)), ("frames", json!(1)), ("truth_pixels", json!(64))];
    let given = usual.iter().chain(given);
    let given: Knobs = given.map(|(name, value)| ((*name).into(), value.clone())).collect();
    Ok(Case {
        problem: SPEC.id.into(),
        scene: scene.into(),
        view: view.into(),
        seed: 0,
        parameters: knob::complete("parameter", SPEC.parameters, &given)?,
    })
}

type Cases = BTreeMap<String, Rc<NightCase<'static>>>;

/// The same made ready, without a device, once a thread.
///
/// # Errors
/// As [`NightCase::prepare`]; test data that are not at hand.
pub fn prepared(
    scene: &str,
    view: &str,
    given: Given<'_>,
) -> Result<Rc<NightCase<'static>>, SuiteError> {
    thread_local! {
        static MADE: RefCell<Cases> = const { RefCell::new(BTreeMap::new()) };
    }
    let key = format!("{scene} {view} {given:?}");
    if let Some(made) = MADE.with_borrow(|made| made.get(&key).map(Rc::clone)) {
        return Ok(made);
    }
    let case = Rc::new(NightCase::prepare(&case_of(scene, view, given)?, None)?);
    MADE.with_borrow_mut(|made| made.insert(key, Rc::clone(&case)));
    Ok(case)
}

/// The same with every storey of every facade as an occluder beside the buildings; not kept.
///
/// # Errors
/// As [`prepared`].
pub fn behind_all_objects(
    scene: &str,
    view: &str,
    given: Given<'_>,
) -> Result<NightCase<'static>, SuiteError> {
    let case = case_of(scene, view, given)?;
    let mut night = night::Night::load(&case)?;
    let Some(town) = Arc::get_mut(&mut night.town) else {
        return Err(SuiteError::Internal("the town is shared".into()));
    };
    town.occluders = Arc::new(Occluders::of_objects(&night.city, town.objects.origin));
    NightCase::of(night, &case, None)
}

/// A technique's setting on the processor: its first variant where `name` has none
/// (`facade-cluster/insertion`), some knobs given.
///
/// # Errors
/// A technique, variant or knob that there is not.
pub fn setting(name: &str, given: Given<'_>) -> Result<Setting, SuiteError> {
    let (technique, variant) = name.split_once('/').unwrap_or((name, ""));
    let declared = SPEC.technique(technique)?;
    let known = || declared.variants.iter().map(|v| v.id);
    let variant = match known().find(|id| variant.is_empty() || *id == variant) {
        Some(id) => id.to_string(),
        None => return Err(SuiteError::unknown("variant", variant, known())),
    };
    let given: Knobs = given.iter().map(|(name, v)| ((*name).into(), v.clone())).collect();
    let knobs = knob::complete("knob", declared.knobs, &given)?;
    Ok(Setting { technique: technique.into(), variant, form: Form::Cpu, knobs })
}

/// Facade-cluster visibility with some knobs.
///
/// # Errors
/// A knob that there is not.
pub fn night(given: Given<'_>) -> Result<Night, SuiteError> {
    settings::night(&setting("facade-cluster", given)?, 0)
}

/// Everything before pixels are lit, made ready.
///
/// # Errors
/// Settings that are refused.
pub fn front(case: &NightCase<'_>, night: &Night) -> Result<Front<'static>, SuiteError> {
    let town = &case.night().town;
    Ok(Front::new(town, night, Drawer::new(&town.objects, None)?)?)
}

/// Whole frames, made ready.
///
/// # Errors
/// Settings that are refused.
pub fn pipeline(case: &NightCase<'_>, night: &Night) -> Result<Pipeline<'static>, SuiteError> {
    Ok(Pipeline::new(&case.night().town, night, None)?)
}

/// So many frames of a camera that stands where the first frame's does.
///
/// # Errors
/// None of a case that has a frame.
pub fn standing(front: &mut Front<'_>, frames: usize) -> Result<Vec<Prepared>, SuiteError> {
    (0..frames).map(|_| Ok(front.prepare(0)?)).collect()
}

/// All frames of a path.
///
/// # Errors
/// None of frames that there are.
pub fn walking(case: &NightCase<'_>, front: &mut Front<'_>) -> Result<Vec<Prepared>, SuiteError> {
    (0..case.night().town.views.len()).map(|index| Ok(front.prepare(index)?)).collect()
}

/// Mean over frames.
pub fn mean(frames: &[Prepared], of: impl Fn(&Prepared) -> u64) -> f64 {
    frames.iter().map(of).sum::<u64>() as f64 / frames.len().max(1) as f64
}

/// Tests of clusters by potential and against shadows: steps 7, 9 and 11 of table 5.V.
pub fn tests(steps: &Steps) -> u64 {
    steps.potential + steps.last + steps.early
}

/// What a technique made of all frames of a case, against the truth; by the names of its knobs, once a
/// thread.
///
/// # Errors
/// The technique's; a broken invariant.
pub fn checked(
    case: &NightCase<'_>,
    name: &str,
    knobs: Given<'_>,
) -> Result<Rc<Checked>, SuiteError> {
    thread_local! {
        static MADE: RefCell<BTreeMap<String, Rc<Checked>>> = const { RefCell::new(BTreeMap::new()) };
    }
    let key = format!("{} {} {name} {knobs:?}", case.night().key, case.truth().pixels());
    if let Some(made) = MADE.with_borrow(|made| made.get(&key).map(Rc::clone)) {
        return Ok(made);
    }
    let checked = case.subject(&setting(name, knobs)?)?.check()?;
    if let Some(violation) = checked.violations.first() {
        return Err(SuiteError::Internal(format!("{name}: {violation}")));
    }
    let checked = Rc::new(checked);
    MADE.with_borrow_mut(|made| made.insert(key, Rc::clone(&checked)));
    Ok(checked)
}

/// A metric; not a number where there is none of that name.
pub fn error(checked: &Checked, metric: &str) -> f64 {
    checked.errors.get(metric).copied().unwrap_or(f64::NAN)
}

/// A counter; not a number where there is none of that name, or nothing of it happened.
pub fn counter(checked: &Checked, name: &str) -> f64 {
    checked.counters.get(name).map_or(f64::NAN, |count| *count as f64)
}

/// Nanoseconds of the frames of a case by a setting, from the first: the median of `repeats`, after one
/// that is thrown away.
///
/// # Errors
/// The technique's.
pub fn ns(case: &NightCase<'_>, setting: &Setting, repeats: usize) -> Result<f64, SuiteError> {
    let mut subject = case.subject(setting)?;
    let mut times = Vec::new();
    for _ in 0..=repeats {
        subject.reset()?;
        let mut sum = 0.0;
        for index in 0..subject.frames() {
            sum += subject.frame(index)?.wall_ns as f64;
        }
        times.push(sum);
    }
    Ok(median(&times[1..])?)
}

/// "About so many times": met within a factor of 1.5 or by more, contradicted where nothing is gained,
/// open between.
pub fn about_times(measured: f64, said: f64) -> Verdict {
    if measured >= (said / ABOUT).max(1.0) && measured > 1.0 {
        Verdict::Reproduced
    } else if measured > 1.0 {
        Verdict::Open
    } else {
        Verdict::Refuted
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn about_is_a_factor_of_one_and_a_half() {
        assert_eq!(about_times(2.0, 3.0), Reproduced);
        assert_eq!(about_times(9.0, 3.0), Reproduced);
        assert_eq!(about_times(1.9, 3.0), Open);
        assert_eq!(about_times(1.0, 3.0), Refuted);
        assert_eq!(about_times(1.01, 1.15), Reproduced);
        assert_eq!(about_times(0.99, 1.15), Refuted);
        assert_eq!(about_times(f64::NAN, 3.0), Refuted);
    }
}
