//! What the source says of the images: of either tree, and against all lights.

use super::super::errors::srgb_steps;
use super::{
    cuts::{TABLE, lit, tree},
    support::{COARSE, FINE, RGB, VIEWS, cut, prepared, run, setting},
    verdict::{all_of, figure, judged, vote},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
    problem::Form,
};
use dapple_many_lights::{
    BoundForm, Frame,
    cut::{Receiver, Rule, walk},
};
use dapple_metrics::stats::percentile;
use glam::{DVec3, Vec3};

/// The city's thresholds from the first that the source names to the one it times.
const THRESHOLDS: [f64; 4] = [RGB, COARSE, RGB / 10.0, FINE];

/// Error of the cut, in RGB steps, that the source saw at most.
const STEPS: f64 = 2.0;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "conte-H3.5",
            statement: "From the root, both trees converge to the same image",
            place: "Conte 2018, figure 5.4",
            method: "R4 at T = 1/25500 by the revised and by Walter's tree, all pixels of four views \
                     of the city, 128 x 72: the greatest difference of a channel, linear, is at most \
                     1/255 in every view",
            judge: Box::new(both_trees),
        },
        Claim {
            id: "conte-F5.4",
            statement: "Both images are completely identical",
            place: "Conte 2018, caption of figure 5.4",
            method: "the same as 8-bit sRGB at the source's view: no channel differs by a step",
            judge: Box::new(identical),
        },
        Claim {
            id: "conte-H3.7",
            statement: "A cut is within two RGB steps of all lights",
            place: "Conte 2018, figure 5.5",
            method: "R4 at T = 1/25500 by the revised tree: against brute force from the root in four \
                     views of the city, 128 x 72, and against all lights of the precuts (T = 0) at \
                     the source's view. The greatest error of a channel, over all pixels, linear: \
                     at most 2/255 everywhere. Steps of 8-bit sRGB, which are finer in the dark, \
                     have to be at most 2 too, or it stays open which the source means. Beside it, \
                     the same at coarser thresholds",
            judge: Box::new(two_steps),
        },
        Claim {
            id: "conte-F5.5",
            statement: "The greatest error of a cut is on the street, not on facades",
            place: "Conte 2018, figure 5.5d",
            method: "errors of the cut from precuts at the source's view against all lights of \
                     them, at T = 1/255 and 1/25500, as the source does not give its own: the \
                     greatest where the normal is within 45 degrees of up, over the greatest \
                     elsewhere. Above 1.5 at both is met, below 1/1.5 at either contradicts",
            judge: Box::new(street),
        },
        Claim {
            id: "conte-H3.10",
            statement: "The summed bound of a pixel's clusters can exceed the threshold, yet the \
                        image is close to the fully subdivided one",
            place: "Conte 2018, section 3.2",
            method: "256 pixels of each of four views, the revised tree, T = 1/1020 and 1/25500, f64: \
                     sum of the bounds of a cut's clusters, and its error against all lights. Met if \
                     at most pixels with clusters the sum exceeds T and 99 % of the errors are within \
                     1.5 T; contradicted if the sum exceeds T nowhere, or errors exceed 10 T. \
                     All views and both thresholds must agree",
            judge: Box::new(summed),
        },
    ]
}

/// The greatest difference of a channel, linear and in steps of 8-bit sRGB.
fn most<'a>(pairs: impl Iterator<Item = (&'a Vec3, &'a Vec3)>) -> [f64; 2] {
    let mut most = [0.0_f64; 2];
    for (a, b) in pairs {
        let (a, b) = (a.as_dvec3(), b.as_dvec3());
        let steps = (srgb_steps(a) - srgb_steps(b)).abs().max_element();
        most = [most[0].max((a - b).abs().max_element()), most[1].max(steps)];
    }
    most
}

/// The greatest differences of both trees in a view.
fn trees_differ(view: &str) -> Result<[f64; 2], SuiteError> {
    let case = prepared(TABLE.0, view, &[])?;
    let (ours, theirs) = (run(&case, &cut("city", FINE)?)?, run(&case, &cut("original", FINE)?)?);
    Ok(most(ours.frames[0].radiance.iter().zip(&theirs.frames[0].radiance)))
}

fn both_trees(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut holds) = (Vec::new(), Vec::new());
    for view in VIEWS {
        let [linear, steps] = trees_differ(view)?;
        figures.push(figure(format!("{view}: greatest difference"), linear / RGB, "1/255"));
        figures.push(figure(format!("{view}: greatest difference"), steps, "sRGB steps"));
        holds.push(linear <= RGB);
    }
    let because = format!("within 1/255 in {} views", super::verdict::count(&holds));
    Ok(judged(vote(&holds), because, figures))
}

