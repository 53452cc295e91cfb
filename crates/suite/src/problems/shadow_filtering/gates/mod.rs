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
    use crate::{
        problems::shadow_filtering::{SPEC, ShadowFiltering},
        verify::{self, GateContext, Outcome},
    };
    use dapple_gpu::testing::test_gpu;

    #[test]
    fn every_gate_passes_and_catches_its_fault_and_no_technique_is_without() {
        let gpu = test_gpu();
        for seed in 0..3 {
            let context = GateContext { gpu: gpu.filter(|_| seed == 0), cases: 24, seed };
            let reports = verify::run(&[&ShadowFiltering], None, &context, |_| {});
            for r in &reports {
                let passed = r.outcome == Outcome::Passed && r.checked > 0 && r.control_failed > 0;
                let not_run = r.outcome == Outcome::NotRun && context.gpu.is_none();
                let what = format!("seed {seed}: {} {}", r.technique, r.gate);
                assert!(passed || not_run, "{what}: {:?} {}", r.outcome, r.detail);
            }
            assert!(verify::ungated(&ShadowFiltering, &reports).is_empty());
            assert!(reports.len() > 4 * SPEC.techniques.len());
        }
    }
}
