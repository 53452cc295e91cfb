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
        problem::Problem,
        problems::camera_visibility::{CameraVisibility, SPEC},
        verify::{self, GateContext, Outcome},
    };
    use dapple_gpu::testing::test_gpu;

    fn failures(seed: u64) -> Vec<String> {
        let context = GateContext { gpu: test_gpu().filter(|_| seed == 0), cases: 24, seed };
        let reports = verify::run(&[&CameraVisibility], None, &context, |_| {});
        assert!(verify::ungated(&CameraVisibility, &reports).is_empty());
        assert!(reports.len() > 4 * SPEC.techniques.len());
        let failed = reports.iter().filter(|r| {
            let passed = r.outcome == Outcome::Passed && r.checked > 0 && r.control_failed > 0;
            let not_run = r.outcome == Outcome::NotRun && context.gpu.is_none();
            !(passed || not_run)
        });
        failed
            .map(|r| format!("{} {}: {:?} {}", r.technique, r.gate, r.outcome, r.detail))
            .collect()
    }

    #[test]
    fn every_gate_passes_and_catches_its_fault_and_no_technique_is_without() {
        for seed in 0..3 {
            assert_eq!(failures(seed), Vec::<String>::new(), "seed {seed}");
        }
    }

    #[test]
    fn names_are_each_given_once() {
        let gates = CameraVisibility.gates();
        let mut names: Vec<_> = gates.iter().map(|g| (g.technique.clone(), &g.name)).collect();
        names.sort();
        let count = names.len();
        names.dedup();
        assert_eq!(names.len(), count);
    }
}
