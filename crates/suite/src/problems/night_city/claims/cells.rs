//! Cells of different sizes: figure 5.7.

use super::{
    super::NightCase,
    support::{checked, counter, error, night, pipeline, prepared},
    verdict::{figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, Judged, Verdict},
    problem::Checked,
};
use dapple_many_lights::Shaded;
use serde_json::{Value, json};

/// From coarse to fine.
const PARTS: [&str; 4] = ["building", "facade", "storey", "any"];

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "conte-H5.12",
            statement: "Finer cells leak less and cost more evaluations",
            place: "Conte 2018, section 5.4 and figure 5.7",
            method: "close-ended street and facade of the 6 x 6 city, tau 0, cells by building, \
                     facade, storey and what is drawn: mean leak over the truth's mean, and evaluations \
                     of a first frame. Met in a view if no finer cell leaks more, by storeys less than \
                     by facades, and evaluations never fall and rise in all; contradicted if storeys \
                     leak no less or cost no more",
            judge: Box::new(|_| finer()),
        },
        Claim {
            id: "conte-H5.12-seams",
            statement: "Cells by storey show seams where they end",
            place: "Conte 2018, section 5.4 and figure 5.7",
            method: "the same facade's view, 192 x 144: mean difference of radiance between pixels one \
                     above the other of one wall, where a storey ends between them and where none does. \
                     The one over the other, by cells by storey over by facade: seams if 1.1 or more, as \
                     less is not told from the wall's own change; none if 1 or less",
            judge: Box::new(|_| seams()),
        },
        Claim {
            id: "conte-H6.4",
            statement: "Heights of a cell below which lights are hidden lower the leak, with no new \
                        evaluations",
            place: "Conte 2018, section 6.1: future work",
            method: "close-ended street and facade of the 6 x 6 city, cells by facade, tau 0, precuts \
                     with four heights a cell over precuts without: met in a view if the mean leak \
                     falls to 0.95 or less, as less is not seen, evaluations stay as many and no pixel \
                     loses a light; contradicted if it does not fall, or any light is lost. Nodes \
                     that pixels visit stand beside",
            judge: Box::new(|_| with_heights()),
        },
    ]
}

/// The leak with heights over that without, evaluations alike, and lights lost.
fn is_lower(leak: f64, evaluations: f64, lost: f64) -> Option<bool> {
    if leak >= 1.0 || leak.is_nan() || evaluations > 1.0 || lost > 0.0 {
        Some(false)
    } else {
        (leak <= 0.95).then_some(true)
    }
}

fn with_heights() -> Result<Judged, SuiteError> {
    let (mut figures, mut cases, mut told) = (Vec::new(), Vec::new(), Vec::new());
    for view in ["close_ended", "facade"] {
        let case = prepared("city", view, &[])?;
        let mut knobs = knobs("facade").to_vec();
        let without = checked(&case, "facade-cluster", &knobs)?;
        knobs.push(("heights", json!(4)));
        let with = checked(&case, "facade-cluster", &knobs)?;
        let over = |of: &dyn Fn(&Checked) -> f64| of(&with) / of(&without).max(f64::MIN_POSITIVE);
        let leak = over(&|run| error(run, "leak"));
        let evaluations = over(&|run| counter(run, "evaluations"));
        let lost = error(&with, "lost_lights");
        figures.extend([
            figure(format!("{view}: leak over truth, without"), error(&without, "leak"), ""),
            figure(format!("{view}: leak, with over without"), leak, "times"),
            figure(format!("{view}: evaluations, with over without"), evaluations, "times"),
            figure(format!("{view}: lights lost a pixel"), lost, ""),
            figure(
                format!("{view}: nodes visited, with over without"),
                over(&|run| counter(run, "node_visits")),
                "times",
            ),
        ]);
        told.push(format!("{view} leaks {leak:.2} times as much"));
        cases.push(is_lower(leak, evaluations, lost));
    }
    Ok(judged(super::verdict::vote_open(&cases), told.join("; "), figures))
}

