//! The correctness gates, each with a deliberate fault that it must catch.

mod cities;
mod frames;
mod lists;
mod moving;
mod parts;

use crate::verify::Gate;

/// Every gate of the problem.
pub fn all() -> Vec<Gate> {
    [frames::gates, parts::gates, lists::gates, moving::gates]
        .into_iter()
        .flat_map(|gates| gates())
        .collect()
}

#[cfg(test)]
mod tests {
    use crate::{
        problems::night_city::NightCity,
        testing::{every_gate_has_a_name_of_its_own, every_gate_holds},
    };

    #[test]
    fn every_gate_passes_and_catches_its_fault_and_no_technique_is_without() {
        every_gate_holds(&NightCity);
    }

    #[test]
    fn names_are_each_given_once() {
        every_gate_has_a_name_of_its_own(&NightCity);
    }
}
