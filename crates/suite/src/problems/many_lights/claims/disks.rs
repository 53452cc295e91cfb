//! The rule that was rejected, and why.

use super::super::LightsCase;
use super::{
    support::{COARSE, cut, prepared, run, setting},
    verdict::{all_of, figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
    problem::Form,
};
use serde_json::json;

/// R3's shares at which it is looked at.
const SHARES: [f64; 3] = [0.1, 0.5, 2.0];

/// How many times R4's greatest error is a disk: row 42 of the specification.
const DISK: f64 = 5.0;

/// Halvings of the logarithm of T until both cuts are alike in size.
const HALVINGS: usize = 24;

/// Thresholds between which R4 is looked for.
const THRESHOLDS: [f64; 2] = [1e-9, 1e2];

/// How alike cut sizes have to be: a wide tree's sizes jump.
const ALIKE: f64 = 1.1;

pub fn claims() -> Vec<Claim> {
    vec![Claim {
        id: "conte-H3.6",
        statement: "Splitting by a cluster's own relative error leaves bright disks on facades; \
                    splitting by an absolute bound does not",
        place: "Conte 2018, section 3.2 and figure 3.2",
        method: "R3 at shares 0.1, 0.5 and 2, and R4 at the coarsest T whose mean cut is not larger \
                 (and within 10 % of it, or the pair is left out), on a wall lit by the facade \
                 opposite and in the close-ended street of a city, 128 x 72, Walter's tree, whose \
                 cuts grow node by node: R3's greatest error over R4's. More than 5 times on the \
                 facade at every share is met, with the street's beside it; no more than R4's \
                 contradicts",
        judge: Box::new(disks),
    }]
}

/// R4's setting whose mean cut is the largest that is not larger than `size`.
fn as_large(case: &LightsCase<'_>, tree: &str, size: f64) -> Result<f64, SuiteError> {
    let [mut least, mut most] = THRESHOLDS.map(f64::ln);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (least + most);
        let cut = run(case, &cut(tree, middle.exp())?)?.a_pixel(|w| w.cut);
        if cut > size { least = middle } else { most = middle }
    }
    Ok(most.exp())
}

/// How many times R4's greatest error R3's is, on the facade.
fn shows_disks(ratios: &[f64]) -> Verdict {
    if ratios.is_empty() {
        return Verdict::Open;
    }
    // Written so that a NaN contradicts.
    if ratios.iter().all(|r| *r > DISK) {
        Verdict::Reproduced
    } else if ratios.iter().any(|r| *r > 1.0) {
        Verdict::Open
    } else {
        Verdict::Refuted
    }
}

fn disks(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let mut figures = vec![figure("threshold of the source, for scale", COARSE, "")];
    let mut on_facade = Vec::new();
    let scenes = [("light_facade", "", "facade"), ("city_small", "close_ended", "street")];
    for (scene, view, name) in scenes {
        let case = prepared(scene, view, &[])?;
        for share in SHARES {
            let knobs = [("own_epsilon", json!(share)), ("tree", json!("original"))];
            let relative = run(&case, &setting("relative-cut", Form::Cpu, &knobs)?)?;
            let size = relative.a_pixel(|w| w.cut);
            let threshold = as_large(&case, "original", size)?;
            let absolute = run(&case, &cut("original", threshold)?)?;
            let ratio =
                relative.error("error_max") / absolute.error("error_max").max(f64::MIN_POSITIVE);
            let alike = size / absolute.a_pixel(|w| w.cut);
            let at = format!("{name}, share {share}");
            figures.extend([
                figure(format!("{at}: nodes of a cut, R3"), size, ""),
                figure(format!("{at}: nodes of a cut, R4"), absolute.a_pixel(|w| w.cut), ""),
                figure(format!("{at}: R4's T"), threshold, ""),
                figure(format!("{at}: greatest error, R3"), relative.error("error_max"), ""),
                figure(format!("{at}: greatest error, R4"), absolute.error("error_max"), ""),
                figure(format!("{at}: R3's over R4's"), ratio, ""),
            ]);
            if name == "facade" && alike <= ALIKE {
                on_facade.push(ratio);
            }
        }
    }
    let told: Vec<String> = on_facade.iter().map(|r| format!("{r:.1}")).collect();
    let because = format!("on the facade R3's greatest error is {} times R4's", told.join(", "));
    Ok(judged(all_of(&[shows_disks(&on_facade)]), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn disks_show_or_not() {
        assert_eq!(shows_disks(&[6.0, 20.0]), Reproduced);
        assert_eq!(shows_disks(&[2.0, 20.0]), Open);
        assert_eq!(shows_disks(&[0.5, 1.0]), Refuted);
        assert_eq!(shows_disks(&[f64::NAN]), Refuted);
        assert_eq!(shows_disks(&[]), Open);
    }

    #[test]
    fn a_threshold_is_found_for_a_size() {
        let case = prepared("light_facade", "", &[]).unwrap();
        let threshold = as_large(&case, "original", 40.0).unwrap();
        let size = |t: f64| run(&case, &cut("original", t).unwrap()).unwrap().a_pixel(|w| w.cut);
        assert!(size(threshold) <= 40.0 && size(0.8 * threshold) > 36.0);
    }
}
