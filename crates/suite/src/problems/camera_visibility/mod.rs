//! Camera visibility: which objects own pixels along a camera path, found with how much work.
//!
//! Every technique draws through a renderer and may ask it how many pixels of a box would show. The
//! hard constraint is that nothing that owns a final pixel is culled; what is bought with time is
//! fewer triangles drawn for nothing.

pub mod case;
mod claims;
mod drawer;
mod errors;
mod gates;
mod method;
mod picture;
mod port;
mod settings;
mod spec;
mod stress;
mod subject;
#[cfg(test)]
mod tests;
mod truth;

pub use case::VisibilityCase;
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
pub struct CameraVisibility;

impl Problem for CameraVisibility {
    fn spec(&self) -> &'static Spec {
        &SPEC
    }

    fn prepare<'g>(
        &self,
        case: &Case,
        gpu: Option<&'g Gpu>,
    ) -> Result<Box<dyn Prepared + 'g>, SuiteError> {
        Ok(Box::new(VisibilityCase::prepare(case, gpu)?))
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