/// Steps of 8-bit sRGB that differ.
fn is_identical(steps: f64) -> Verdict {
    if steps == 0.0 { Verdict::Reproduced } else { Verdict::Refuted }
}

fn identical(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let [linear, steps] = trees_differ(TABLE.1)?;
    let figures = vec![
        figure("greatest difference", linear / RGB, "1/255"),
        figure("greatest difference", steps, "sRGB steps"),
    ];
    let because = format!("a channel differs by up to {steps} steps of 8-bit sRGB");
    Ok(judged(is_identical(steps), because, figures))
}

/// The greatest error, linear and in steps of 8-bit sRGB.
fn within([linear, steps]: [f64; 2]) -> Verdict {
    // Written so that a NaN contradicts.
    if linear <= STEPS * RGB && steps <= STEPS {
        Verdict::Reproduced
    } else if linear <= STEPS * RGB {
        Verdict::Open
    } else {
        Verdict::Refuted
    }
}

fn two_steps(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let mut figures = Vec::new();
    // By threshold: all views from the root, then the source's from precuts.
    let mut all: Vec<Vec<[f64; 2]>> = vec![Vec::new(); THRESHOLDS.len()];
    for view in VIEWS {
        let case = prepared(TABLE.0, view, &[])?;
        let exact = run(&case, &setting("brute-force", Form::Cpu, &[])?)?;
        for (threshold, errors) in THRESHOLDS.iter().zip(&mut all) {
            let ours = run(&case, &cut("city", *threshold)?)?;
            errors.push(most(ours.frames[0].radiance.iter().zip(&exact.frames[0].radiance)));
        }
    }
    let exact = lit("city", 0.0, true)?;
    for (threshold, errors) in THRESHOLDS.iter().zip(&mut all) {
        let ours = lit("city", *threshold, true)?;
        errors.push(most(ours.frames[0].radiance.iter().zip(&exact.frames[0].radiance)));
    }
    let names = VIEWS.iter().map(|view| (*view).to_string());
    let names: Vec<String> = names.chain(["precuts".to_string()]).collect();
    let mut enough = None;
    for (threshold, errors) in THRESHOLDS.iter().zip(&all) {
        for (name, [linear, steps]) in names.iter().zip(errors) {
            let what = format!("{name}, T = 1/{:.0}: greatest error", 1.0 / threshold);
            figures.push(figure(what.clone(), linear / RGB, "1/255"));
            figures.push(figure(what, *steps, "sRGB steps"));
        }
        if errors.iter().all(|[linear, _]| *linear <= STEPS * RGB) {
            enough = enough.or(Some(1.0 / threshold));
        }
    }
    let fine = all.last().map_or(&[][..], Vec::as_slice);
    let verdicts: Vec<Verdict> = fine.iter().map(|errors| within(*errors)).collect();
    let [linear, steps] = fine.iter().fold([0.0_f64; 2], |[a, b], [c, d]| [a.max(*c), b.max(*d)]);
    let because = format!(
        "at T = 1/25500 errors reach {:.2} / 255 and {steps} steps of 8-bit sRGB; {}",
        linear / RGB,
        enough.map_or("no threshold here keeps 2/255".into(), |t| format!(
            "T = 1/{t:.0} keeps 2/255"
        ))
    );
    Ok(judged(all_of(&verdicts), because, figures))
}

/// The greatest error on what faces up, over the greatest elsewhere.
fn on_the_street(ratio: f64) -> Verdict {
    if ratio > 1.5 {
        Verdict::Reproduced
    } else if ratio >= 1.0 / 1.5 {
        Verdict::Open
    } else {
        Verdict::Refuted
    }
}

fn street(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let case = prepared(TABLE.0, TABLE.1, &[])?;
    let exact = lit("city", 0.0, true)?;
    let Frame { points, .. } = &case.world().frames[0];
    let (mut figures, mut verdicts, mut told) = (Vec::new(), Vec::new(), Vec::new());
    for threshold in [RGB, FINE] {
        let ours = lit("city", threshold, true)?;
        let greatest = |is_up: bool| {
            let pairs = ours.frames[0].radiance.iter().zip(&exact.frames[0].radiance);
            let of = points
                .iter()
                .zip(pairs)
                .filter(|(p, _)| p.is_there() && (p.normal.y > 0.5_f32.sqrt()) == is_up);
            most(of.map(|(_, pair)| pair))[0]
        };
        let (up, other) = (greatest(true), greatest(false));
        let ratio = up / other.max(f64::MIN_POSITIVE);
        let at = format!("T = 1/{:.0}", 1.0 / threshold);
        figures.extend([
            figure(format!("{at}: greatest error, street"), up / RGB, "1/255"),
            figure(format!("{at}: greatest error, facades"), other / RGB, "1/255"),
            figure(format!("{at}: street over facades"), ratio, ""),
        ]);
        told.push(format!("{ratio:.2} at {at}"));
        verdicts.push(on_the_street(ratio));
    }
    let because = format!("the street's greatest error over the facades' is {}", told.join(", "));
    Ok(judged(all_of(&verdicts), because, figures))
}

