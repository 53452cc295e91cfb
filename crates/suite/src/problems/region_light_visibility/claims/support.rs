//! Cases as the judges see them, made once and shared, and techniques run on them.

use super::super::{RegionCase, SPEC};
use crate::{
    SuiteError,
    case::Case,
    claims::Verdict,
    knob::{self, Knobs},
};
use dapple_many_lights::region::{
    Direction, Edge, FacadeCluster, Fusion, Many, OccluderMode, Occluders, Planes, Precuts,
    RegionTechnique, Split, Steps, ViewCell, evaluate::Evaluator, make, truth::Agreement,
};
use serde_json::json;
use std::{cell::RefCell, collections::BTreeMap, rc::Rc, sync::Arc, time::Instant};

/// The source's cities, smallest first, by name, and the view of its tables.
pub const CITIES: [&str; 3] = ["city", "city_9", "city_15"];
pub const VIEW: &str = "close_ended";

/// What "about" means where a source does not say.
pub const ABOUT: f64 = 1.5;

/// As the source says it, save that its occluders are buildings rather than nodes of a hierarchy.
pub const THESIS: FacadeCluster = FacadeCluster {
    fusion: Fusion::Insertion,
    edge: Edge::Sloped,
    occluders: OccluderMode::Leaf,
    planes: Planes::FarFaces,
    least_step_m: 0.0,
    threshold: 1.0 / 1020.0,
    split: Split::All,
    cached: false,
};

/// As this project would run it.
pub const OURS: FacadeCluster =
    FacadeCluster { fusion: Fusion::HeightOrdered, edge: Edge::Flat, least_step_m: 5.0, ..THESIS };

/// A cell, and a direction that something in it faces.
pub type Asked<'a> = (&'a ViewCell, Direction);

/// One frame of 300 x 225 of a generated city, made ready once a thread, with the truth of so many
/// faces.
///
/// # Errors
/// As [`RegionCase::prepare`].
pub fn prepared(scene: &str, view: &str, truth_faces: u32) -> Result<Rc<RegionCase>, SuiteError> {
    thread_local! {
        static MADE: RefCell<BTreeMap<String, Rc<RegionCase>>> =
            const { RefCell::new(BTreeMap::new()) };
    }
    let key = format!("{scene} {view} {truth_faces}");
    if let Some(made) = MADE.with_borrow(|made| made.get(&key).map(Rc::clone)) {
        return Ok(made);
    }
    let given: Knobs = [("truth_faces".to_string(), json!(truth_faces))].into();
    let case = Rc::new(RegionCase::prepare(&Case {
        problem: SPEC.id.into(),
        scene: scene.into(),
        view: view.into(),
        seed: 0,
        parameters: knob::complete("parameter", SPEC.parameters, &given)?,
    })?);
    MADE.with_borrow_mut(|made| made.insert(key, Rc::clone(&case)));
    Ok(case)
}

/// All faces of a case's frame.
pub fn asked(case: &RegionCase) -> Vec<Asked<'_>> {
    case.frames()[0].iter().map(|question| question.asked()).collect()
}

/// Those whose truth is known.
pub fn judged_faces(case: &RegionCase) -> Vec<Asked<'_>> {
    case.truth()[0].iter().map(|face| case.frames()[0][face.question].asked()).collect()
}

/// A technique made ready for one thread; the case's buildings hide where no `occluders` are given.
///
/// # Errors
/// Settings that are refused.
pub fn one(
    case: &RegionCase,
    technique: &RegionTechnique,
    occluders: Option<&Arc<Occluders>>,
) -> Result<Box<dyn Precuts>, SuiteError> {
    let town = &case.night().town;
    let occluders = occluders.unwrap_or(&town.occluders);
    Ok(make(technique, false, town.world(true), &town.lights, occluders)?)
}

/// What a technique made of some faces.
pub struct Run {
    pub precuts: Vec<Vec<u32>>,
    pub steps: Steps,
}

impl Run {
    /// A counter an evaluation.
    pub fn each(&self, of: impl Fn(&Steps) -> u64) -> f64 {
        of(&self.steps) as f64 / self.steps.evaluations.max(1) as f64
    }
}

/// Every face of a case, on all threads.
///
/// # Errors
/// Settings that are refused.
pub fn run(case: &RegionCase, settings: FacadeCluster) -> Result<Run, SuiteError> {
    run_of(case, &RegionTechnique::FacadeCluster(settings), None, &asked(case))
}

/// Some faces, by any technique.
///
/// # Errors
/// Settings that are refused.
pub fn run_of(
    case: &RegionCase,
    technique: &RegionTechnique,
    occluders: Option<&Arc<Occluders>>,
    asked: &[Asked<'_>],
) -> Result<Run, SuiteError> {
    let town = &case.night().town;
    let occluders = occluders.unwrap_or(&town.occluders);
    let make = || make(technique, false, town.world(true), &town.lights, occluders);
    let mut many = Many::new(make)?;
    let mut precuts = Vec::new();
    many.all(asked, &mut precuts);
    Ok(Run { precuts, steps: many.steps() })
}

/// The judged faces against the truth.
///
/// # Errors
/// Settings that are refused.
pub fn agreement(
    case: &RegionCase,
    technique: &RegionTechnique,
    occluders: Option<&Arc<Occluders>>,
) -> Result<Agreement, SuiteError> {
    let run = run_of(case, technique, occluders, &judged_faces(case))?;
    let mut all = vec![Vec::new(); case.frames()[0].len()];
    for (face, precut) in case.truth()[0].iter().zip(run.precuts) {
        all[face.question] = precut;
    }
    Ok(case.judge(0, &all))
}

/// An evaluator for one thread.
pub fn evaluator(case: &RegionCase, settings: FacadeCluster) -> Evaluator {
    let town = &case.night().town;
    let clamp_m = town.world(true).clamp_m;
    Evaluator::new(Arc::clone(&town.lights), Arc::clone(&town.occluders), clamp_m, settings)
}

/// Nanoseconds of some faces on this thread.
pub fn ns(of: &mut dyn Precuts, asked: &[Asked<'_>]) -> f64 {
    let mut nodes = Vec::new();
    let start = Instant::now();
    for (cell, direction) in asked {
        of.precut(cell, *direction, &mut nodes);
    }
    start.elapsed().as_nanos() as f64
}

/// The least of several such times, after one run that is thrown away.
pub fn least_ns(of: &mut dyn Precuts, asked: &[Asked<'_>], times: usize) -> f64 {
    ns(of, asked);
    (0..times).map(|_| ns(of, asked)).fold(f64::INFINITY, f64::min)
}

/// Whether a value is about another.
pub fn is_about(value: f64, expected: f64) -> bool {
    (expected / ABOUT..=expected * ABOUT).contains(&value)
}

/// A statement that some light is never left out: of so many that are seen, so many were.
pub fn never(left_out: u64, seen: u64) -> Verdict {
    match (left_out, seen) {
        (0, 0) => Verdict::Open,
        (0, _) => Verdict::Reproduced,
        _ => Verdict::Refuted,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn about_is_within_a_factor() {
        assert!(is_about(1.5, 1.0) && is_about(0.67, 1.0));
        assert!(!is_about(1.6, 1.0) && !is_about(0.6, 1.0) && !is_about(f64::NAN, 1.0));
    }

    #[test]
    fn one_light_is_enough_to_contradict_never() {
        assert_eq!(never(0, 10), Verdict::Reproduced);
        assert_eq!(never(1, 10), Verdict::Refuted);
        assert_eq!(never(0, 0), Verdict::Open);
    }
}
