//! Reservoirs with reuse over space and time: what their source says.

use super::super::LightsCase;
use super::{
    rivals::rmse_of_last,
    support::{PAIRS, ns, prepared, run_of, setting, time_ratio},
    verdict::{figure, judged, vote, vote_open},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged},
    problem::{Form, Setting},
};
use serde_json::{Value, json};
use std::rc::Rc;

/// A walk, a turn, and an eye that stands still.
const PATHS: [&str; 3] = ["street", "turn", "close_ended"];

/// Frames until the last, which is judged; columns; twice the published 30 pixels of 1,920 columns.
const FRAMES: u32 = 8;
const WIDTH: u32 = 96;
const RADIUS_PX: f64 = 3.0;

/// Candidates a pixel and frame, as published.
const CANDIDATES: u32 = 32;

/// Seeds of one figure.
const SEEDS: u32 = 2;

/// Seeds of a bias.
const MANY_SEEDS: u32 = 12;

/// Candidates without reuse, and lights of the light hierarchy, that reuse is held against.
const MORE: u32 = 512;
const LIGHTS: u32 = 32;

/// What equal error is said to cost less, at least and at most.
const FASTER: [f64; 2] = [6.0, 60.0];

/// Standard errors beyond which a mean is off: with 11 degrees of freedom 1 in 700 is by chance.
const OFF: f64 = 4.0;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "bitterli-1",
            statement: "Reuse over space and time reaches the same error 6 to 60 times faster than \
                        without it",
            place: "Bitterli et al. 2020, abstract (said of other methods); not in Conte 2018",
            method: "the generated city along a walk, a turn and from a still eye, 96 columns, no \
                     shadows, 32 candidates, 5 neighbours within 3 pixels, up to 20 frames of \
                     history, unbiased: root mean squared error of the 8th frame over 2 seeds, \
                     against 512 candidates without any reuse. Squared errors of independent draws \
                     fall as their number grows, so equal error costs the ratio of frame times, 5 in \
                     turn, by that of squared errors. Met on a path from 6 on, contradicted if reuse \
                     is slower. A candidate here costs as much as shading by it, since no ray is \
                     traced",
            judge: Box::new(|_| faster("without reuse", MORE, alone)),
        },
        Claim {
            id: "bitterli-2",
            statement: "It reaches the same error 6 to 60 times faster than lights drawn by importance",
            place: "Bitterli et al. 2020, abstract; not in Conte 2018",
            method: "the same against the light hierarchy with 32 lights a pixel",
            judge: Box::new(|_| faster("by importance", LIGHTS, by_importance)),
        },
        Claim {
            id: "bitterli-3",
            statement: "Each of the two kinds of reuse lowers the error at equal candidates",
            place: "Bitterli et al. 2020, sections 3.2 and 4; not in Conte 2018",
            method: "the same error with neither, with neighbours alone, with history alone and with \
                     both: met on a path if each alone is below none and both below each alone. \
                     Beside it both with neighbours from 30 pixels away",
            judge: Box::new(both_help),
        },
        Claim {
            id: "bitterli-4",
            statement: "Counting candidates that could not have been drawn darkens the image; leaving \
                        them out of the count does not",
            place: "Bitterli et al. 2020, section 4; not in Conte 2018",
            method: "signed mean error over the paths' 8 frames under 12 seeds, of both variants: met \
                     on a path if the biased one is below 0 by more than 4 standard errors and the \
                     unbiased one within 4; contradicted if the unbiased one is not, or the biased \
                     one brightens by more than 4",
            judge: Box::new(darkens),
        },
    ]
}

fn path(view: &str) -> Result<Rc<LightsCase<'static>>, SuiteError> {
    prepared("city", view, &[("width", json!(WIDTH)), ("frames", json!(FRAMES))])
}

