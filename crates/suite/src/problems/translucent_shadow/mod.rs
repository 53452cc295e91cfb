//! Translucent shadows: how much light reaches a point inside hair or foliage.
//!
//! Truth is worked out along light rays against the geometry, averaged over a fixed footprint, so
//! that all techniques at all resolutions answer the same question. What a technique adds to the
//! error of its map's resolution is told apart by the uncompressed deep shadow map on the same
//! texel grid.

mod cascades;
pub mod case;
mod claims;
mod errors;
mod gates;
mod maps;
mod picture;
mod port;
pub mod scene;
mod settings;
mod spec;
mod stress;
mod subject_cascades;
mod subject_cpu;
mod subject_gpu;
mod subject_reference;
mod subject_search;
mod subject_search_gpu;
#[cfg(test)]
mod tests;

pub use case::TranslucentCase;
pub use settings::{resolution, settings};
pub use spec::SPEC;

use crate::{
    SuiteError,
    case::Case,
    claims::Claim,
    problem::{Prepared, Problem, Spec},
    stress::Axis,
    verify::Gate,
};
use dapple_gpu::Gpu;

/// The problem.
#[derive(Clone, Copy, Debug)]
pub struct TranslucentShadow;

impl Problem for TranslucentShadow {
    fn spec(&self) -> &'static Spec {
        &SPEC
    }

    fn prepare<'g>(
        &self,
        case: &Case,
        gpu: Option<&'g Gpu>,
    ) -> Result<Box<dyn Prepared + 'g>, SuiteError> {
        Ok(Box::new(TranslucentCase::prepare(case, gpu)?))
    }

    fn gates(&self) -> Vec<Gate> {
        gates::all()
    }

    fn claims(&self) -> Vec<Claim> {
        claims::claims()
    }

    fn stress(&self) -> Vec<Axis> {
        stress::axes()
    }
}
