//! What is said of whole frames of a city at night (Conte 2018, chapters 5 and 6), judged.
//!
//! Every judge measures first and then hands plain numbers to a function that decides, so that
//! the tests can show each verdict coming out. Counters decide what they can; times are ratios of
//! frames in turn.

mod cells;
mod front;
mod heights;
mod leaks;
mod memory;
mod pace;
mod precuts;
mod shading;
mod stages;
mod support;
mod views;
mod weak;

use crate::claims::{Claim, verdict};

/// Every claim of this problem.
pub fn claims() -> Vec<Claim> {
    let mut all = stages::claims();
    all.extend(views::claims());
    all.extend(memory::claims());
    all.extend(shading::claims());
    all.extend(heights::claims());
    all.extend(cells::claims());
    all.extend(weak::claims());
    all.extend(pace::claims());
    all.extend(precuts::claims());
    all.extend(leaks::claims());
    all.extend(front::claims());
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
    fn what_is_said_of_evaluations_is_judged() {
        all_are_judged_on_finite_figures(stages::claims());
        all_are_judged_on_finite_figures(views::claims());
        all_are_judged_on_finite_figures(memory::claims());
    }

    #[test]
    fn what_is_said_of_images_is_judged() {
        all_are_judged_on_finite_figures(shading::claims());
        all_are_judged_on_finite_figures(heights::claims());
        all_are_judged_on_finite_figures(cells::claims());
        all_are_judged_on_finite_figures(weak::claims());
    }

    #[test]
    fn what_is_said_of_whole_frames_is_judged() {
        all_are_judged_on_finite_figures(pace::claims());
        all_are_judged_on_finite_figures(precuts::claims());
    }

    #[test]
    fn what_is_said_of_leaks_is_judged() {
        all_are_judged_on_finite_figures(leaks::claims());
        all_are_judged_on_finite_figures(front::claims());
    }
}
