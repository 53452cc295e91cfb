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
        problem::Problem,
        problems::many_lights::{ManyLights, SPEC},
        verify::{self, GateContext, Outcome},
    };
    use dapple_gpu::testing::test_gpu;

    fn failures(seed: u64) -> Vec<String> {
        let context = GateContext { gpu: test_gpu().filter(|_| seed == 0), cases: 24, seed };
        let reports = verify::run(&[&ManyLights], None, &context, |_| {});
        assert!(verify::ungated(&ManyLights, &reports).is_empty());
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
        let gates = ManyLights.gates();
        let mut names: Vec<_> = gates.iter().map(|g| (g.technique.clone(), &g.name)).collect();
        names.sort();
        let count = names.len();
        names.dedup();
        assert_eq!(names.len(), count);
    }
}
