//! Calls of each step at the close-ended street, against table 5.V, and that table against itself.

use super::{
    support::{ABOUT, CITIES, OURS, THESIS, VIEW, is_about, prepared, run},
    verdict::{count, figure, judged, vote},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_many_lights::region::{FacadeCluster, OccluderMode, Steps};

/// Evaluations of the table.
const EVALUATIONS: f64 = 53.0;

/// A step, its calls in the table, and those here.
pub type Step = (&'static str, f64, fn(&Steps) -> u64);

/// Steps that are counted alike there and here.
pub const STEPS: [Step; 6] = [
    ("6: iterations", 379.0, |s| s.iterations),
    ("7: potential tests", 56_646.0, |s| s.potential),
    ("9: last tests", 10_925.0, |s| s.last),
    ("11: early tests", 32_751.0, |s| s.early),
    ("13: reprojections", 328.0, |s| s.reprojections),
    ("nodes put out", 6_753.0, |s| s.output),
];

/// Of potential tests, and of early ones, those that cull.
const POTENTIAL_CULLED: f64 = 12_970.0;
const EARLY_CULLED: f64 = 5_418.0;

/// Own times of table 5.V, milliseconds, and the time of step 1 with all below it.
const SELF_MS: [f64; 14] =
    [2.9, 2.8, 0.1, 18.5, 0.1, 4.3, 5.2, 14.6, 42.2, 9.4, 15.7, 5.4, 0.4, 8.1];
const TOTAL_MS: f64 = 130.7;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "conte-T5.V",
            statement: "An evaluation at the close-ended street takes 7.2 iterations, 1,069 potential \
                        tests, 206 last and 618 early tests, 6.2 reprojections, and puts out 127 nodes",
            place: "Conte 2018, table 5.V and section 5.3.3, divided by its 53 evaluations",
            method: "calls an evaluation in our city of about as many lights, all faces of one frame, \
                     as the source says it (joined as they come, one edge, planes at each far face) \
                     behind buildings: within a factor of 1.5 for all six is met, for none \
                     contradicts. The city's measures, and what its hierarchy projects, are not given. \
                     Step 10 counts there what is below a cluster too, and is left out; boxes around \
                     clusters and our own settings stand beside",
            judge: Box::new(table),
        },
        Claim {
            id: "conte-T5.V-identity",
            statement: "Every cluster that is strong enough goes to exactly one of steps 9 and 11",
            place: "Conte 2018, table 5.V: 56,646 - 12,970 = 10,925 + 32,751",
            method: "the table's numbers, and those counted in three cities in both settings: any that \
                     do not add up contradict",
            judge: Box::new(identity),
        },
        Claim {
            id: "conte-T5.V-sum",
            statement: "The own times of table 5.V add up to its first row, 130.7 ms",
            place: "Conte 2018, caption of table 5.V",
            method: "sum of the fourteen printed numbers: each is rounded to 0.05 ms, so that 0.7 ms \
                     and half a digit of the total may be lost; more contradicts",
            judge: Box::new(sum),
        },
        Claim {
            id: "conte-H5.6",
            statement: "22.9 % of the potential tests and 16.5 % of the early ones cull, in about seven \
                        iterations an evaluation",
            place: "Conte 2018, section 5.3.3",
            method: "the same faces and settings as for the table: within a factor of 1.5 for all three \
                     is met, for none contradicts",
            judge: Box::new(efficiencies),
        },
    ]
}

fn share(part: u64, whole: u64) -> f64 {
    part as f64 / whole.max(1) as f64
}

/// Calls here and there.
fn as_printed(calls: &[(f64, f64)]) -> Verdict {
    vote(&calls.iter().map(|(ours, theirs)| is_about(*ours, *theirs)).collect::<Vec<_>>())
}

fn table(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let case = prepared(CITIES[0], VIEW, 1)?;
    let boxes = FacadeCluster { occluders: OccluderMode::BoundingBoxes, ..THESIS };
    let runs = [run(&case, THESIS)?, run(&case, boxes)?, run(&case, OURS)?];
    let mut figures = vec![
        figure("lights, table", 39_202.0, ""),
        figure("lights, ours", case.night().town.lights.leaves.len() as f64, ""),
        figure("evaluations, table", EVALUATIONS, ""),
        figure("evaluations, ours", runs[0].steps.evaluations as f64, ""),
    ];
    let mut calls = Vec::new();
    for (name, printed, of) in STEPS {
        let [thesis, boxes, ours] = runs.each_ref().map(|run| run.each(of));
        let printed = printed / EVALUATIONS;
        figures.extend([
            figure(format!("{name}, table"), printed, "an evaluation"),
            figure(format!("{name}, behind buildings"), thesis, "an evaluation"),
            figure(format!("{name}, behind boxes around clusters"), boxes, "an evaluation"),
            figure(format!("{name}, our settings"), ours, "an evaluation"),
        ]);
        calls.push((thesis, printed));
    }
    for (name, of) in [
        ("10: projections", (|s| s.last_projected) as fn(&Steps) -> u64),
        ("12: projections", |s| s.early_projected),
        ("14: occluders projected", |s| s.projected),
        ("shadows compared", |s| s.compared),
        ("clusters divided by planes", |s| s.straddling),
    ] {
        figures.push(figure(
            format!("{name}, behind buildings"),
            runs[0].each(of),
            "an evaluation",
        ));
        figures.push(figure(format!("{name}, our settings"), runs[2].each(of), "an evaluation"));
    }
    let holds: Vec<bool> = calls.iter().map(|(a, b)| is_about(*a, *b)).collect();
    let because = format!("{} counts lie within a factor of {ABOUT}", count(&holds));
    Ok(judged(as_printed(&calls), because, figures))
}

