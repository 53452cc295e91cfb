//! What saves evaluations, one after the other: table 5.II.

use super::{
    super::NightCase,
    support::{
        KEPT, PAIRS, about_times, behind_all_objects, front, mean, night, prepared, standing,
        tests as cluster_tests, walking,
    },
    verdict::{figure, judged, paired},
};
use crate::{
    SuiteError,
    claims::{Claim, Figure, Judged, Verdict},
};
use dapple_night_city::Front;
use serde_json::json;
use std::{cell::RefCell, rc::Rc};

/// The source's table is of the close-ended street.
const VIEW: (&str, &str) = ("city", "close_ended");

/// Frames of a camera that stands: the source's mean is over so many. The first half, while spans are
/// drawn, is left out: it belongs to a cold start.
const FRAMES: usize = 120;

/// Frames of a walk, for the figure beside.
const WALK: u32 = 60;

/// The source's ratios: only buildings hide, weak clusters are culled, precuts are kept, all three.
const SAID: [f64; 4] = [2.991, 1.148, 3.764, 12.9];

pub fn claims() -> Vec<Claim> {
    let claim = |id, statement, part: usize, method| Claim {
        id,
        statement,
        place: "Conte 2018, section 5.2 and table 5.II",
        method,
        judge: Box::new(move |_| judge(part)),
    };
    vec![
        claim(
            "conte-H5.4-occluders",
            "If buildings alone hide lights, frames take a third of the time",
            0,
            "close-ended street of the 6 x 6 city, nothing kept, threshold 0: time to find the lists of \
             a frame with every storey of every facade as an occluder beside the buildings, over that \
             with the buildings alone, frames in turn. Shading is the same by both and left out: the \
             source's frames end with the device, ours would with the processor that does both. 2 and \
             more is met (3 within a factor of 1.5), no gain contradicts. Occluders projected and \
             shadows compared stand beside",
        ),
        claim(
            "conte-H5.4-irradiance",
            "Culling clusters that are too weak saves a seventh",
            1,
            "the same with buildings alone at threshold 0 over threshold 1/1020. Any gain is met, as \
             1.15 within a factor of 1.5 allows none below 1; no gain contradicts, and what is within the \
             median's own deviation is open. Tests of clusters, \
             which decide where time does, stand beside",
        ),
        claim(
            "conte-H5.4-coherence",
            "Precuts kept for 50 frames make frames almost four times as fast",
            2,
            "evaluations a frame of a camera that stands, of which each frame finds all, over those \
             that are found where precuts are kept for 50: frames 61 to 120, the first 60 being its \
             start. 3.76 within a factor of 1.5, or more, is met. The source's ratio is of whole frames, and \
             bounded by their shading. A walk's evaluations and times stand beside",
        ),
        claim(
            "conte-H5.4",
            "All three together make frames more than ten times as fast",
            3,
            "time to find the lists of a frame with all objects, threshold 0 and nothing kept, over the \
             mean of frames 61 to 120 with buildings, 1/1020 and 50 frames. 12.9 within a factor of 1.5, \
             or more, is met, no gain contradicts",
        ),
    ]
}

/// What the table's rows came out as.
struct Stages {
    /// With what their medians may be off.
    ratios: [(f64, f64); 4],
    figures: Vec<Figure>,
}

/// Time, tests and projections of a frame by each front, in turn.
fn gain(
    what: &str,
    slow: &mut Front<'static>,
    fast: &mut Front<'static>,
    figures: &mut Vec<Figure>,
) -> Result<(f64, f64), SuiteError> {
    let mut counts = Vec::new();
    for front in [&mut *slow, &mut *fast] {
        let before = front.steps();
        front.prepare(0)?;
        let after = front.steps();
        counts.push([
            (cluster_tests(&after) - cluster_tests(&before)) as f64,
            (after.projected - before.projected) as f64,
            (after.compared - before.compared) as f64,
        ]);
    }
    let names = ["tests of clusters", "occluders projected", "shadows compared"];
    for (index, name) in names.into_iter().enumerate() {
        let ratio = counts[0][index] / counts[1][index].max(1.0);
        figures.push(figure(format!("{what}: {name}"), ratio, "times"));
    }
    let one = |front: &mut Front<'static>| Ok(front.prepare(0)?.region_ns as f64);
    let time = paired(PAIRS, || one(slow), || one(fast))?;
    figures.push(figure(format!("{what}: time to find lists"), time.median, "times"));
    figures.push(figure(format!("{what}: the same, MAD"), time.mad, ""));
    Ok((time.median, time.mad))
}

