//! Lists of lights and the sum over all of them: finite reach, a cap, the naive loop.

use super::{
    super::LightsCase,
    support::{COARSE, FINE, PAIRS, RGB, VIEWS, ns, on_device, prepared, run, setting},
    verdict::{figure, judged, vote, vote_open},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Figure, Judged, Verdict},
    problem::{Form, Setting},
};
use dapple_metrics::stats::median;
use serde_json::json;

/// An error that shows: two RGB steps, what the source's own cuts reach.
const SEEN: f64 = 2.0 * RGB;

/// The cap the source names, and what is tried beyond it.
const CAP: u32 = 256;
const CAPS: [u32; 4] = [CAP, 1024, 4096, 16_384];

/// Radiance below which lights are left out.
const CUTOFFS: [f64; 3] = [FINE, COARSE, 4.0 * RGB];

/// Times a light costs in a list over what it costs in a plain sum: "unchanged" within this.
const UNCHANGED: f64 = 2.0;

/// A frame at 30 Hz, ms, and pixels of an image that is called real-time now.
const FRAME_MS: f64 = 1000.0 / 30.0;
const PIXELS: f64 = 1920.0 * 1080.0;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "conte-reach",
            statement: "What lights give that are left out one by one as too weak adds up to what is \
                        seen",
            place: "Conte 2018, section 2.4.4, of a method that keeps near lights alone; \
                    Olsson et al. 2012 need such a reach",
            method: "clustered shading of the generated city from the four points of view, lights \
                     ended where a white surface gets a quarter of an RGB step from them: met in a \
                     view if the error of the 99th percentile exceeds two steps, contradicted if \
                     nowhere. Errors at other cutoffs stand beside it; with a faded end they are \
                     larger",
            judge: Box::new(reach),
        },
        Claim {
            id: "conte-lists",
            statement: "Clustered shading lowers how many lights are evaluated; a light costs what it \
                        costs in the plain sum",
            place: "Conte 2018, section 2.3; Olsson et al. 2012",
            method: "a light's own time: images of 128 and of 384 columns with as many cells, so that \
                     lists cost the same; what the larger takes longer over the lights it evaluates \
                     more, of clustered shading (reach at a hundredth of an RGB step) over brute \
                     force, medians of 5 in turn. Met in a view if fewer lights are evaluated and \
                     each costs less than twice as much. Time with lists over all stands beside it: \
                     small images pay dearly for them",
            judge: Box::new(lists),
        },
        Claim {
            id: "conte-256",
            statement: "At most 256 lights a pixel are much too restrictive for a city",
            place: "Conte 2018, section 1.1",
            method: "the strongest 256 lights of every 8 x 8 pixels, the best that a cap can do, \
                     windows and all, from the four points of view: met in a view if the error of \
                     the 99th percentile exceeds two RGB steps. More lights stand beside it",
            judge: Box::new(cap),
        },
        Claim {
            id: "conte-nxm",
            statement: "The plain sum over up to 10^5.5 lights at every pixel is too slow for \
                        interaction: a frame may take 33 ms",
            place: "Conte 2018, sections 1.1 and 6",
            method: "brute force over the 245,106 windows of the largest city, street level, time a \
                     light and pixel scaled to 10^5.5 lights and 1920 x 1080 pixels, against 33 ms. \
                     Decided on a hardware device (the source renders on one); the processor's \
                     figures are told, and how many lights fit",
            judge: Box::new(naive),
        },
    ]
}

fn clustered(cutoff: f64, tile: u32) -> Result<Setting, SuiteError> {
    let knobs = [("cutoff", json!(cutoff)), ("tile", json!(tile))];
    setting("clustered/cut", Form::Cpu, &knobs)
}

/// Errors by view: all, some or none beyond what is not seen.
fn is_seen(errors: &[f64]) -> Verdict {
    if errors.iter().any(|error| !error.is_finite()) {
        return Verdict::Open;
    }
    vote(&errors.iter().map(|error| *error > SEEN).collect::<Vec<_>>())
}

fn in_steps(errors: &[f64]) -> Vec<f64> {
    errors.iter().map(|error| error / RGB).collect()
}

fn reach(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut errors) = (Vec::new(), Vec::new());
    for view in VIEWS {
        let case = prepared("city", view, &[])?;
        for cutoff in CUTOFFS {
            let run = run(&case, &clustered(cutoff, 8)?)?;
            let what = format!("{view}, up to {:.2} steps left out", cutoff / RGB);
            figures.extend([
                figure(format!("{what}: error_p99"), run.error("error_p99") / RGB, "RGB steps"),
                figure(format!("{what}: lights a pixel"), run.a_pixel(|w| w.lights), ""),
                figure(format!("{what}: list entries"), run.work.entries as f64, ""),
                figure(format!("{what}: missing light"), -run.bias, ""),
            ]);
            if cutoff == COARSE {
                errors.push(run.error("error_p99"));
            }
        }
    }
    let because = format!(
        "without lights below a quarter of a step, {:.1?} steps are missing, view by view",
        in_steps(&errors)
    );
    Ok(judged(is_seen(&errors), because, figures))
}

/// Lights evaluated, and time a light, of lists over the plain sum.
fn unchanged([lights, cost]: [f64; 2]) -> bool {
    lights < 1.0 && cost > 0.0 && cost < UNCHANGED
}

/// Median times of the settings, ns, each in turn with the others.
fn in_turn(case: &LightsCase<'_>, settings: &[Setting; 2]) -> Result<[f64; 2], SuiteError> {
    let [mut a, mut b] = [case.lighting(&settings[0])?, case.lighting(&settings[1])?];
    let (mut first, mut second) = (Vec::new(), Vec::new());
    ns(case, &mut *a)?;
    ns(case, &mut *b)?;
    for _ in 0..PAIRS {
        first.push(ns(case, &mut *a)?);
        second.push(ns(case, &mut *b)?);
    }
    Ok([median(&first)?, median(&second)?])
}

