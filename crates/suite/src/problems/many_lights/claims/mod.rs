//! What is said of many lights (Conte 2018, and those whose techniques it is held against), judged.
//!
//! Every judge measures first and then hands plain numbers to a function that decides, so that
//! the tests can show each verdict coming out. Counters decide what they can; times are ratios of
//! frames in turn, and those of a device decide only on hardware.

mod support;
mod trees;

use crate::claims::{Claim, verdict};

/// Every claim of this problem.
pub fn claims() -> Vec<Claim> {
    trees::claims()
}

#[cfg(test)]
mod tests {
    use super::claims;
    use crate::claims::ClaimContext;
    use std::{collections::BTreeSet, time::Instant};

    #[test]
    fn every_claim_is_judged_on_finite_figures() {
        let context = ClaimContext { gpu: None, hardware: false };
        let mut ids = BTreeSet::new();
        for claim in claims() {
            let start = Instant::now();
            let judged = (claim.judge)(&context).unwrap_or_else(|e| panic!("{}: {e}", claim.id));
            let seconds = start.elapsed().as_secs_f64();
            println!("{} {:?} ({seconds:.1} s): {}", claim.id, judged.verdict, judged.because);
            for figure in &judged.figures {
                println!("    {} = {} {}", figure.what, figure.value, figure.unit);
                assert!(figure.value.is_finite(), "{}: {}", claim.id, figure.what);
            }
            assert!(!judged.figures.is_empty() && !judged.because.is_empty(), "{}", claim.id);
            assert!(ids.insert(claim.id), "{} appears twice", claim.id);
        }
    }
}
