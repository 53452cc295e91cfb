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
    use crate::{
        problems::translucent_shadow::{SPEC, TranslucentShadow},
        verify::{self, GateContext, Outcome},
    };
    use dapple_gpu::testing::test_gpu;

    #[test]
    fn every_gate_passes_and_catches_its_fault_and_no_technique_is_without() {
        let gpu = test_gpu();
        for seed in 0..3 {
            let context = GateContext { gpu: gpu.filter(|_| seed == 0), cases: 24, seed };
            let reports = verify::run(&[&TranslucentShadow], None, &context, |_| {});
            for r in &reports {
                let passed = r.outcome == Outcome::Passed && r.checked > 0 && r.control_failed > 0;
                let not_run = r.outcome == Outcome::NotRun && context.gpu.is_none();
                let what = format!("seed {seed}: {} {}", r.technique, r.gate);
                assert!(passed || not_run, "{what}: {:?} {}", r.outcome, r.detail);
            }
            assert!(verify::ungated(&TranslucentShadow, &reports).is_empty());
            assert!(reports.len() > 4 * SPEC.techniques.len());
        }
    }
}
