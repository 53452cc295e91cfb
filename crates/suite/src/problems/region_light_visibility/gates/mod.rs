//! The correctness gates, each with a deliberate fault that it must catch.
//!
//! The heart is P1: in sound modes no light that any point of a face sees is left out. Rays judge it,
//! not another form of the same steps: a fault once made was shared by both.

mod forms;
mod model;
mod precuts;
mod rays;
mod rivals;
mod shadows;
mod worlds;

use crate::verify::Gate;

/// What all techniques share.
const ALL: &str = "-";

/// Every gate of the problem.
pub fn all() -> Vec<Gate> {
    [rays::gates, shadows::gates, precuts::gates, forms::gates, rivals::gates]
        .into_iter()
        .flat_map(|gates| gates())
        .collect()
}

#[cfg(test)]
mod tests {
    use crate::{
        problems::region_light_visibility::RegionLightVisibility,
        testing::{every_gate_has_a_name_of_its_own, every_gate_holds},
    };

    #[test]
    fn every_gate_passes_and_catches_its_fault_and_no_technique_is_without() {
        every_gate_holds(&RegionLightVisibility);
    }

    #[test]
    fn names_are_each_given_once() {
        every_gate_has_a_name_of_its_own(&RegionLightVisibility);
    }
}