fn lists(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut holds, mut told) = (Vec::new(), Vec::new(), Vec::new());
    for view in VIEWS {
        let (mut times, mut lights) = (Vec::new(), Vec::new());
        for (width, tile) in [(128, 8), (384, 24)] {
            let case = prepared("city", view, &[("width", json!(width))])?;
            let settings = [clustered(FINE, tile)?, setting("brute-force", Form::Cpu, &[])?];
            let timed = in_turn(&case, &settings)?;
            let evaluated = run(&case, &settings[0])?.work.lights as f64;
            let shown = case.world().frames[0].points.iter().filter(|p| p.is_there()).count();
            let all = (shown * case.world().lights.len()) as f64;
            let cost = timed[0] / evaluated / (timed[1] / all);
            let what = format!("{view}, {width} columns");
            figures.push(figure(format!("{what}: time a light with lists, over all"), cost, ""));
            times.push(timed);
            lights.push([evaluated, all]);
        }
        let more = |of: &[[f64; 2]], which: usize| of[1][which] - of[0][which];
        let own = |which| more(&times, which) / more(&lights, which);
        let found = [lights[1][0] / lights[1][1], own(0) / own(1)];
        figures.extend([
            figure(format!("{view}: lights, over all"), found[0], ""),
            figure(format!("{view}: time a light, over the plain sum's"), found[1], ""),
        ]);
        told.push(format!("{:.3} at {:.1}", found[0], found[1]));
        holds.push(unchanged(found));
    }
    let because = format!("share of the lights at times their cost: {}", told.join(", "));
    Ok(judged(vote(&holds), because, figures))
}

fn cap(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut errors) = (Vec::new(), Vec::new());
    for view in VIEWS {
        let case = prepared("city", view, &[])?;
        for most in CAPS {
            let setting = setting("capped", Form::Cpu, &[("most", json!(most))])?;
            let run = run(&case, &setting)?;
            let what = format!("{view}, {most} lights");
            let error = run.error("error_p99");
            figures.push(figure(format!("{what}: error_p99"), error / RGB, "RGB steps"));
            figures.push(figure(format!("{what}: missing light"), -run.bias, ""));
            if most == CAP {
                errors.push(error);
            }
        }
    }
    let because = format!("256 lights miss {:.1?} RGB steps, view by view", in_steps(&errors));
    Ok(judged(is_seen(&errors), because, figures))
}

/// Nanoseconds a light and pixel of the plain sum.
fn ns_a_light(case: &LightsCase<'_>, form: Form) -> Result<f64, SuiteError> {
    let mut lighting = case.lighting(&setting("brute-force", form, &[])?)?;
    ns(case, &mut *lighting)?;
    let mut times = Vec::new();
    for _ in 0..3 {
        times.push(ns(case, &mut *lighting)?);
    }
    let shown = case.world().frames[0].points.iter().filter(|p| p.is_there()).count();
    Ok(median(&times)? / (case.world().lights.len() * shown.max(1)) as f64)
}

/// Milliseconds of a frame.
fn is_too_slow(ms: f64) -> Option<bool> {
    ms.is_finite().then_some(ms > FRAME_MS)
}

fn naive(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    const SCENE: &str = "city_15";
    let lights = 10_f64.powf(5.5);
    let given = [("width", json!(48)), ("truth_pixels", json!(1))];
    let mut figures: Vec<Figure> = Vec::new();
    let mut tell = |on: &str, one_ns: f64| {
        let ms = one_ns * lights * PIXELS * 1e-6;
        figures.extend([
            figure(format!("{on}: a light and pixel"), one_ns, "ns"),
            figure(format!("{on}: a frame"), ms, "ms"),
            figure(format!("{on}: lights that 33 ms pay for"), lights * FRAME_MS / ms, ""),
        ]);
        ms
    };
    let processor = tell("processor", ns_a_light(&*prepared(SCENE, "street", &given)?, Form::Cpu)?);
    let mut because = format!("{:.0} frames' time on the processor", processor / FRAME_MS);
    let mut verdict = Verdict::NeedsHardware;
    if let Some(gpu) = context.gpu {
        // A software device takes as long as it likes.
        let given =
            if context.hardware { [("width", json!(320)), given[1].clone()] } else { given };
        let case = on_device(SCENE, "street", &given, gpu)?;
        let device = tell("device", ns_a_light(&case, Form::Gpu)?);
        because = format!("{:.1} frames' time on the device, {because}", device / FRAME_MS);
        if context.hardware {
            verdict = vote_open(&[is_too_slow(device)]);
        }
    }
    Ok(judged(verdict, because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn errors_are_seen_everywhere_or_not() {
        assert_eq!(is_seen(&[0.1, 0.2]), Reproduced);
        assert_eq!(is_seen(&[0.1, 0.001]), Open);
        assert_eq!(is_seen(&[0.001]), Refuted);
        assert_eq!(is_seen(&[f64::NAN]), Open);
    }

    #[test]
    fn a_light_costs_the_same_or_not() {
        assert!(unchanged([0.5, 1.5]));
        assert!(!unchanged([1.0, 1.0]));
        assert!(!unchanged([0.5, 2.5]));
        assert!(!unchanged([0.5, -0.5]));
        assert!(!unchanged([0.5, f64::NAN]));
    }

    #[test]
    fn a_frame_is_too_slow_or_not() {
        assert_eq!(is_too_slow(100.0), Some(true));
        assert_eq!(is_too_slow(10.0), Some(false));
        assert_eq!(is_too_slow(f64::NAN), None);
    }
}
