//! Antialiased shadows from one depth map.
//!
//! Every estimator answers the same question: which share of a window of stored occluder depths
//! is not nearer to the light than the receiver. Percentage-closer filtering answers it exactly
//! by reading the window for each receiver; the others filter a few channels of the map once and
//! estimate the answer from one texel of it.
//!
//! The chain of all forms, with the names they share: **pack** (depth to channels, rounded to
//! the [`Format`]), **filter-x**, **filter-y** (each rounded again), **shade** (one lookup a
//! receiver, then the window statistics become a visibility in [`estimators`]).
//!
//! Rounding. A packed channel is rounded to the format; so is the result of each filter pass, and
//! a lookup blends the rounded values in the working precision (f32; f64 in the reference). The
//! reference filters in two dimensions at once and therefore rounds only twice: packed channels
//! and filtered channels. A port may differ from it by the extra rounding of the pass between, at
//! most one step of the format per channel, as the estimator amplifies it:
//! [`reference::port_bounds`] says how far that is for each receiver. Where a receiver's depth
//! and its texel are computed decides comparisons, so all forms, the reference too, compute them
//! in f32 ([`lookup`]).
//!
//! Forms: [`reference`](mod@reference) (f64, brute-force windows; the oracle for ports), [`cpu`]
//! (f32 storage, parallel, cost independent of the width for boxes), [`gpu`] (WGSL).

pub mod channels;
pub mod cpu;
pub mod estimators;
pub mod faults;
mod format;
pub mod gpu;
pub mod gpu_depth;
pub mod kernel;
pub mod lookup;
pub mod reference;
pub mod settings;
pub mod types;
pub mod windows;

pub use settings::{
    EsmSpace, Estimator, EvsmComponents, FilterError, Format, KernelShape, Lookup, Settings,
    Splits, VsmVariant,
};
pub use types::{Counters, DepthMap, Receiver};
