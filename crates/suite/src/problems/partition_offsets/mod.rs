//! Partition offsets: which leaves of a pruned crown are drawn, packed without gaps, every frame.

mod case;
mod claims;
mod gates;
mod spec;
mod speed;
mod stress;
mod subject;

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
pub struct PartitionOffsets;

impl Problem for PartitionOffsets {
    fn spec(&self) -> &'static Spec {
        &spec::SPEC
    }

    fn prepare<'g>(
        &self,
        case: &Case,
        gpu: Option<&'g Gpu>,
    ) -> Result<Box<dyn Prepared + 'g>, SuiteError> {
        Ok(Box::new(case::Crown::prepare(case, gpu)?))
    }

    fn gates(&self) -> Vec<Gate> {
        gates::gates()
    }

    fn claims(&self) -> Vec<Claim> {
        claims::claims().into_iter().chain(speed::claims()).collect()
    }

    fn stress(&self) -> Vec<Axis> {
        stress::axes()
    }
}
