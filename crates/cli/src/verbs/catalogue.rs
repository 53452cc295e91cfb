//! `dapple catalogue`: everything that is declared, as one JSON line. Nothing is opened or
//! measured for it: a dashboard waits for the answer.

use crate::{Outcome, feed, sources::Sources};
use anyhow::Result;
use dapple_gpu::AdapterKind;
use dapple_records::{
    Feed,
    catalogue::{Catalogue, KnobInfo, ProblemInfo, TechniqueInfo},
};
use dapple_scene::generate;
use dapple_suite::{
    environment::environment,
    knob::{Accuracy, Knob},
    problem::{Problem, Technique},
    problems, sweep,
};
use std::collections::BTreeMap;

/// Prints the line.
pub fn run() -> Result<Outcome> {
    feed::tell(&Feed::Catalogue(Box::new(catalogue()?)))?;
    Ok(Outcome::Ok)
}

fn catalogue() -> Result<Catalogue> {
    let (adapter, device) = adapter();
    let sweeps = sweep::BUILT_IN
        .iter()
        .map(|(name, _)| Ok(((*name).into(), one_line(&sweep::load(name)?.1.about))))
        .collect::<Result<_>>()?;
    let facts = environment();
    Ok(Catalogue {
        problems: problems::ALL.iter().map(|p| problem(*p)).collect(),
        sweeps,
        scenes: generate::NAMES.iter().map(|(n, what)| ((*n).into(), (*what).into())).collect(),
        machine: facts.machine.clone(),
        cpu: facts.cpu.clone(),
        adapter,
        device: device.into(),
    })
}

/// The adapter that would be opened, as far as its name tells: whether it is sound shows when it
/// is opened.
fn adapter() -> (String, &'static str) {
    match dapple_gpu::adapters().iter().find(|facts| facts.backend != "gl") {
        Some(facts) if facts.kind == AdapterKind::Hardware => (facts.name.clone(), "hardware"),
        Some(facts) => (facts.name.clone(), "software"),
        None => ("no graphics adapter: gpu forms are not run".into(), "none"),
    }
}

/// What one problem declares.
pub fn problem(problem: &dyn Problem) -> ProblemInfo {
    let sources = Sources::read();
    let spec = problem.spec();
    let mut gates = BTreeMap::new();
    for gate in problem.gates() {
        *gates.entry(gate.technique).or_insert(0) += 1;
    }
    ProblemInfo {
        id: spec.id.into(),
        title: spec.title.into(),
        question: one_line(spec.question),
        truth: one_line(spec.truth),
        metrics: spec.metrics.iter().map(|m| triple([m.name, m.unit, m.help])).collect(),
        axis: spec.axis.into(),
        constraints: spec.constraints.iter().map(|c| (c.metric.into(), c.limit)).collect(),
        levels: spec.levels.into(),
        parameters: spec.parameters.iter().map(knob).collect(),
        default_scene: spec.default_scene.into(),
        pictures: spec.pictures,
        techniques: spec.techniques.iter().map(|t| technique(t, &sources)).collect(),
        extremes: problem.stress().iter().map(|a| triple([a.id, a.unit, a.help])).collect(),
        gates,
        claims: problem.claims().iter().map(|c| (c.id.into(), one_line(c.statement))).collect(),
    }
}

fn technique(technique: &Technique, sources: &Sources) -> TechniqueInfo {
    TechniqueInfo {
        id: technique.id.into(),
        title: technique.title.into(),
        source: sources.line(technique.source),
        forms: technique.forms.iter().map(ToString::to_string).collect(),
        variants: technique.variants.iter().map(|v| (v.id.into(), one_line(v.help))).collect(),
        knobs: technique.knobs.iter().map(knob).collect(),
    }
}

fn knob(knob: &Knob) -> KnobInfo {
    KnobInfo {
        name: knob.name.into(),
        unit: knob.unit.into(),
        help: one_line(knob.help),
        limit: knob.limit(),
        default: knob.default_value(),
        steps: knob.steps(),
        accuracy: match knob.accuracy {
            Accuracy::Monotone => "monotone",
            Accuracy::Unimodal => "unimodal",
            Accuracy::None => "none",
        }
        .into(),
    }
}

fn triple([a, b, c]: [&str; 3]) -> (String, String, String) {
    (a.into(), b.into(), one_line(c))
}

/// Declarations are broken into lines as the source is.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