/// Reservoirs; whether neighbours and frames before are reused.
fn reservoirs(
    variant: &str,
    candidates: u32,
    neighbours: bool,
    temporal: bool,
    radius_px: f64,
) -> Result<Setting, SuiteError> {
    let knobs: [(&str, Value); 4] = [
        ("candidates", json!(candidates)),
        ("neighbours", json!(if neighbours { 5 } else { 0 })),
        ("temporal", json!(if temporal { "on" } else { "off" })),
        ("radius", json!(radius_px)),
    ];
    setting(&format!("reservoirs/{variant}"), Form::Cpu, &knobs)
}

fn alone(candidates: u32) -> Result<Setting, SuiteError> {
    reservoirs("unbiased", candidates, false, false, RADIUS_PX)
}

fn by_importance(samples: u32) -> Result<Setting, SuiteError> {
    setting("light-bvh", Form::Cpu, &[("samples", json!(samples))])
}

fn full() -> Result<Setting, SuiteError> {
    reservoirs("unbiased", CANDIDATES, true, true, RADIUS_PX)
}

/// How many times faster on one path.
fn as_fast(times: f64) -> Option<bool> {
    // Written so that what is not a number is refused.
    if times >= FASTER[0] {
        return Some(true);
    }
    if times >= 1.0 { None } else { Some(false) }
}

/// Time that a rival takes for our error over ours: its time over ours, and both errors.
fn at_equal_error(time: f64, rival: f64, ours: f64) -> f64 {
    time * (rival / ours).powi(2)
}

fn faster(
    name: &str,
    count: u32,
    rival: fn(u32) -> Result<Setting, SuiteError>,
) -> Result<Judged, SuiteError> {
    let (mut figures, mut seen, mut told) = (Vec::new(), Vec::new(), Vec::new());
    let (ours, rival) = (full()?, rival(count)?);
    for view in PATHS {
        let case = path(view)?;
        let error = rmse_of_last(&case, &ours, SEEDS)?;
        let other = rmse_of_last(&case, &rival, SEEDS)?;
        let time = time_ratio(&case, &rival, &ours, PAIRS)?.median;
        let times = at_equal_error(time, other, error);
        figures.extend([
            figure(format!("{view}: rmse with reuse"), error, ""),
            figure(format!("{view}: rmse, {count} {name}"), other, ""),
            figure(format!("{view}: time, {count} {name} over reuse"), time, ""),
            figure(format!("{view}: time at equal error, {name} over reuse"), times, ""),
        ]);
        told.push(format!("{times:.1}"));
        seen.push(as_fast(times));
    }
    let because = format!(
        "at equal error lights drawn {name} take {} times as long, path by path",
        told.join(", ")
    );
    Ok(judged(vote_open(&seen), because, figures))
}

/// Errors with no reuse, neighbours alone, history alone, both.
fn helps([none, space, time, both]: [f64; 4]) -> bool {
    space < none && time < none && both < space && both < time
}

fn both_help(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut all, mut told) = (Vec::new(), Vec::new(), Vec::new());
    for view in PATHS {
        let case = path(view)?;
        let mut rmse = |name: &str, setting: Setting| -> Result<f64, SuiteError> {
            let rmse = rmse_of_last(&case, &setting, SEEDS)?;
            let mut lighting = case.lighting(&setting)?;
            let frame_ns = ns(&case, &mut *lighting)? / f64::from(FRAMES);
            figures.push(figure(format!("{view}, {name}: rmse"), rmse, ""));
            figures.push(figure(format!("{view}, {name}: a frame"), frame_ns / 1e6, "ms"));
            Ok(rmse)
        };
        let of = |space, time| reservoirs("unbiased", CANDIDATES, space, time, RADIUS_PX);
        let found = [
            rmse("no reuse", of(false, false)?)?,
            rmse("neighbours", of(true, false)?)?,
            rmse("history", of(false, true)?)?,
            rmse("both", of(true, true)?)?,
        ];
        rmse("both, 30 pixels", reservoirs("unbiased", CANDIDATES, true, true, 30.0)?)?;
        told.push(format!(
            "{:.2}, {:.2} and {:.2}",
            found[1] / found[0],
            found[2] / found[0],
            found[3] / found[0]
        ));
        all.push(helps(found));
    }
    let because = format!(
        "of the error without reuse neighbours, history and both leave {}",
        told.join("; ")
    );
    Ok(judged(vote(&all), because, figures))
}

