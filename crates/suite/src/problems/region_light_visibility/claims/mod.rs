//! What is said of from-region visibility (Conte 2018, and what it is held against), judged.
//!
//! Every judge measures first and then hands plain numbers to a function that decides, so that the
//! tests can show each verdict coming out. Counters decide what they can; times are ratios of runs in
//! turn on one thread.

mod growth;
mod heights;
mod horizons;
mod rivals;
mod rows;
mod sound;
mod speed;
mod steps;
mod support;
mod threads;

use crate::claims::{Claim, verdict};

/// Every claim of this problem.
pub fn claims() -> Vec<Claim> {
    let mut all = sound::claims();
    all.extend(horizons::claims());
    all.extend(rows::claims());
    all.extend(steps::claims());
    all.extend(growth::claims());
    all.extend(speed::claims());
    all.extend(threads::claims());
    all.extend(heights::claims());
    all.extend(rivals::claims());
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::claims::ClaimContext;
    use std::{collections::BTreeSet, time::Instant};

    fn all_are_judged_on_finite_figures(claims: Vec<Claim>) {
        let context = ClaimContext { gpu: None, hardware: false };
        for claim in claims {
            let start = Instant::now();
            let judged = (claim.judge)(&context).unwrap_or_else(|e| panic!("{}: {e}", claim.id));
            let seconds = start.elapsed().as_secs_f64();
            println!("{} {:?} ({seconds:.1} s): {}", claim.id, judged.verdict, judged.because);
            for figure in &judged.figures {
                println!("    {} = {} {}", figure.what, figure.value, figure.unit);
                assert!(figure.value.is_finite(), "{}: {}", claim.id, figure.what);
            }
            assert!(!judged.figures.is_empty() && !judged.because.is_empty(), "{}", claim.id);
        }
    }

    #[test]
    fn ids_are_different() {
        let ids: BTreeSet<_> = claims().iter().map(|claim| claim.id).collect();
        assert_eq!(ids.len(), claims().len());
    }

    #[test]
    fn what_is_said_of_shadows_is_judged() {
        all_are_judged_on_finite_figures(horizons::claims());
        all_are_judged_on_finite_figures(rows::claims());
    }

    #[test]
    fn what_is_said_of_a_city_is_judged() {
        all_are_judged_on_finite_figures(sound::claims());
        all_are_judged_on_finite_figures(heights::claims());
        all_are_judged_on_finite_figures(rivals::claims());
    }

    #[test]
    fn what_is_said_of_steps_and_times_is_judged() {
        all_are_judged_on_finite_figures(steps::claims());
        all_are_judged_on_finite_figures(growth::claims());
        all_are_judged_on_finite_figures(speed::claims());
        all_are_judged_on_finite_figures(threads::claims());
    }
}
