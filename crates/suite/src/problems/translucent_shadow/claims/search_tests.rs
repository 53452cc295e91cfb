//! Every judge of sections 6 to 10 that needs no clock says something of finite figures.

use crate::claims::{ClaimContext, Verdict};

#[test]
fn what_needs_no_clock_is_judged_on_finite_figures() {
    use Verdict::{Refuted, Reproduced};
    let context = ClaimContext { gpu: None, hardware: false };
    let timed = ["H6.4", "H7.4", "H7.6", "H9.1", "H9.3", "H10."];
    let long = ["H6.6", "H7.1", "H7.2", "H7.3", "H7.7"];
    let left_out = |id: &str| timed.iter().chain(&long).any(|part| id.contains(part));
    for claim in super::part_two().into_iter().filter(|c| !left_out(c.id)) {
        let judged = (claim.judge)(&context).unwrap_or_else(|e| panic!("{}: {e}", claim.id));
        assert!(!judged.figures.is_empty() && !judged.because.is_empty(), "{}", claim.id);
        for figure in &judged.figures {
            assert!(figure.value.is_finite(), "{}: {}", claim.id, figure.what);
        }
        // What arithmetic alone decides.
        let only = match claim.id {
            "voicu-H6.5" => Some(Refuted),
            "voicu-H7.5" | "voicu-H8.3" => Some(Reproduced),
            _ => None,
        };
        assert!(only.is_none_or(|v| v == judged.verdict), "{}: {:?}", claim.id, judged.verdict);
    }
}