/// Mean signed error over the mean truth, and the same in standard errors, over seeds.
fn signed(case: &LightsCase<'_>, setting: &Setting) -> Result<[f64; 2], SuiteError> {
    let mut lighting = case.lighting(setting)?;
    let mut biases = Vec::new();
    for seed in 1..=MANY_SEEDS {
        biases.push(run_of(case, &mut *lighting, case.seed().wrapping_add(seed))?.bias);
    }
    Ok(in_standard_errors(&biases))
}

/// The mean of some values, and the same over its standard error.
fn in_standard_errors(values: &[f64]) -> [f64; 2] {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0);
    // What repeats exactly is allowed rounding.
    [mean, mean / (variance / count).sqrt().max(1e-6)]
}

/// Signed errors of the biased and of the unbiased variant, in standard errors.
fn is_darker([biased, unbiased]: [f64; 2]) -> Option<bool> {
    // Written so that what is not a number is refused.
    if !(unbiased.abs() <= OFF && biased <= OFF) {
        return Some(false);
    }
    if biased < -OFF { Some(true) } else { None }
}

fn darkens(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut seen, mut told) = (Vec::new(), Vec::new(), Vec::new());
    for view in PATHS {
        let case = path(view)?;
        let mut off = |variant: &str| -> Result<[f64; 2], SuiteError> {
            let setting = reservoirs(variant, CANDIDATES, true, true, RADIUS_PX)?;
            let [mean, z] = signed(&case, &setting)?;
            figures.push(figure(format!("{view}, {variant}: mean error"), mean, ""));
            figures.push(figure(format!("{view}, {variant}: in standard errors"), z, ""));
            Ok([mean, z])
        };
        let (biased, unbiased) = (off("biased")?, off("unbiased")?);
        seen.push(is_darker([biased[1], unbiased[1]]));
        told.push(format!("{:+.1e} ({:+.1e})", biased[0], unbiased[0]));
    }
    let because = format!("mean error of the truth, biased (unbiased): {}", told.join(", "));
    Ok(judged(vote_open(&seen), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reuse_is_as_fast_as_said_or_not() {
        assert_eq!(as_fast(7.0), Some(true));
        assert_eq!(as_fast(3.0), None);
        assert_eq!(as_fast(0.9), Some(false));
        assert_eq!(as_fast(f64::NAN), Some(false));
    }

    #[test]
    fn half_the_error_takes_four_times_as_long() {
        assert_eq!(at_equal_error(2.0, 0.5, 0.25), 8.0);
        assert_eq!(as_fast(at_equal_error(1.0, f64::NAN, 1.0)), Some(false));
    }

    #[test]
    fn reuse_helps_in_both_ways_or_not() {
        assert!(helps([4.0, 2.0, 3.0, 1.0]));
        assert!(!helps([4.0, 5.0, 3.0, 1.0]));
        assert!(!helps([4.0, 2.0, 3.0, 2.5]));
        assert!(!helps([4.0, 2.0, 3.0, f64::NAN]));
    }

    #[test]
    fn the_biased_one_is_darker_or_not() {
        assert_eq!(is_darker([-9.0, 1.0]), Some(true));
        assert_eq!(is_darker([-2.0, 1.0]), None);
        assert_eq!(is_darker([9.0, 1.0]), Some(false));
        assert_eq!(is_darker([-9.0, -5.0]), Some(false));
        assert_eq!(is_darker([f64::NAN, 0.0]), Some(false));
    }

    #[test]
    fn means_are_told_in_their_standard_errors() {
        let [mean, z] = in_standard_errors(&[1.0, 3.0]);
        // Variance 2, standard error 1.
        assert_eq!((mean, z), (2.0, 2.0));
    }
}
