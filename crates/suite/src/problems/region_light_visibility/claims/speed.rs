//! Where the time of an evaluation goes, and what kept projections save of it.

use super::{
    support::{ABOUT, CITIES, OURS, THESIS, VIEW, asked, evaluator, ns, prepared},
    verdict::{all_of, figure, judged, paired},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_many_lights::region::{FacadeCluster, Precuts, evaluate::Parts};

/// Rounds over all faces that are timed part by part.
const ROUNDS: usize = 5;

/// Pairs of runs with and without kept projections.
const PAIRS: usize = 15;

/// The share that the source expects kept projections to save.
const SAVED: f64 = 0.05;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "conte-H5.5",
            statement: "More than 90 % of an evaluation is testing clusters, less than 1 % reprojection, \
                        and the last test costs most",
            place: "Conte 2018, section 5.3.3 and table 5.V",
            method: "city, close-ended street, all faces of one frame five times on one thread, timed \
                     step by step: shares of step 5 (without preparing queues) that are steps 6 to 12 \
                     and step 13, and the greatest of steps 7, 9 and 11; shares of one run do not \
                     depend on the machine's pace. As the source says it decides: all three are met, or \
                     one contradicts. Our settings and nanoseconds a test stand beside",
            judge: Box::new(shares),
        },
        Claim {
            id: "conte-H6.3",
            statement: "Keeping what a cluster's projections have in common makes visibility about 5 % \
                        faster",
            place: "Conte 2018, section 6.1",
            method: "the same faces, 15 pairs of runs in turn on one thread, as the source says it: \
                     contradicted if lists differ, no projection is saved, or the median time is not \
                     less; met if 3.3 to 7.5 % of the time is saved (a factor of 1.5), by more than its \
                     deviation. Our settings stand beside",
            judge: Box::new(kept),
        },
    ]
}

/// Shares of step 5.
#[derive(Clone, Copy)]
struct Shares {
    clusters: f64,
    reprojection: f64,
    potential: f64,
    last: f64,
    early: f64,
}

impl Shares {
    fn of(parts: &Parts) -> Self {
        let whole = (parts.total_ns() - parts.sorting_ns).max(1) as f64;
        let share = |ns: u64| ns as f64 / whole;
        Self {
            clusters: share(parts.clusters_ns()),
            reprojection: share(parts.reprojection_ns),
            potential: share(parts.potential_ns),
            last: share(parts.last_ns),
            early: share(parts.early_ns),
        }
    }
}

fn by_text(shares: Shares) -> Verdict {
    let Shares { clusters, reprojection, potential, last, early } = shares;
    let holds = [clusters > 0.9, reprojection < 0.01, last > potential && last > early];
    all_of(&holds.map(|h| if h { Verdict::Reproduced } else { Verdict::Refuted }))
}

fn shares(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let case = prepared(CITIES[0], VIEW, 1)?;
    let asked = asked(&case);
    let mut figures = vec![
        figure("steps 6 to 12, table", 96.8 / 105.4, ""),
        figure("step 13, table", 0.4 / 105.4, ""),
        figure("step 9, table", 51.6 / 105.4, ""),
    ];
    let mut all = Vec::new();
    for (name, settings) in [("as the source says it", THESIS), ("our settings", OURS)] {
        let mut evaluator = evaluator(&case, settings);
        // Once without the clock: lists grow.
        let mut nodes = Vec::new();
        for (cell, direction) in &asked {
            evaluator.precut(cell, *direction, &mut nodes);
        }
        let before = *evaluator.steps();
        evaluator.time(true);
        for _ in 0..ROUNDS {
            ns(&mut evaluator, &asked);
        }
        let parts = *evaluator.parts();
        let shares = Shares::of(&parts);
        let steps = evaluator.steps();
        let tests = |s: &dapple_many_lights::region::Steps| s.potential + s.last + s.early;
        let tests = (tests(steps) - tests(&before)).max(1) as f64;
        let evaluations = (steps.evaluations - before.evaluations).max(1) as f64;
        let whole = parts.total_ns() as f64;
        figures.extend([
            figure(format!("{name}: steps 6 to 12 of step 5"), shares.clusters, ""),
            figure(format!("{name}: step 13"), shares.reprojection, ""),
            figure(
                format!("{name}: step 14, with joining"),
                parts.projection_ns as f64 / whole,
                "of all",
            ),
            figure(format!("{name}: step 7"), shares.potential, ""),
            figure(format!("{name}: step 9"), shares.last, ""),
            figure(format!("{name}: step 11"), shares.early, ""),
            figure(format!("{name}: sorting"), parts.sorting_ns as f64 / whole, "of all"),
            figure(format!("{name}: a test"), parts.clusters_ns() as f64 / tests, "ns"),
            figure(format!("{name}: an evaluation"), whole / evaluations / 1e3, "us"),
        ]);
        all.push(shares);
    }
    let thesis = all[0];
    let because = format!(
        "{:.1} % testing, {:.2} % reprojection; {:.0}, {:.0} and {:.0} % in steps 7, 9 and 11",
        100.0 * thesis.clusters,
        100.0 * thesis.reprojection,
        100.0 * thesis.potential,
        100.0 * thesis.last,
        100.0 * thesis.early
    );
    Ok(judged(by_text(thesis), because, figures))
}