/// Share of pixels whose summed bound exceeds T, and 99th percentile of errors over T.
fn close_in_practice(exceed: f64, error: f64) -> Verdict {
    if exceed > 0.5 && error <= 1.5 {
        Verdict::Reproduced
    } else if exceed > 0.0 && error <= 10.0 {
        Verdict::Open
    } else {
        Verdict::Refuted
    }
}

/// Of pixels with clusters: share whose summed bound exceeds T, median of that sum over T, errors
/// over T at the 99th percentile and at most.
fn sums(view: &str, threshold: f64) -> Result<[f64; 4], SuiteError> {
    let case = prepared(TABLE.0, view, &[])?;
    let (world, tree) = (case.world(), tree(&case, "city")?);
    let (mut bounds, mut errors) = (Vec::new(), Vec::new());
    for (pixel, exact) in case.truth().frame(0) {
        let point = &world.frames[0].points[pixel as usize];
        let receiver = Receiver { point, form: BoundForm::Cheap, clamp_m: world.clamp_m };
        let (mut bound, mut sum) = (0.0, DVec3::ZERO);
        walk(&tree, &tree.roots, |_, node| {
            let look = Rule::Absolute(threshold).look(node, &receiver);
            if look.taken {
                bound += look.bound;
                sum += look.estimate;
            }
            look.taken
        });
        if bound > 0.0 {
            bounds.push(bound / threshold);
            errors.push((sum - exact).abs().max_element() / threshold);
        }
    }
    let exceed = bounds.iter().filter(|b| **b > 1.0).count() as f64 / bounds.len().max(1) as f64;
    Ok([exceed, percentile(&bounds, 0.5)?, percentile(&errors, 0.99)?, percentile(&errors, 1.0)?])
}

fn summed(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut verdicts, mut worst) = (Vec::new(), Vec::new(), 0.0_f64);
    for view in VIEWS {
        for threshold in [COARSE, FINE] {
            let [exceed, sum, error, greatest] = sums(view, threshold)?;
            let at = format!("{view}, T = 1/{:.0}", 1.0 / threshold);
            figures.extend([
                figure(format!("{at}: pixels whose summed bound exceeds T"), 100.0 * exceed, "%"),
                figure(format!("{at}: summed bound, median"), sum, "T"),
                figure(format!("{at}: error, 99th percentile"), error, "T"),
                figure(format!("{at}: error, greatest"), greatest, "T"),
            ]);
            worst = worst.max(error);
            verdicts.push(close_in_practice(exceed, error));
        }
    }
    let because = format!("99 % of the errors stay within {worst:.2} T in every view");
    Ok(judged(all_of(&verdicts), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn differences_are_of_the_worst_channel() {
        let pairs = [(Vec3::ZERO, Vec3::new(0.0, 0.25, 0.0)), (Vec3::ONE, Vec3::ONE)];
        assert_eq!(most(pairs.iter().map(|(a, b)| (a, b))), [0.25, 137.0]);
        assert_eq!(is_identical(0.0), Reproduced);
        assert_eq!(is_identical(1.0), Refuted);
    }

    #[test]
    fn errors_are_within_two_steps_or_not() {
        assert_eq!(within([RGB, 2.0]), Reproduced);
        assert_eq!(within([RGB, 9.0]), Open);
        assert_eq!(within([3.0 * RGB, 2.0]), Refuted);
        assert_eq!(within([f64::NAN, 0.0]), Refuted);
    }

    #[test]
    fn errors_are_on_the_street_or_not() {
        assert_eq!(on_the_street(2.0), Reproduced);
        assert_eq!(on_the_street(1.0), Open);
        assert_eq!(on_the_street(0.1), Refuted);
        assert_eq!(on_the_street(f64::NAN), Refuted);
    }

    #[test]
    fn sums_exceed_and_errors_do_not_or_otherwise() {
        assert_eq!(close_in_practice(0.9, 1.0), Reproduced);
        assert_eq!(close_in_practice(0.2, 1.0), Open);
        assert_eq!(close_in_practice(0.9, 5.0), Open);
        assert_eq!(close_in_practice(0.9, 50.0), Refuted);
        assert_eq!(close_in_practice(0.0, 1.0), Refuted);
        assert_eq!(close_in_practice(0.9, f64::NAN), Refuted);
    }
}
