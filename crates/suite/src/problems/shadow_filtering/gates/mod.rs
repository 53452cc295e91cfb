//! The correctness gates, each with a deliberate fault that it must catch.

mod bounds;
mod compared;
mod fitted;
mod input;
mod layered;
mod maps;
mod ports;

use crate::verify::{About, Gate, gate};

/// Every gate of the problem.
pub fn all() -> Vec<Gate> {
    let mut gates = maps::gates();
    gates.extend(compared::gates());
    gates.extend(bounds::gates());
    gates.extend(fitted::gates());
    gates.extend(layered::gates());
    gates.extend(ports::gates());
    gates
}

#[cfg(test)]
mod tests {
    use crate::{problems::shadow_filtering::ShadowFiltering, testing::every_gate_holds};

    #[test]
    fn every_gate_passes_and_catches_its_fault_and_no_technique_is_without() {
        every_gate_holds(&ShadowFiltering);
    }
}
