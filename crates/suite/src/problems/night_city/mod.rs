//! A city at night: whole frames, from what the camera sees to what each pixel gets.
//!
//! What pixels show comes from rays, the same for all techniques. Truth is the sum over all lights with
//! shadow rays; errors are told apart by cause: hidden, weak, clustered, leaked.

pub mod case;
mod claims;
pub mod errors;
mod gates;
pub mod method;
pub mod settings;
mod spec;
mod stress;
mod subject;
#[cfg(test)]
mod tests;

pub use case::NightCase;
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
pub struct NightCity;

impl Problem for NightCity {
    fn spec(&self) -> &'static Spec {
        &SPEC
    }

    fn prepare<'g>(
        &self,
        case: &Case,
        gpu: Option<&'g Gpu>,
    ) -> Result<Box<dyn Prepared + 'g>, SuiteError> {
        Ok(Box::new(NightCase::prepare(case, gpu)?))
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
