//! Antialiased shadows from one depth map.
//!
//! Every estimator answers the same question: which share of a window of stored occluder depths
//! is not nearer to the light than the receiver. Percentage-closer filtering answers it exactly
//! by reading the window for each receiver; the others filter a few channels of the map once and
//! estimate the answer from one texel of it.
//!
//! The chain of all forms, with the names they share: **pack** (depth to channels, rounded to
//! the [`Format`]), **filter-x**, **filter-y** (each rounded again), **shade** (one lookup a
//! receiver, then the window statistics become a visibility in `estimators`).
//!
//! Forms: [`reference`](mod@reference) (f64, brute-force windows; the oracle for ports), [`cpu`]
//! (f32 storage, parallel, cost independent of the width for boxes), [`gpu`] (WGSL).

pub mod gpu;
pub mod gpu_depth;
pub mod settings;
pub mod types;

pub use settings::{
    EsmSpace, Estimator, EvsmComponents, FilterError, Format, KernelShape, Lookup, Settings,
    Splits, VsmVariant,
};
pub use types::{Counters, DepthMap, Receiver};
