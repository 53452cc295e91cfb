//! What is said of many lights (Conte 2018, and those whose techniques it is held against), judged.
//!
//! Every judge measures first and then hands plain numbers to a function that decides, so that
//! the tests can show each verdict coming out. Counters decide what they can; times are ratios of
//! frames in turn, and those of a device decide only on hardware.

mod builds;
mod cuts;
mod disks;
mod growth;
mod images;
mod lanes;
mod moving;
pub(crate) mod precuts;
mod real;
mod representatives;
mod rivals;
mod rivals_lists;
mod rivals_reuse;
mod selection;
pub(crate) mod support;
mod tables;
mod trees;

use crate::claims::{Claim, verdict};

/// Every claim of this problem.
pub fn claims() -> Vec<Claim> {
    let mut all = trees::claims();
    all.extend(cuts::claims());
    all.extend(disks::claims());
    all.extend(growth::claims());
    all.extend(images::claims());
    all.extend(lanes::claims());
    all.extend(moving::claims());
    all.extend(representatives::claims());
    all.extend(selection::claims());
    all.extend(tables::claims());
    all.extend(rivals::claims());
    all.extend(rivals_reuse::claims());
    all.extend(rivals_lists::claims());
    all.extend(real::claims());
    all.extend(builds::claims());
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
    fn what_is_said_of_trees_is_judged() {
        all_are_judged_on_finite_figures(trees::claims());
        all_are_judged_on_finite_figures(tables::claims());
        all_are_judged_on_finite_figures(moving::claims());
    }

    #[test]
    fn what_is_said_of_cuts_is_judged() {
        all_are_judged_on_finite_figures(cuts::claims());
        all_are_judged_on_finite_figures(lanes::claims());
        all_are_judged_on_finite_figures(selection::claims());
        all_are_judged_on_finite_figures(growth::claims());
    }

    #[test]
    fn what_is_said_of_images_is_judged() {
        all_are_judged_on_finite_figures(images::claims());
        all_are_judged_on_finite_figures(disks::claims());
        all_are_judged_on_finite_figures(representatives::claims());
    }

    #[test]
    fn what_is_said_of_rivals_is_judged() {
        all_are_judged_on_finite_figures(rivals::claims());
        all_are_judged_on_finite_figures(rivals_reuse::claims());
    }

    #[test]
    fn what_is_said_of_lists_is_judged() {
        all_are_judged_on_finite_figures(rivals_lists::claims());
    }

    #[test]
    fn what_is_said_of_real_cities_is_judged() {
        all_are_judged_on_finite_figures(real::claims());
    }

    #[test]
    fn what_is_said_of_builds_is_judged() {
        all_are_judged_on_finite_figures(builds::claims());
    }
}
