//! What knobs declare of their accuracy, held to measurement.

use super::Dial;
use crate::{
    case::Case,
    knob::{self, Accuracy, Knobs},
    problem::{Form, Prepared, Setting, Spec, Technique},
    problems,
};
use serde_json::Value;

/// Errors may stray from their declared shape by this share: texels fall differently on every edge.
const SLACK: f64 = 0.05;

/// Greatest rise from any value to any later one, as a share.
fn rise(errors: &[f64]) -> f64 {
    let later = |i: usize| errors[i..].iter().copied().fold(0.0, f64::max);
    (0..errors.len()).map(|i| later(i) / errors[i].max(1e-9) - 1.0).fold(0.0, f64::max)
}

/// How far errors stray from what is declared.
fn strays(accuracy: Accuracy, errors: &[f64]) -> f64 {
    let falls_then_rises = |lowest: usize| {
        let after: Vec<f64> = errors[lowest..].iter().rev().copied().collect();
        rise(&errors[..=lowest]).max(rise(&after))
    };
    match accuracy {
        Accuracy::Monotone => rise(errors),
        Accuracy::Unimodal => (0..errors.len()).map(falls_then_rises).fold(f64::INFINITY, f64::min),
        Accuracy::None => 0.0,
    }
}

#[test]
fn shapes_by_hand_and_a_false_declaration_is_caught() {
    assert!((rise(&[4.0, 2.0, 3.0, 1.0]) - 0.5).abs() < 1e-12);
    assert_eq!(strays(Accuracy::Unimodal, &[4.0, 2.0, 1.0, 3.0, 5.0]), 0.0);
    assert_eq!(strays(Accuracy::Unimodal, &[1.0, 2.0, 3.0]), 0.0);
    assert!(strays(Accuracy::Monotone, &[4.0, 2.0, 1.0, 3.0, 5.0]) > SLACK);
    assert!(strays(Accuracy::Unimodal, &[4.0, 2.0, 3.0, 1.0]) > SLACK);
}

/// The axis metric at every step of a knob, all others at their defaults. Maps of more than twice
/// the default's size would take a test's time and tell no more.
fn errors(spec: &Spec, prepared: &dyn Prepared, technique: &Technique, dial: &Dial) -> Vec<f64> {
    let default = dial.values[dial.default].as_i64();
    let affordable = |v: &&Value| match (default, v.as_i64()) {
        (Some(default), Some(v)) if default > 0 => v <= 2 * default,
        _ => true,
    };
    let apart = dial.apart.then(|| &dial.values[dial.default]);
    let steps = dial.values.iter().filter(|v| Some(*v) != apart).filter(affordable);
    steps
        .map(|value| {
            let given = Knobs::from([(dial.name.clone(), value.clone())]);
            let setting = Setting {
                technique: technique.id.into(),
                variant: technique.variants[0].id.into(),
                form: Form::Cpu,
                knobs: knob::complete("knob", technique.knobs, &given).unwrap(),
            };
            let checked = prepared.subject(&setting).and_then(|mut s| s.check()).unwrap();
            checked.errors[spec.axis]
        })
        .collect()
}

#[test]
fn declared_accuracies_hold_where_they_are_measured() {
    let (mut checked, mut controls) = (0, 0);
    for problem in problems::ALL {
        let spec = problem.spec();
        let declares = |t: &&Technique| {
            t.forms.contains(&Form::Cpu) && t.knobs.iter().any(|k| k.accuracy != Accuracy::None)
        };
        let techniques: Vec<&Technique> = spec.techniques.iter().filter(declares).collect();
        if techniques.is_empty() {
            continue;
        }
        let small = [("width", 128), ("truth_rays", 4)];
        let given: Knobs = small
            .iter()
            .filter(|(name, _)| spec.parameters.iter().any(|p| p.name == *name))
            .map(|(name, value)| (name.to_string(), (*value).into()))
            .collect();
        let case = Case {
            problem: spec.id.into(),
            scene: spec.default_scene.into(),
            view: String::new(),
            seed: 0,
            parameters: knob::complete("parameter", spec.parameters, &given).unwrap(),
        };
        let prepared = problem.prepare(&case, None).unwrap();
        for technique in techniques {
            for knob in technique.knobs.iter().filter(|k| k.accuracy != Accuracy::None) {
                let errors = errors(spec, prepared.as_ref(), technique, &Dial::of(knob));
                let strayed = strays(knob.accuracy, &errors);
                assert!(
                    strayed <= SLACK,
                    "{} {}: {:?} by {strayed:.3}: {errors:?}",
                    technique.id,
                    knob.name,
                    knob.accuracy
                );
                checked += 1;
                // The control: that more of it is always better would be false of many.
                controls += usize::from(strays(Accuracy::Monotone, &errors) > SLACK);
            }
        }
    }
    assert!(checked >= 20 && controls >= 5, "{checked} declarations, {controls} controls");
}
