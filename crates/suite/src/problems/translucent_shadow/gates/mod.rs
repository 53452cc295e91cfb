//! The correctness gates, each with a deliberate fault that it must catch.

mod blends;
mod budget;
mod cascades;
mod criteria;
mod device;
mod device_input;
mod device_ports;
mod device_search;
mod input;
mod layers;
mod layouts;
mod light;
mod planes;
mod rivals;
mod search;
mod shared;
mod splits;
mod staircases;
mod taps;
mod truth;

use crate::verify::{About, Gate, gate};

/// Every gate of the problem.
pub fn all() -> Vec<Gate> {
    [
        shared::gates,
        cascades::gates,
        layers::gates,
        layouts::gates,
        planes::gates,
        blends::gates,
        taps::gates,
        splits::gates,
        rivals::gates,
        staircases::gates,
        criteria::gates,
        search::gates,
        truth::gates,
        light::gates,
        budget::gates,
        device_ports::gates,
        device::gates,
        device_search::gates,
    ]
    .into_iter()
    .flat_map(|gates| gates())
    .collect()
}

/// What all techniques share.
const ALL: &str = "-";

#[cfg(test)]
mod tests {
    use crate::{problems::translucent_shadow::TranslucentShadow, testing::every_gate_holds};

    #[test]
    fn every_gate_passes_and_catches_its_fault_and_no_technique_is_without() {
        every_gate_holds(&TranslucentShadow);
    }
}