fn knobs(part: &str) -> [(&'static str, Value); 2] {
    [("most_split", json!(part)), ("tau", json!(0))]
}

/// Leaks and evaluations, coarse cells first.
fn is_finer(leaks: [f64; 4], evaluations: [f64; 4]) -> Option<bool> {
    let [_, facade, storey, _] = leaks;
    if storey >= facade || evaluations[2] <= evaluations[1] {
        return Some(false);
    }
    let falls = leaks.windows(2).all(|pair| pair[1] <= pair[0]);
    let rises = evaluations.windows(2).all(|pair| pair[1] >= pair[0]);
    (falls && rises).then_some(true)
}

fn finer() -> Result<Judged, SuiteError> {
    let (mut figures, mut cases, mut told) = (Vec::new(), Vec::new(), Vec::new());
    for view in ["close_ended", "facade"] {
        let case = prepared("city", view, &[])?;
        let (mut leaks, mut evaluations) = ([0.0; 4], [0.0; 4]);
        for (at, part) in PARTS.into_iter().enumerate() {
            let run = checked(&case, "facade-cluster", &knobs(part))?;
            leaks[at] = error(&run, "leak");
            evaluations[at] = counter(&run, "evaluations");
            figures.extend([
                figure(format!("{view}, {part}: leak over truth"), leaks[at], ""),
                figure(format!("{view}, {part}: greatest leak"), error(&run, "e_leak"), ""),
                figure(format!("{view}, {part}: evaluations"), evaluations[at], ""),
            ]);
        }
        told.push(format!(
            "{view}: leak {:.3} by facades, {:.3} by storeys, {:.1} times the evaluations",
            leaks[1],
            leaks[2],
            evaluations[2] / evaluations[1].max(1.0)
        ));
        cases.push(is_finer(leaks, evaluations));
    }
    Ok(judged(super::verdict::vote_open(&cases), told.join("; "), figures))
}

/// Mean differences between pixels one above the other, where an object ends and within one.
fn differences(case: &NightCase<'_>, part: &str) -> Result<[f64; 2], SuiteError> {
    let mut pipeline = pipeline(case, &night(&knobs(part))?)?;
    pipeline.frame(0, false)?;
    let mut shaded = Shaded::default();
    pipeline.read(&mut shaded)?;
    let frame = &case.night().town.world(false).frames[0];
    let mut sums = [[0.0_f64; 2]; 2];
    for below in frame.width as usize..frame.points.len() {
        let above = below - frame.width as usize;
        let (a, b) = (&frame.points[above], &frame.points[below]);
        let is_there = a.is_there() && b.is_there() && b.normal.y.abs() < 1e-3;
        // Of one wall: one normal, and each in the other's plane.
        let off = (a.position - b.position).dot(b.normal).abs();
        if !is_there || a.normal.dot(b.normal) < 0.9999 || off > 1e-2 {
            continue;
        }
        let difference = (shaded.radiance[above] - shaded.radiance[below]).abs().element_sum();
        let sum = &mut sums[usize::from(a.object == b.object)];
        sum[0] += f64::from(difference);
        sum[1] += 1.0;
    }
    Ok(sums.map(|[sum, number]| sum / number.max(1.0)))
}

fn are_seams(ratio: f64) -> Verdict {
    if ratio >= 1.1 {
        Verdict::Reproduced
    } else if ratio > 1.0 {
        Verdict::Open
    } else {
        Verdict::Refuted
    }
}

fn seams() -> Result<Judged, SuiteError> {
    let case = prepared("city", "facade", &[("width", json!(192)), ("truth_pixels", json!(1))])?;
    let (mut figures, mut ratios) = (Vec::new(), Vec::new());
    for part in ["facade", "storey"] {
        let [ends, within] = differences(&case, part)?;
        figures.extend([
            figure(format!("{part}: difference where storeys end"), ends, ""),
            figure(format!("{part}: difference within"), within, ""),
        ]);
        ratios.push(ends / within.max(f64::MIN_POSITIVE));
    }
    let ratio = ratios[1] / ratios[0].max(f64::MIN_POSITIVE);
    let because = format!("where storeys end, cells by storey differ {ratio:.2} times as much");
    Ok(judged(are_seams(ratio), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn finer_cells_leak_less_or_not() {
        let evaluations = [1.0, 2.0, 8.0, 8.0];
        assert_eq!(is_finer([0.5, 0.4, 0.3, 0.3], evaluations), Some(true));
        assert_eq!(is_finer([0.3, 0.4, 0.3, 0.3], evaluations), None);
        assert_eq!(is_finer([0.5, 0.4, 0.4, 0.3], evaluations), Some(false));
        assert_eq!(is_finer([0.5, 0.4, 0.3, 0.3], [1.0, 2.0, 2.0, 3.0]), Some(false));
    }

    #[test]
    fn heights_lower_the_leak_or_not() {
        assert_eq!(is_lower(0.9, 1.0, 0.0), Some(true));
        assert_eq!(is_lower(0.97, 1.0, 0.0), None);
        assert_eq!(is_lower(1.0, 1.0, 0.0), Some(false));
        assert_eq!(is_lower(0.9, 1.1, 0.0), Some(false));
        assert_eq!(is_lower(0.9, 1.0, 0.1), Some(false));
        assert_eq!(is_lower(f64::NAN, 1.0, 0.0), Some(false));
    }

    #[test]
    fn seams_show_or_not() {
        assert_eq!([1.2, 1.05, 1.0, f64::NAN].map(are_seams), [Reproduced, Open, Refuted, Refuted]);
    }
}
