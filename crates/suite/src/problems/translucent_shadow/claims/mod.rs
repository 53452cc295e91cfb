//! What is said of opacity maps in layers (Voicu 2011), judged.
//!
//! Every judge measures first and then hands plain numbers to a function that decides, so that
//! the tests can show each verdict coming out. What the source prints is judged beside what it
//! means: a listing or a bin rule that is off gets figures of its own.

mod bench;
mod bench_errors;
mod bench_times;
mod bom;
mod bom_bounds;
mod cascades;
mod crop;
mod dom;
mod dom_cost;
mod dom_layers;
mod future;
mod light;
mod methods;
mod osm;
mod osm_packing;
mod search;
mod search_frames;
mod search_tables;
#[cfg(test)]
mod search_tests;
mod search_trials;
mod splits;
mod splits_table;
mod support;

use crate::claims::{Claim, verdict};

/// Every claim of this problem.
pub fn claims() -> Vec<Claim> {
    let mut all = part_one();
    all.extend(part_two());
    all
}

/// Sections 1 to 5: crop, cascades, opacity maps, deep and bounding opacity maps.
fn part_one() -> Vec<Claim> {
    let mut all = crop::claims();
    all.extend(cascades::claims());
    all.extend(osm::claims());
    all.extend(osm_packing::claims());
    all.extend(dom::claims());
    all.extend(dom_layers::claims());
    all.extend(dom_cost::claims());
    all.extend(bom::claims());
    all.extend(bom_bounds::claims());
    all
}

/// Sections 6 to 10: splits, their search, lighting, future work, times.
fn part_two() -> Vec<Claim> {
    let mut all = splits::claims();
    all.extend(splits_table::claims());
    all.extend(search::claims());
    all.extend(search_frames::claims());
    all.extend(light::claims());
    all.extend(future::claims());
    all.extend(bench::claims());
    all.extend(bench_errors::claims());
    all
}

#[cfg(test)]
mod tests {
    use super::{claims, part_one};
    use crate::claims::{ClaimContext, Verdict};
    use std::collections::BTreeSet;

    #[test]
    fn every_hypothesis_of_the_source_is_there_once() {
        let sections = [1, 1, 7, 9, 5, 6, 7, 3, 3, 6];
        let expected: Vec<String> = sections
            .iter()
            .enumerate()
            .flat_map(|(i, n)| (1..=*n).map(move |k| format!("voicu-H{}.{k}", i + 1)))
            .collect();
        let found: Vec<&str> = claims().iter().map(|claim| claim.id).collect();
        let ids: BTreeSet<&str> = found.iter().copied().collect();
        assert_eq!(ids.len(), found.len(), "an id appears twice");
        assert_eq!(ids, expected.iter().map(String::as_str).collect());
    }

    #[test]
    fn the_first_part_is_judged_on_finite_figures() {
        use Verdict::{NeedsHardware, Refuted, Reproduced};
        let context = ClaimContext { gpu: None, hardware: false };
        for claim in part_one() {
            let judged = (claim.judge)(&context).unwrap_or_else(|e| panic!("{}: {e}", claim.id));
            println!("{} {:?}: {}", claim.id, judged.verdict, judged.because);
            assert!(!judged.figures.is_empty() && !judged.because.is_empty(), "{}", claim.id);
            for figure in &judged.figures {
                assert!(figure.value.is_finite(), "{}: {}", claim.id, figure.what);
            }
            // What is exact, what is printed and what needs a clock cannot come out otherwise.
            let only = match claim.id {
                "voicu-H3.3" | "voicu-H4.5" | "voicu-H4.6" | "voicu-H5.1" | "voicu-H5.4" => {
                    Some(Reproduced)
                }
                "voicu-H3.4" | "voicu-H3.6" => Some(NeedsHardware),
                "voicu-H4.7" => Some(Refuted),
                _ => None,
            };
            assert!(only.is_none_or(|v| v == judged.verdict), "{}: {:?}", claim.id, judged.verdict);
        }
    }
}