/// Whether all add up.
fn adds_up(all: &[bool]) -> Verdict {
    match all {
        [] => Verdict::Open,
        all if all.iter().all(|adds| *adds) => Verdict::Reproduced,
        _ => Verdict::Refuted,
    }
}

fn identity(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let printed = |name: &str| {
        STEPS.iter().find(|(step, ..)| *step == name).map_or(f64::NAN, |(_, calls, _)| *calls)
    };
    let left = printed("7: potential tests") - POTENTIAL_CULLED;
    let tested = printed("9: last tests") + printed("11: early tests");
    let mut figures = vec![
        figure("strong enough, table", left, ""),
        figure("last and early tests, table", tested, ""),
    ];
    let mut all = vec![left == tested];
    for city in CITIES {
        let case = prepared(city, VIEW, 1)?;
        for (name, settings) in [("thesis", THESIS), ("ours", OURS)] {
            let steps = run(&case, settings)?.steps;
            let strong = steps.potential - steps.potential_culled;
            figures.push(figure(format!("{city}, {name}: strong enough"), strong as f64, ""));
            let tests = (steps.last + steps.early) as f64;
            figures.push(figure(format!("{city}, {name}: last and early tests"), tests, ""));
            all.push(steps.is_consistent());
        }
    }
    Ok(judged(adds_up(&all), format!("adds up in {}", count(&all)), figures))
}

/// What is missing from a sum of so many rounded numbers, and the total.
fn sums_up(missing: f64, numbers: usize) -> Verdict {
    // Written so that a NaN contradicts.
    let by_rounding = missing.abs() <= 0.05 * (numbers + 1) as f64;
    if by_rounding { Verdict::Reproduced } else { Verdict::Refuted }
}

fn sum(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let all: f64 = SELF_MS.iter().sum();
    let figures = vec![
        figure("sum of own times, table", all, "ms"),
        figure("first row, table", TOTAL_MS, "ms"),
        figure("most that rounding explains", 0.05 * (SELF_MS.len() + 1) as f64, "ms"),
    ];
    let because = format!("they add up to {all:.1} ms");
    Ok(judged(sums_up(TOTAL_MS - all, SELF_MS.len()), because, figures))
}

fn efficiencies(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let case = prepared(CITIES[0], VIEW, 1)?;
    let of = |settings| -> Result<[f64; 3], SuiteError> {
        let run = run(&case, settings)?;
        let Steps { potential, potential_culled, early, early_culled, .. } = run.steps;
        let shares = [share(potential_culled, potential), share(early_culled, early)];
        Ok([shares[0], shares[1], run.each(|s| s.iterations)])
    };
    let printed = [POTENTIAL_CULLED / 56_646.0, EARLY_CULLED / 32_751.0, 379.0 / EVALUATIONS];
    let (thesis, ours) = (of(THESIS)?, of(OURS)?);
    let names =
        ["share of potential tests that cull", "share of early tests that cull", "iterations"];
    let mut figures = Vec::new();
    for (i, name) in names.into_iter().enumerate() {
        figures.push(figure(format!("{name}, table"), printed[i], ""));
        figures.push(figure(format!("{name}, as the source says it"), thesis[i], ""));
        figures.push(figure(format!("{name}, our settings"), ours[i], ""));
    }
    let calls: Vec<(f64, f64)> = thesis.into_iter().zip(printed).collect();
    let because = format!(
        "{:.1} % by potential, {:.1} % early, {:.1} iterations",
        100.0 * thesis[0],
        100.0 * thesis[1],
        thesis[2]
    );
    Ok(judged(as_printed(&calls), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn calls_are_as_printed_or_not() {
        assert_eq!(as_printed(&[(1.0, 1.4), (7.0, 7.2)]), Reproduced);
        assert_eq!(as_printed(&[(1.0, 2.0), (7.0, 7.2)]), Open);
        assert_eq!(as_printed(&[(1.0, 2.0), (f64::NAN, 7.2)]), Refuted);
    }

    #[test]
    fn one_that_does_not_add_up_contradicts() {
        assert_eq!([adds_up(&[true]), adds_up(&[true, false])], [Reproduced, Refuted]);
        assert_eq!(adds_up(&[]), Open);
    }

    #[test]
    fn sums_miss_no_more_than_rounding() {
        assert_eq!([0.7, 1.0, f64::NAN].map(|m| sums_up(m, 14)), [Reproduced, Refuted, Refuted]);
    }
}
