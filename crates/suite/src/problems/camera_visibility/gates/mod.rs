//! The correctness gates, each with a deliberate fault that it must catch.

mod asked;
mod city;
mod coverage;
mod depth;
mod device;
mod input;
mod judge;
mod masked;
mod play;
mod questions;
mod renderers;
mod shared;
mod truth;
mod views;
mod work;

use crate::verify::Gate;

/// What all techniques share.
const ALL: &str = "-";

/// Every gate of the problem.
pub fn all() -> Vec<Gate> {
    [
        shared::gates,
        questions::gates,
        work::gates,
        coverage::gates,
        depth::gates,
        masked::gates,
        renderers::gates,
        truth::gates,
        city::gates,
        views::gates,
        device::gates,
        shared::device_gates,
    ]
    .into_iter()
    .flat_map(|gates| gates())
    .collect()
}

#[cfg(test)]
mod tests {
    use crate::{
        problems::camera_visibility::CameraVisibility,
        testing::{every_gate_has_a_name_of_its_own, every_gate_holds},
    };

    #[test]
    fn every_gate_passes_and_catches_its_fault_and_no_technique_is_without() {
        every_gate_holds(&CameraVisibility);
    }

    #[test]
    fn names_are_each_given_once() {
        every_gate_has_a_name_of_its_own(&CameraVisibility);
    }
}
