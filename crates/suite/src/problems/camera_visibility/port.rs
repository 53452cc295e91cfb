//! What all forms check before they are timed.

use super::{case::VisibilityCase, subject};
use crate::{
    SuiteError,
    problem::{Checked, Form, Setting},
};
use dapple_occlusion::camera::{Frame, Image, Work};
use std::collections::{BTreeMap, BTreeSet};

/// Frames held against the reference, from the path's start: later ones depend on all before.
const FRAMES: usize = 2;

/// Share of the pixels that may differ from the reference's: those that an edge passes within the
/// rasteriser's sub-pixel step of their centre. City walls have several edges a pixel far away.
const IDS: f64 = 0.03;

/// Share of the objects drawn that may differ from the reference's: boxes that show a sample or none
/// as an edge passes its centre, and all that is below them. Far down a street of 24 blocks these are
/// 6 in a hundred. What is not drawn though it shows is judged by itself, at no tolerance.
const DRAWN: f64 = 0.15;

/// Pixels in which two images differ beyond ties.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Differences {
    /// Of lesser reversed depth: something is missing.
    pub deeper: u64,
    /// Of greater: something is there that was not.
    pub nearer: u64,
    /// Of another object or triangle, at whatever depth.
    pub ids: u64,
}

/// How `image` differs from `full`.
pub fn differences(image: &Image, full: &Image) -> Differences {
    let mut found = Differences::default();
    for (a, b) in image.depth.iter().zip(&full.depth) {
        found.deeper += u64::from(a < b);
        found.nearer += u64::from(a > b);
    }
    found.ids = image.ids.iter().zip(&full.ids).filter(|(a, b)| a != b).count() as u64;
    found
}

/// An object that is in the list twice.
pub fn twice(drawn: &[u32]) -> Option<u32> {
    let mut seen = BTreeSet::new();
    drawn.iter().copied().find(|object| !seen.insert(*object))
}

/// Counters of a path, by name.
pub fn counters(work: &Work, frames: usize) -> BTreeMap<String, u64> {
    [
        ("frames", frames as u64),
        ("nodes", work.nodes),
        ("queries", work.queries),
        ("query_boxes", work.boxes),
        ("batches", work.batches),
        ("stalls", work.stalls),
        ("wasted_queries", work.wasted),
        ("draws", work.draws),
        ("triangles", work.triangles),
        ("pyramid_texels", work.pyramid_texels),
        ("dispatches", work.dispatches),
    ]
    .into_iter()
    .map(|(name, value)| (name.to_string(), value))
    .collect()
}

/// Holds the form's images of everything, and what the technique draws in the path's first frames,
/// against the reference.
///
/// # Errors
/// The renderer's.
pub fn hold(
    case: &VisibilityCase<'_>,
    setting: &Setting,
    full: &[Image],
    checked: &mut Checked,
) -> Result<(), SuiteError> {
    if setting.form == Form::Reference {
        return Ok(());
    }
    let reference = Setting { form: Form::Reference, ..setting.clone() };
    let expected = case.everything_at_start(Form::Reference, FRAMES)?;
    let (mut ids, mut pixels) = (0, 0);
    for (image, full) in expected.iter().zip(full).take(FRAMES) {
        ids += differences(full, image).ids;
        pixels += image.ids.len() as u64;
    }
    let share = ids as f64 / pixels.max(1) as f64;
    checked.port_errors.insert("image_ids".into(), share);
    if share > IDS {
        checked.violations.push(format!(
            "port: {:.2} % of pixels show another triangle than the reference (allowed: {} %)",
            100.0 * share,
            100.0 * IDS
        ));
    }
    let polled = setting.knobs.get("readiness").is_some_and(|r| r == "polled");
    let reference = match polled {
        false => reference,
        true => {
            let mut knobs = reference.knobs.clone();
            knobs.insert("readiness".into(), "modelled".into());
            Setting { knobs, ..reference }
        }
    };
    let (ours, theirs) = (drawn(case, setting, FRAMES)?, drawn(case, &reference, FRAMES)?);
    let differ = ours.symmetric_difference(&theirs).count();
    let share = differ as f64 / ours.union(&theirs).count().max(1) as f64;
    checked.port_errors.insert("drawn".into(), share);
    // Answers that come as they come decide what is asked next, not what shows.
    if share > DRAWN && !polled {
        checked.violations.push(format!(
            "port: {:.2} % of the objects drawn are not those of the reference (allowed: {} %)",
            100.0 * share,
            100.0 * DRAWN
        ));
    }
    Ok(())
}

/// (frame, object) pairs drawn in the first frames.
fn drawn(
    case: &VisibilityCase<'_>,
    setting: &Setting,
    frames: usize,
) -> Result<BTreeSet<(usize, u32)>, SuiteError> {
    let mut subject = subject::PathSubject::new(case, setting)?;
    let mut pairs = BTreeSet::new();
    for index in 0..frames.min(case.views().len()) {
        subject.run(index)?;
        let out: &Frame = subject.out();
        pairs.extend(out.drawn.iter().map(|object| (index, *object)));
    }
    Ok(pairs)
}
