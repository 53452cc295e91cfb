//! The extremes themselves: what they must leave alone, what they must break, what must be refused.

use super::axes;
use crate::{
    SuiteError,
    case::Case,
    knob::Knobs,
    problem::{Form, Prepared, Setting, Technique},
    problems::many_lights::SPEC,
    stress::{
        Axis,
        judge::{self, Home, Judgement, Verdict},
        testing as stress,
    },
    testing,
};

fn case(axis: &Axis) -> Case {
    Case {
        problem: SPEC.id.into(),
        scene: SPEC.default_scene.into(),
        view: String::new(),
        seed: 0,
        parameters: axis.case_parameters(&SPEC, &Knobs::new()).unwrap(),
    }
}

fn setting(technique: &str, variant: &str) -> Setting {
    testing::setting(&SPEC, technique, variant, Form::Cpu, &[])
}

fn axis(id: &str) -> Axis {
    stress::find(axes(), id)
}

/// More lights, columns or samples show no more here than these do, in seconds less.
const MOST: u32 = 1_000;

/// What a technique found at a value, as the engine judges it.
fn judged(
    axis: &Axis,
    prepared: &Result<Box<dyn Prepared + '_>, SuiteError>,
    setting: &Setting,
    value: f64,
    home: &Home,
) -> Judgement {
    let refused = (axis.must_refuse)(value);
    match prepared {
        Err(error) => Judgement::without(judge::verdict_of(error), error.to_string()),
        Ok(prepared) => {
            let pushed = (axis.setting)(setting, value).unwrap();
            let found = prepared.subject(&pushed).and_then(|mut subject| subject.check());
            judge::judge(&axis.criterion, home, refused, &found)
        }
    }
}

#[test]
fn every_axis_runs_at_its_ends_and_refuses_what_it_must() {
    let (all, mut ran, mut refused) = (axes(), 0, 0);
    assert!(all.len() >= 45, "{}", all.len());
    for axis in all {
        let case = case(&axis);
        for value in stress::ends(&axis, MOST) {
            let prepared = (axis.prepare)(&case, value, None);
            let of = |technique: &Technique| setting(technique.id, "");
            let meant = |technique: &&Technique| (axis.setting)(&of(technique), value).is_some();
            let meant: Vec<Setting> = SPEC.techniques.iter().filter(meant).map(of).collect();
            assert!(!meant.is_empty(), "{} at {value} means nothing", axis.id);
            for setting in meant {
                let place = format!("{} at {value}, {setting}", axis.id);
                let judged = judged(&axis, &prepared, &setting, value, &Home::Here);
                // Clamps beyond what single precision holds.
                let limit = axis.id == "scale" && value < 1e-5;
                if (axis.must_refuse)(value) || limit {
                    assert_eq!(judged.verdict, Verdict::Refused, "{place}: {}", judged.reason);
                    refused += 1;
                    continue;
                }
                assert_eq!(judged.verdict, Verdict::Safe, "{place}: {}", judged.reason);
                ran += 1;
            }
        }
    }
    assert!(ran >= 400 && refused >= 80, "{ran} ran, {refused} were refused");
}
