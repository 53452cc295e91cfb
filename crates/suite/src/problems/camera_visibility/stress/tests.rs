//! The extremes themselves: what they must leave alone, what they must break, what must be refused.

use super::{axes, checked, made, motion, of, walls, world};
use crate::{
    SuiteError,
    case::Case,
    knob::{self, Knobs},
    problem::{Form, Prepared, Setting},
    problems::camera_visibility::{SPEC, VisibilityCase, scene},
    stress::{Axis, Values, edit, judge},
};
use std::collections::BTreeSet;

fn case(scene: &str, axis: &Axis) -> Case {
    Case {
        problem: SPEC.id.into(),
        scene: scene.into(),
        view: String::new(),
        seed: 0,
        parameters: axis.case_parameters(&SPEC, &Knobs::new()).unwrap(),
    }
}

fn setting(technique: &str, variant: &str) -> Setting {
    let technique = SPEC.technique(technique).unwrap();
    Setting {
        technique: technique.id.into(),
        variant: if variant.is_empty() { technique.variants[0].id } else { variant }.into(),
        form: Form::Cpu,
        knobs: knob::complete("knob", technique.knobs, &Knobs::new()).unwrap(),
    }
}

fn axis(id: &str) -> Axis {
    axes().into_iter().find(|axis| axis.id == id).unwrap()
}

/// Home and the ends; every position of words.
fn values(axis: &Axis) -> Vec<f64> {
    match axis.values {
        Values::Log { least, greatest, .. } | Values::Linear { least, greatest, .. } => {
            vec![axis.home, least, greatest]
        }
        Values::FromZero { least, greatest, .. } => vec![axis.home, 0.0, least, greatest],
        // More objects, triangles or columns show no more here than these do, in seconds less.
        Values::Whole { least, greatest, .. } => {
            vec![axis.home, least.into(), greatest.min(2_000).into()]
        }
        Values::Words(words) => (0..words.len()).map(|i| i as f64).collect(),
    }
}

/// What a technique found at a value, as the engine judges it.
fn judged(
    axis: &Axis,
    prepared: &Result<Box<dyn Prepared + '_>, SuiteError>,
    setting: &Setting,
    value: f64,
    home: &judge::Home,
) -> judge::Judgement {
    let refused = (axis.must_refuse)(value);
    match prepared {
        Err(error) => judge::Judgement::without(judge::verdict_of(error), error.to_string()),
        Ok(prepared) => {
            let pushed = (axis.setting)(setting, value).unwrap();
            let found = prepared.subject(&pushed).and_then(|mut subject| subject.check());
            judge::judge(&axis.criterion, home, refused, &found)
        }
    }
}

#[test]
fn every_axis_is_named_once_and_declared_without_fault() {
    let all = axes();
    let ids: BTreeSet<_> = all.iter().map(|axis| axis.id).collect();
    assert_eq!(ids.len(), all.len());
    assert!(all.len() >= 35, "{}", all.len());
    for axis in &all {
        assert_eq!(axis.fault(&SPEC), None, "{}", axis.id);
        let settings = SPEC.techniques.iter().map(|technique| setting(technique.id, ""));
        let meant = settings.filter(|s| (axis.setting)(s, axis.home).is_some()).count();
        assert!(meant > 0, "{} means nothing to any technique", axis.id);
    }
}
