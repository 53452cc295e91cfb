//! The correctness gates, each with a deliberate fault that it must catch.

mod bands;
mod bounds;
mod cuts;
mod extremes;
mod greedy;
mod hard;
mod input;
mod limits;
mod lists;
mod moving;
mod rules;
mod samplers;
mod scenes;
mod shared;
mod trees;

use crate::{
    SuiteError,
    verify::{About, Gate, GateContext, Tally, gate},
};

/// What all techniques share.
const ALL: &str = "-";

/// Every gate of the problem.
pub fn all() -> Vec<Gate> {
    [
        shared::gates,
        bounds::gates,
        trees::gates,
        moving::gates,
        cuts::gates,
        rules::gates,
        bands::gates,
        scenes::gates,
        samplers::gates,
        lists::gates,
    ]
    .into_iter()
    .flat_map(|gates| gates())
    .collect()
}

/// A gate that needs the device.
fn on_device(
    about: About,
    check: impl Fn(&GateContext<'_>, bool) -> Result<Tally, SuiteError> + Copy + Send + Sync + 'static,
) -> Gate {
    Gate { needs_gpu: true, ..gate(about, check) }
}

#[cfg(test)]
mod tests {
    use crate::{
        problems::many_lights::ManyLights,
        testing::{every_gate_has_a_name_of_its_own, every_gate_holds},
    };

    #[test]
    fn every_gate_passes_and_catches_its_fault_and_no_technique_is_without() {
        every_gate_holds(&ManyLights);
    }

    #[test]
    fn names_are_each_given_once() {
        every_gate_has_a_name_of_its_own(&ManyLights);
    }
}
