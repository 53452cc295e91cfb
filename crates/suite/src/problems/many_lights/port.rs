//! What the fast forms are held to before they are timed.

use super::{case::LightsCase, settings};
use crate::{
    SuiteError,
    problem::{Checked, Form, Setting},
};
use dapple_many_lights::{Shaded, Technique, Work};
use glam::Vec3;
use std::collections::BTreeMap;

/// Frames held against the reference, from the path's start.
const FRAMES: usize = 2;

/// Light evaluations of the reference that a row may cost: brute force beyond it is held against the
/// truth, which is its reference.
const MOST_EVALUATIONS: usize = 200_000_000;

/// Relative difference beyond which a pixel counts as different.
const RELATIVE: f32 = 1e-3;

/// The same for pixels that are nearly black, linear.
const ABSOLUTE: f32 = 1e-5;

/// Share of pixels that may differ: those whose cut, list or draw falls the other way by rounding.
pub fn allowed(technique: &Technique) -> f64 {
    match technique {
        Technique::BruteForce => 0.0,
        // A draw that falls otherwise is another light; reuse spreads it.
        Technique::LightBvh(_) | Technique::StochasticLightcuts(_) => 0.02,
        Technique::Reservoirs(_) => 0.1,
        _ => 0.005,
    }
}

/// Counters of a path, by name.
pub fn counters(work: &Work, frames: usize) -> BTreeMap<String, u64> {
    [
        ("frames", frames as u64),
        ("pixels", work.pixels),
        ("node_visits", work.visits),
        ("bound_evaluations", work.bounds),
        ("light_evaluations", work.lights),
        ("cluster_evaluations", work.clusters),
        ("cut_nodes", work.cut),
        ("most_cut", work.most_cut),
        ("ended_cuts", work.ended),
        ("lane_visits", work.lane_visits),
        ("samples", work.samples),
        ("shadow_rays", work.rays),
        ("reused", work.reused),
        ("list_entries", work.entries),
    ]
    .into_iter()
    .filter(|(_, count)| *count > 0)
    .map(|(name, count)| (name.to_string(), count))
    .collect()
}

/// Holds a fast form against the reference under the same seed.
///
/// # Errors
/// A technique's.
pub fn hold(
    case: &LightsCase<'_>,
    setting: &Setting,
    checked: &mut Checked,
) -> Result<(), SuiteError> {
    let technique = settings::technique(setting)?;
    let frames = FRAMES.min(case.world().frames.len());
    if setting.form == Form::Reference
        || (technique == Technique::BruteForce
            && case.world().lights.len() * case.world().frames[0].points.len() * frames
                > MOST_EVALUATIONS)
    {
        return Ok(());
    }
    let reference = Setting { form: Form::Reference, ..setting.clone() };
    let (ours, theirs) = (radiance(case, setting, frames)?, radiance(case, &reference, frames)?);
    let differ = ours.iter().zip(&theirs).filter(|(a, b)| !alike(**a, **b)).count();
    let share = differ as f64 / ours.len().max(1) as f64;
    checked.port_errors.insert("pixels".into(), share);
    let most = allowed(&technique);
    if share > most {
        checked.violations.push(format!(
            "port: {:.3} % of the pixels differ from the reference by more than {RELATIVE} \
             (allowed: {} %)",
            100.0 * share,
            100.0 * most
        ));
    }
    Ok(())
}

/// Whether two radiances are the same but for rounding. What is not a number is like nothing.
pub fn alike(a: Vec3, b: Vec3) -> bool {
    let limit = ABSOLUTE.max(RELATIVE * b.abs().max_element());
    (a - b).abs().max_element() <= limit && a.is_finite()
}

fn radiance(
    case: &LightsCase<'_>,
    setting: &Setting,
    frames: usize,
) -> Result<Vec<Vec3>, SuiteError> {
    let mut lighting = case.lighting(setting)?;
    lighting.reset(case.seed())?;
    let mut shaded = Shaded::default();
    let mut all = Vec::new();
    for frame in 0..frames {
        lighting.shade(frame, false)?;
        lighting.read(&mut shaded)?;
        all.extend_from_slice(&shaded.radiance);
    }
    Ok(all)
}
