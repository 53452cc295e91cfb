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
mod dom_layers;
mod future;
mod light;
mod osm;
mod osm_packing;
mod search;
mod search_frames;
mod search_tables;
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
