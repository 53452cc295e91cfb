//! Many lights: radiance at what each pixel shows, from one to a million lights.
//!
//! Receivers come from rays through pixel centres, so that every technique lights the same points.
//! Truth is the sum over all lights in f64, at a seeded subset of the pixels. What is bought with time
//! is a smaller greatest error of a pixel.

pub mod case;
pub(crate) mod claims;
pub mod errors;
mod gates;
pub mod input;
pub mod picture;
pub mod port;
mod replicas;
pub mod settings;
mod spec;
mod stress;
mod subject;
#[cfg(test)]
mod tests;
pub mod truth;

pub use case::LightsCase;
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
pub struct ManyLights;

impl Problem for ManyLights {
    fn spec(&self) -> &'static Spec {
        &SPEC
    }

    fn prepare<'g>(
        &self,
        case: &Case,
        gpu: Option<&'g Gpu>,
    ) -> Result<Box<dyn Prepared + 'g>, SuiteError> {
        Ok(Box::new(LightsCase::prepare(case, gpu)?))
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
