//! What is said of camera visibility (Conte 2018, and what it builds on), judged.
//!
//! Every judge measures first and then hands plain numbers to a function that decides, so that
//! the tests can show each verdict coming out. Counters decide what they can; times decide only on
//! hardware, and are ratios.

mod cells;
mod coherence;
mod counts;
mod coverage;
mod device;
mod growth;
mod late;
mod occluders;
mod options;
mod real;
mod replay;
mod rivals;
mod support;
mod tables;
mod times;
mod trees;
mod views;

use crate::claims::{Claim, verdict};

/// Every claim of this problem.
pub fn claims() -> Vec<Claim> {
    let mut all = counts::claims();
    all.extend(tables::claims());
    all.extend(views::claims());
    all.extend(times::claims());
    all.extend(coverage::claims());
    all.extend(cells::claims());
    all.extend(coherence::claims());
    all.extend(options::claims());
    all.extend(late::claims());
    all.extend(growth::claims());
    all.extend(rivals::claims());
    all.extend(occluders::claims());
    all.extend(trees::claims());
    all.extend(real::claims());
    all
}

#[cfg(test)]
mod tests {
    use super::claims;
    use crate::claims::{ClaimContext, Verdict};
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
            // What is arithmetic on what is printed cannot come out otherwise.
            let only = match claim.id {
                "conte-T5.I-III"
                | "conte-T5.I-facade"
                | "conte-T5.VII-windows"
                | "conte-T5.VII-triangles" => Some(Verdict::Refuted),
                _ => None,
            };
            assert!(only.is_none_or(|v| v == judged.verdict), "{}: {:?}", claim.id, judged.verdict);
            assert!(ids.insert(claim.id), "{} appears twice", claim.id);
        }
        for id in ["conte-T5.I-III", "conte-T5.VII-lights"] {
            assert!(ids.contains(id), "{id} is missing");
        }
    }
}
