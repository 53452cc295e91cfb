//! Shadow-map filtering: the antialiased shadow of a depth map.
//!
//! The filter's footprint is a fixed share of the map's side, so that all techniques and all
//! resolutions answer the same question; the kernel in texels follows. Truth is the ray-traced
//! shadow averaged over that footprint, receiver by receiver.

pub mod case;
mod claims;
mod errors;
pub mod gates;
pub(super) mod given;
mod memory;
mod port;
mod settings;
mod spec;
mod stress;
mod subject_cpu;
mod subject_gpu;
mod subject_reference;
#[cfg(test)]
mod tests;
mod tolerance;

pub use case::ShadowCase;
pub use settings::{kernel_texels, resolution, settings};
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
pub struct ShadowFiltering;

impl Problem for ShadowFiltering {
    fn spec(&self) -> &'static Spec {
        &SPEC
    }

    fn prepare<'g>(
        &self,
        case: &Case,
        gpu: Option<&'g Gpu>,
    ) -> Result<Box<dyn Prepared + 'g>, SuiteError> {
        Ok(Box::new(ShadowCase::prepare(case, gpu)?))
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