/// Whether the lists are the same, projections kept over those anew, and the share of time saved with
/// its deviation.
fn saves(same: bool, projections: f64, (saved, deviation): (f64, f64)) -> Verdict {
    // Written so that a NaN contradicts.
    let is_less = projections < 1.0 && saved > 0.0;
    if !same || !is_less {
        Verdict::Refuted
    } else if (SAVED / ABOUT..=SAVED * ABOUT).contains(&saved) && saved > deviation {
        Verdict::Reproduced
    } else {
        Verdict::Open
    }
}

fn kept(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let case = prepared(CITIES[0], VIEW, 1)?;
    let asked = asked(&case);
    let (mut figures, mut verdicts) = (Vec::new(), Vec::new());
    for (name, settings) in [("as the source says it", THESIS), ("our settings", OURS)] {
        let mut anew = evaluator(&case, settings);
        let mut keeping = evaluator(&case, FacadeCluster { cached: true, ..settings });
        let (mut a, mut b) = (Vec::new(), Vec::new());
        let mut same = true;
        for (cell, direction) in &asked {
            anew.precut(cell, *direction, &mut a);
            keeping.precut(cell, *direction, &mut b);
            same &= a == b;
        }
        let projected = |of: &dyn Precuts| {
            (of.steps().last_projected + of.steps().early_projected).max(1) as f64
        };
        let projections = projected(&keeping) / projected(&anew);
        let time = paired(PAIRS, || Ok(ns(&mut keeping, &asked)), || Ok(ns(&mut anew, &asked)))?;
        figures.extend([
            figure(format!("{name}: lists alike"), f64::from(u8::from(same)), ""),
            figure(format!("{name}: projections, kept over anew"), projections, ""),
            figure(format!("{name}: time saved"), 1.0 - time.median, ""),
            figure(format!("{name}: deviation of that"), time.mad, ""),
        ]);
        verdicts.push((saves(same, projections, (1.0 - time.median, time.mad)), time.median));
    }
    let (verdict, time) = verdicts[0];
    Ok(judged(verdict, format!("{:.1} % of the time saved", 100.0 * (1.0 - time)), figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn shares_are_as_in_the_text_or_not() {
        let text =
            Shares { clusters: 0.92, reprojection: 0.004, potential: 0.2, last: 0.5, early: 0.2 };
        assert_eq!(by_text(text), Reproduced);
        assert_eq!(by_text(Shares { clusters: 0.8, ..text }), Refuted);
        assert_eq!(by_text(Shares { reprojection: 0.02, ..text }), Refuted);
        assert_eq!(by_text(Shares { potential: 0.6, ..text }), Refuted);
        assert_eq!(by_text(Shares { clusters: f64::NAN, ..text }), Refuted);
        let parts = Parts {
            sorting_ns: 9,
            potential_ns: 2,
            last_ns: 6,
            early_ns: 1,
            reprojection_ns: 1,
            ..Parts::default()
        };
        let shares = Shares::of(&parts);
        assert_eq!((shares.clusters, shares.reprojection, shares.last), (0.9, 0.1, 0.6));
    }

    #[test]
    fn projections_are_worth_keeping_or_not() {
        assert_eq!(saves(true, 0.5, (0.05, 0.01)), Reproduced);
        assert_eq!(saves(true, 0.5, (0.2, 0.01)), Open);
        assert_eq!(saves(true, 0.5, (0.04, 0.06)), Open);
        assert_eq!(saves(false, 0.5, (0.05, 0.01)), Refuted);
        assert_eq!(saves(true, 1.0, (0.05, 0.01)), Refuted);
        assert_eq!(saves(true, 0.5, (-0.01, 0.0)), Refuted);
        assert_eq!(saves(true, 0.5, (f64::NAN, 0.0)), Refuted);
    }
}