/// Evaluations and times of a walk, all found anew over kept.
fn walk(figures: &mut Vec<Figure>) -> Result<(), SuiteError> {
    let case = prepared(VIEW.0, "tour", &[("frames", json!(WALK)), ("width", json!(48))])?;
    let mut both = Vec::new();
    for validity in [1, KEPT] {
        let mut front = front(&case, &night(&[("validity", json!(validity))])?)?;
        both.push(walking(&case, &mut front)?);
    }
    let evaluations = |at: usize| mean(&both[at], |p| p.counts.evaluations);
    let time = |at: usize| mean(&both[at], |p| p.region_ns);
    let later = mean(&both[1][1..], |p| p.counts.evaluations);
    figures.extend([
        figure("walk: evaluations, all over kept", evaluations(0) / evaluations(1), "times"),
        figure("walk: evaluations a frame after the first, kept", later, ""),
        figure("walk: time to find lists, all over kept", time(0) / time(1), "times"),
    ]);
    Ok(())
}

fn measure() -> Result<Stages, SuiteError> {
    let mut figures = Vec::new();
    let objects: NightCase<'_> = behind_all_objects(VIEW.0, VIEW.1, &[])?;
    let case = prepared(VIEW.0, VIEW.1, &[])?;
    let every = ("validity", json!(1));
    let all = night(&[every.clone(), ("threshold", json!(0.0))])?;
    let culled = night(std::slice::from_ref(&every))?;
    let kept = night(&[("validity", json!(KEPT))])?;
    let mut first = front(&objects, &all)?;
    let mut second = front(&case, &all)?;
    let mut third = front(&case, &culled)?;
    let buildings = gain("buildings alone", &mut first, &mut second, &mut figures)?;
    let weak = gain("weak culled", &mut second, &mut third, &mut figures)?;
    let each = standing(&mut third, 3)?;
    let mut fourth = front(&case, &kept)?;
    let frames = standing(&mut fourth, FRAMES)?;
    let later = &frames[FRAMES / 2..];
    let evaluations = [&each[..], later].map(|f| mean(f, |p| p.counts.evaluations));
    let coherence = evaluations[0] / evaluations[1].max(1.0 / FRAMES as f64);
    let time = |frames: &[dapple_night_city::Prepared]| mean(frames, |p| p.region_ns);
    let kept_time = time(&each) / time(later).max(1.0);
    let all_three = time(&standing(&mut first, 3)?) / time(later).max(1.0);
    figures.extend([
        figure("kept: evaluations of a frame that finds all", evaluations[0], ""),
        figure("kept: evaluations a frame, 50 frames", evaluations[1], ""),
        figure("kept: evaluations", coherence, "times"),
        figure("kept: time to find lists", kept_time, "times"),
        figure("all three: time to find lists", all_three, "times"),
    ]);
    walk(&mut figures)?;
    Ok(Stages { ratios: [buildings, weak, (coherence, 0.0), (all_three, 0.0)], figures })
}

fn decide(part: usize, (ratio, off): (f64, f64)) -> Verdict {
    if (ratio - 1.0).abs() < off {
        return Verdict::Open;
    }
    SAID.get(part).map_or(Verdict::Open, |said| about_times(ratio, *said))
}

fn judge(part: usize) -> Result<Judged, SuiteError> {
    thread_local! {
        static MADE: RefCell<Option<Rc<Stages>>> = const { RefCell::new(None) };
    }
    let made = match MADE.with_borrow(Option::clone) {
        Some(made) => made,
        None => {
            let made = Rc::new(measure()?);
            MADE.set(Some(Rc::clone(&made)));
            made
        }
    };
    let prefixes: &[&str] = match part {
        0 => &["buildings"],
        1 => &["weak"],
        2 => &["kept", "walk"],
        _ => &[""],
    };
    let of_part = |f: &&Figure| prefixes.iter().any(|prefix| f.what.starts_with(prefix));
    let figures = made.figures.iter().filter(of_part).cloned().collect();
    let (ratio, off) = made.ratios[part.min(3)];
    let because = format!("{ratio:.2} times, where the source has {:.2}", SAID[part.min(3)]);
    Ok(judged(decide(part, (ratio, off)), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn each_saving_is_met_or_not() {
        let of = |part, ratio| decide(part, (ratio, 0.0));
        assert_eq!([2.0, 1.2, 0.9].map(|r| of(0, r)), [Reproduced, Open, Refuted]);
        assert_eq!([1.1, 1.0].map(|r| of(1, r)), [Reproduced, Refuted]);
        assert_eq!([50.0, 2.0, 1.0].map(|r| of(2, r)), [Reproduced, Open, Refuted]);
        assert_eq!([9.0, 8.0, f64::NAN].map(|r| of(3, r)), [Reproduced, Open, Refuted]);
        assert_eq!([decide(1, (1.1, 0.2)), of(4, 9.0)], [Open, Open]);
    }
}
