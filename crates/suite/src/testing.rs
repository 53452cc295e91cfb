//! What tests of several problems and of the runners share.

use crate::{
    case::Case,
    knob::{self, Knobs},
    problem::{Form, Problem, Setting, Spec},
    run::Options,
    verify::{self, GateContext, Outcome},
};
use dapple_gpu::testing::test_gpu;
use serde_json::Value;
use std::path::Path;

/// A case of a problem with a few parameters given; its first view and the seed 0.
pub fn case(spec: &Spec, scene: &str, given: &[(&str, Value)]) -> Case {
    Case {
        problem: spec.id.into(),
        scene: scene.into(),
        view: String::new(),
        seed: 0,
        parameters: knob::complete("parameter", spec.parameters, &knobs(given)).unwrap(),
    }
}

/// A technique with a few knobs given; its first variant for an empty name.
pub fn setting(
    spec: &Spec,
    technique: &str,
    variant: &str,
    form: Form,
    given: &[(&str, Value)],
) -> Setting {
    let technique = spec.technique(technique).unwrap();
    Setting {
        technique: technique.id.into(),
        variant: if variant.is_empty() { technique.variants[0].id } else { variant }.into(),
        form,
        knobs: knob::complete("knob", technique.knobs, &knobs(given)).unwrap(),
    }
}

fn knobs(given: &[(&str, Value)]) -> Knobs {
    given.iter().map(|(name, value)| ((*name).into(), value.clone())).collect()
}

/// How a run is carried out that a shell script plays the process of.
pub fn played_by(script: &str, records: &Path) -> Options {
    Options {
        records: records.into(),
        adapter: None,
        command: "test".into(),
        shard: String::new(),
        program: "/bin/sh".into(),
        arguments: vec!["-c".into(), script.into()],
        fresh: false,
        fault: None,
    }
}

/// Runs a problem's gates with three seeds, on the device with the first: each must pass and its
/// control fail, and no technique may be without.
pub fn every_gate_holds(problem: &'static dyn Problem) {
    let gpu = test_gpu();
    for seed in 0..3 {
        let context = GateContext { gpu: gpu.filter(|_| seed == 0), cases: 24, seed, deep: false };
        let reports = verify::run(&[problem], None, &context, |_| {});
        for r in &reports {
            let passed = r.outcome == Outcome::Passed && r.checked > 0 && r.control_failed > 0;
            let not_run = r.outcome == Outcome::NotRun && context.gpu.is_none();
            let what = format!("seed {seed}: {} {}", r.technique, r.gate);
            assert!(passed || not_run, "{what}: {:?} {}", r.outcome, r.detail);
        }
        assert!(verify::ungated(problem, &reports).is_empty());
        assert!(reports.len() > 4 * problem.spec().techniques.len());
    }
}

/// Records and tables tell gates apart by technique and name.
pub fn every_gate_has_a_name_of_its_own(problem: &dyn Problem) {
    let gates = problem.gates();
    let mut names: Vec<_> = gates.iter().map(|g| (g.technique.clone(), &g.name)).collect();
    names.sort();
    let count = names.len();
    names.dedup();
    assert_eq!(names.len(), count);
}
