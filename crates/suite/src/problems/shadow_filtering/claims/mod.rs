//! What is said of shadow-map filtering (Gumbau 2011, chapter 7) and what follows from its
//! equations, judged.
//!
//! Every judge measures first and then hands plain numbers to a function that decides, so that
//! the tests can show each verdict coming out. `H7.x` are statements of the source, `D7.x` follow
//! from its equations by analysis, `S7.x` are goals of our own.

use crate::claims::{Claim, verdict};

mod cost;
mod edges;
mod erf;
mod esm;
mod layers;
mod leaks;
mod occluders;
mod precision;
mod robustness;
mod scenes;
mod scores;
mod speed;
mod still;
mod timing;
mod two_depths;

/// Every claim of this problem.
pub fn claims() -> Vec<Claim> {
    let mut all = leaks::claims();
    all.extend(robustness::claims());
    all.extend(occluders::claims());
    all.extend(cost::claims());
    all.extend(precision::claims());
    all.extend(edges::claims());
    all.extend(layers::claims());
    all.extend(two_depths::claims());
    all.extend(erf::claims());
    all.extend(esm::claims());
    all.extend(speed::claims());
    all.sort_by_key(|claim| claim.id);
    all
}

#[cfg(test)]
mod tests {
    use crate::{
        claims::{ClaimContext, Step, run},
        problems::shadow_filtering::ShadowFiltering,
    };
    use std::collections::BTreeSet;

    #[test]
    fn every_claim_is_judged_on_finite_figures() {
        let context = ClaimContext { gpu: None, hardware: false };
        let reports = run(&[&ShadowFiltering], None, &context, |step| {
            if let Step::Ended(report) = step {
                println!("{} {:?}: {}", report.id, report.verdict, report.because);
            }
        });
        let mut ids = BTreeSet::new();
        for report in &reports {
            assert!(report.verdict.is_some(), "{}: {}", report.id, report.because);
            // A goal of the device's has nothing to show without one.
            assert!(!report.figures.is_empty() || report.id == "dapple-S7.1", "{}", report.id);
            for figure in &report.figures {
                assert!(figure.value.is_finite(), "{}: {}", report.id, figure.what);
            }
            ids.insert(report.id);
        }
        assert_eq!(ids.len(), reports.len(), "an id appears twice");
        let needed = (1..=9).map(|i| format!("gumbau-H7.{i}"));
        for id in needed.chain((1..=8).map(|i| format!("gumbau-D7.{i}"))) {
            assert!(ids.contains(id.as_str()), "{id} is missing");
        }
    }
}
