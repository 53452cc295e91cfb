//! Region light visibility: which of a city's lights any point of a facade may see.
//!
//! Cells come from what a frame shows, by rays; truth is looked for by rays from many points of some
//! faces. What is bought with time is that fewer hidden lights are kept; a light that is seen and left
//! out is no price that may be paid.

pub mod case;
mod claims;
pub mod faces;
mod gates;
mod picture;
pub mod settings;
pub mod spec;
mod stress;
mod subject;
#[cfg(test)]
mod tests;
pub mod truth;

pub use case::RegionCase;
pub use spec::SPEC;
pub use subject::counters;

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
pub struct RegionLightVisibility;

impl Problem for RegionLightVisibility {
    fn spec(&self) -> &'static Spec {
        &SPEC
    }

    fn prepare<'g>(
        &self,
        case: &Case,
        _: Option<&'g Gpu>,
    ) -> Result<Box<dyn Prepared + 'g>, SuiteError> {
        Ok(Box::new(RegionCase::prepare(case)?))
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
