//! Cases as the judges see them, made once and shared, and techniques run on them.

use super::super::{LightsCase, SPEC, errors::Score};
use crate::{
    SuiteError,
    case::Case,
    claims::{
        Judged, Verdict,
        verdict::{figure, judged, paired},
    },
    knob::{self, Knobs},
    problem::{Form, Setting},
};
use dapple_gpu::Gpu;
use dapple_many_lights::{Lighting, Shaded, Work};
use dapple_metrics::stats::Ratio;
use serde_json::{Value, json};
use std::{cell::RefCell, collections::BTreeMap, rc::Rc, time::Instant};

/// The source's points of view a to d, in generated cities.
pub const VIEWS: [&str; 4] = ["facade", "close_ended", "street", "birds_eye"];

/// One RGB step, as the source calls it, of linear radiance.
pub const RGB: f64 = 1.0 / 255.0;

/// The source's threshold where it times cuts: a hundredth of a step.
pub const FINE: f64 = RGB / 100.0;

/// Its threshold where it culls: a quarter of a step.
pub const COARSE: f64 = RGB / 4.0;

/// Pairs of frames timed in turn.
pub const PAIRS: usize = 5;

/// A case of this problem: 128 columns, one frame and 256 pixels of truth where nothing else is
/// given.
///
/// # Errors
/// A parameter that there is not, or out of range.
pub fn case_of(scene: &str, view: &str, given: &[(&str, Value)]) -> Result<Case, SuiteError> {
    let usual = [("width", json!(128)), ("frames", json!(1)), ("truth_pixels", json!(256))];
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

/// The same made ready, without a device, once a thread.
///
/// # Errors
/// As [`LightsCase::prepare`]; test data that are not at hand.
pub fn prepared(
    scene: &str,
    view: &str,
    given: &[(&str, Value)],
) -> Result<Rc<LightsCase<'static>>, SuiteError> {
    thread_local! {
        static MADE: RefCell<BTreeMap<String, Rc<LightsCase<'static>>>> =
            const { RefCell::new(BTreeMap::new()) };
    }
    let key = format!("{scene} {view} {given:?}");
    if let Some(made) = MADE.with_borrow(|made| made.get(&key).map(Rc::clone)) {
        return Ok(made);
    }
    let case = Rc::new(LightsCase::prepare(&case_of(scene, view, given)?, None)?);
    MADE.with_borrow_mut(|made| made.insert(key, Rc::clone(&case)));
    Ok(case)
}

/// The same on a device; not kept.
///
/// # Errors
/// As [`LightsCase::prepare`].
pub fn on_device<'g>(
    scene: &str,
    view: &str,
    given: &[(&str, Value)],
    gpu: &'g Gpu,
) -> Result<LightsCase<'g>, SuiteError> {
    LightsCase::prepare(&case_of(scene, view, given)?, Some(gpu))
}

/// A technique's setting: its first variant where `name` has none (`absolute-cut/tile`), some knobs
/// given.
///
/// # Errors
/// A technique, variant or knob that there is not.
pub fn setting(name: &str, form: Form, given: &[(&str, Value)]) -> Result<Setting, SuiteError> {
    let (technique, variant) = name.split_once('/').unwrap_or((name, ""));
    let declared = SPEC.technique(technique)?;
    let known = || declared.variants.iter().map(|v| v.id);
    let variant = match known().find(|id| variant.is_empty() || *id == variant) {
        Some(id) => id.to_string(),
        None => return Err(SuiteError::unknown("variant", variant, known())),
    };
    let given: Knobs = given.iter().map(|(name, v)| ((*name).into(), v.clone())).collect();
    let knobs = knob::complete("knob", declared.knobs, &given)?;
    Ok(Setting { technique: technique.into(), variant, form, knobs })
}

/// R4 on the processor over a tree of that name.
///
/// # Errors
/// A tree that there is not.
pub fn cut(tree: &str, threshold: f64) -> Result<Setting, SuiteError> {
    let knobs = [("tree", json!(tree)), ("threshold", json!(threshold))];
    setting("absolute-cut", Form::Cpu, &knobs)
}

/// What a technique made of all frames of a case.
#[derive(Clone, Debug, Default)]
pub struct Run {
    /// One a frame.
    pub frames: Vec<Shaded>,
    /// Of all frames.
    pub work: Work,
    /// Against the truth.
    pub errors: BTreeMap<String, f64>,
    /// Mean signed error over the mean truth.
    pub bias: f64,
}

impl Run {
    /// A metric against the truth; not a number where there is none of that name.
    pub fn error(&self, metric: &str) -> f64 {
        self.errors.get(metric).copied().unwrap_or(f64::NAN)
    }

    /// A counter over the pixels that show anything.
    pub fn a_pixel(&self, of: impl Fn(&Work) -> u64) -> f64 {
        of(&self.work) as f64 / self.work.pixels.max(1) as f64
    }
}

/// Lights every frame of a case, counted.
///
/// # Errors
/// The technique's.
pub fn run(case: &LightsCase<'_>, setting: &Setting) -> Result<Run, SuiteError> {
    run_of(case, &mut *case.lighting(setting)?, case.seed())
}

/// The same by a technique made ready, under a seed.
///
/// # Errors
/// The technique's.
pub fn run_of(
    case: &LightsCase<'_>,
    lighting: &mut dyn Lighting,
    seed: u32,
) -> Result<Run, SuiteError> {
    lighting.reset(seed)?;
    let (mut run, mut score) = (Run::default(), Score::default());
    for index in 0..case.world().frames.len() {
        let mut shaded = Shaded::default();
        lighting.shade(index, true)?;
        lighting.read(&mut shaded)?;
        score.add(case.truth(), index, &shaded.radiance);
        run.work += shaded.work;
        run.frames.push(shaded);
    }
    run.errors = score.errors()?;
    run.bias = score.relative_bias();
    Ok(run)
}

/// Time of all frames by `a` over that by `b`, in turn: the device's clock where there is one.
///
/// # Errors
/// The technique's.
pub fn time_ratio(
    case: &LightsCase<'_>,
    a: &Setting,
    b: &Setting,
    pairs: usize,
) -> Result<Ratio, SuiteError> {
    let (mut a, mut b) = (case.lighting(a)?, case.lighting(b)?);
    paired(pairs, || ns(case, &mut *a), || ns(case, &mut *b))
}

/// Nanoseconds of all frames.
///
/// # Errors
/// The technique's.
pub fn ns(case: &LightsCase<'_>, lighting: &mut dyn Lighting) -> Result<f64, SuiteError> {
    lighting.reset(case.seed())?;
    let mut total = 0.0;
    for index in 0..case.world().frames.len() {
        let start = Instant::now();
        let passes = lighting.shade(index, false)?;
        let wall = start.elapsed().as_nanos() as f64;
        let on_device = passes.iter().map(|(_, ns)| *ns as f64).sum();
        total += if passes.is_empty() { wall } else { on_device };
    }
    Ok(total)
}

/// A claim's judge, open where test data are not at hand.
///
/// # Errors
/// All other errors.
pub fn open_without_data(judged_: Result<Judged, SuiteError>) -> Result<Judged, SuiteError> {
    match judged_ {
        Err(error @ SuiteError::MissingData { .. }) => {
            let figures = vec![figure("files at hand", 0.0, "")];
            Ok(judged(Verdict::Open, error.to_string(), figures))
        }
        other => other,
    }
}
