//! Partition offsets and index generation for pruned foliage.
//!
//! Based on: J. Gumbau Portalés, *Techniques for improving the visualization of natural scenes*,
//! PhD thesis, Universitat Jaume I, 2011, §3.4.2 (eq. 3.6) and §3.5 (Algorithm 2, `CalcOffsets`
//! and `KernelDoLoD`).
//!
//! A crown is `n` leaves, each a quad of 4 vertices and 6 indices, sorted into cells; inside a
//! cell leaves stand in stochastic order, so that the leaves kept at any factor are a *prefix* of
//! the cell. Per frame and cell `c` there is a factor `f_c` in `0..=1`, quantised to 16 bits
//! ([`quantise`]). The output is
//!
//! - `u_c`, the leaves kept ([`kept`]),
//! - `o_c`, the exclusive prefix sum of `u_c`, in leaves ([`Ranges::offsets`]),
//! - six indices for each kept leaf, the cells packed without gaps ([`Ranges::indices`]),
//! - the indirect draw arguments for their total.
//!
//! | form | where |
//! |---|---|
//! | oracle, scalar | [`reference::extract`] |
//! | one thread, or rayon | [`cpu::Extractor`] |
//! | thread per cell, workgroup per cell, thread per output leaf, copy-free multi-draw | [`gpu::Extractor`] |
//! | CPU and full upload | [`gpu::CpuUpload`] |
//!
//! All forms are bit-equal: everything after [`quantise`] is integer arithmetic in `u32`.
//! [`validate`] judges any of them without trusting the code that made them.

mod cells;
mod counters;
pub mod cpu;
mod error;
mod factor_path;
pub mod faults;
pub mod gpu;
mod kept;
mod ranges;
pub mod reference;
mod validate;

#[cfg(test)]
mod properties;

pub use cells::{Cells, MAX_LEAVES};
pub use counters::Counters;
pub use error::PartitionError;
pub use factor_path::FactorPath;
pub use kept::{
    FINE_CELL, FULL, MAX_CELL, check_factors, kept, quantise, quantise_all, quantise_into,
};
pub use ranges::{DrawArgs, GUARD_WORDS, POISON, Ranges, RangesView, expand_draws};
pub use validate::{Stats, validate};
