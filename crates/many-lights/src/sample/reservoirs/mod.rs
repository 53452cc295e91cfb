//! Reservoir resampling of lights with reuse over space and time.
//!
//! Based on: B. Bitterli et al., "Spatiotemporal reservoir resampling for real-time ray tracing with
//! dynamic direct lighting", 2020, sections 3 - 5, algorithms 3 - 6.
//! A pixel draws candidates in proportion to what lights emit, and keeps one of them by its
//! unshadowed luminance at the pixel (the target); then it is merged with the reservoir of the frame
//! before where the surface was, and with those of neighbours in this frame.
//! Deviations:
//! - Unbiased merging weighs by the balance heuristic (section 4.3, "MIS weights") as it resamples:
//!   what was drawn at pixel i counts for M_i p_i / Σ M_j p_j rather than for its share of 1 / Z at the
//!   end. That costs an evaluation for every pair of what is merged, and leaves half the squared error
//!   of weighing the one that was kept. Biased merging is algorithm 4: 1 / ΣM.
//! - With occluders, p of a pixel is 0 where it does not see the light. For that to be so, the light
//!   chosen at a merge is tested at its own pixel at once, and the reservoir emptied where it is not
//!   seen (its M stays). The last merge's ray is the one that shading needs anyway. Rays to the other
//!   pixels are traced for the light that was kept alone: its weight is multiplied by the sum of M p
//!   without them over that with them, which keeps the mean.
//! - Neighbours lie in a disc, in whole pixels without trigonometry, so that all forms choose alike:
//!   a place of the square outside of it is halved.
//! - Directional lights weigh as much as their irradiance over the squared half diagonal of the box
//!   of all others, since an irradiance and an intensity cannot be compared.
//!
//! Lights are static here: history knows of no light that changes, and lags behind where one does.

mod alias;
mod cpu;
mod neighbours;
mod packed;
mod pixel;
mod plan;
mod reference;

#[cfg(test)]
pub(crate) use alias::Slot;
pub(crate) use alias::Table;
pub(crate) use cpu::Cpu;
pub(crate) use neighbours::Neighbours;
pub(crate) use packed::{PackedEye, Reservoir};
pub(crate) use plan::{Plan, Stream, weights};
pub(crate) use reference::Reference;

/// The light of a reservoir that holds none.
pub(crate) const NONE: u32 = u32::MAX;

/// Surfaces whose normals differ by more are not the same (25 degrees, as published): their cosine.
pub(crate) const LEAST_COSINE: f64 = 0.906_307_787_036_65;

/// Surfaces whose depths differ by more than this share are not the same (as published).
pub(crate) const DEPTH_SHARE: f64 = 0.1;
