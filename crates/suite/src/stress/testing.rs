//! What the tests of problems' extremes share.

use super::{
    Axis, Values,
    judge::{self, Home, Judgement},
};
use crate::{
    SuiteError,
    case::Case,
    knob::Knobs,
    problem::{Checked, Prepared, Setting, Spec},
};
use std::collections::BTreeSet;

/// The axis of that name.
pub fn find(axes: Vec<Axis>, id: &str) -> Axis {
    axes.into_iter().find(|axis| axis.id == id).unwrap()
}

/// The case that an axis is probed in.
pub fn case(spec: &Spec, axis: &Axis) -> Case {
    Case {
        problem: spec.id.into(),
        scene: spec.default_scene.into(),
        view: String::new(),
        seed: 0,
        parameters: axis.case_parameters(spec, &Knobs::new()).unwrap(),
    }
}

/// What a technique found at a value, as the engine judges it.
pub fn judged(
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

/// Home and the ends; every position of words. Of whole numbers none above `most`: more texels or
/// triangles show no more in a test, and take seconds.
pub fn ends(axis: &Axis, most: u32) -> Vec<f64> {
    match axis.values {
        Values::Log { least, greatest, .. } | Values::Linear { least, greatest, .. } => {
            vec![axis.home, least, greatest]
        }
        Values::FromZero { least, greatest, .. } => vec![axis.home, 0.0, least, greatest],
        Values::Whole { least, greatest, .. } => {
            vec![axis.home, least.into(), greatest.min(most).into()]
        }
        Values::Words(words) => (0..words.len()).map(|i| i as f64).collect(),
    }
}

/// What a technique found at a value, or why it was refused. No invariant may be broken.
pub fn check(
    axis: &Axis,
    case: &Case,
    setting: &Setting,
    value: f64,
) -> Result<Checked, SuiteError> {
    check_prepared(axis, (axis.prepare)(case, value, None)?.as_ref(), setting, value)
}

/// The same of a case that is prepared.
pub fn check_prepared(
    axis: &Axis,
    prepared: &dyn Prepared,
    setting: &Setting,
    value: f64,
) -> Result<Checked, SuiteError> {
    let setting = (axis.setting)(setting, value).unwrap();
    let checked = prepared.subject(&setting)?.check()?;
    let place = format!("{} at {value}, {}", axis.id, setting.technique);
    assert!(checked.violations.is_empty(), "{place}: {:?}", checked.violations);
    for (name, error) in &checked.errors {
        assert!(error.is_finite(), "{place}: {name} is {error}");
    }
    Ok(checked)
}

/// Runs every axis at its ends, each with the first setting that it means something to: what is bad
/// must be refused as bad input, all else must run with a share of that metric, unless it
/// `may_refuse` the value. How many ran and how many were refused.
pub fn run_ends(
    axes: &[Axis],
    case: &Case,
    settings: &[Setting],
    metric: &str,
    most: fn(&Axis) -> u32,
    may_refuse: fn(&Axis, f64) -> bool,
) -> [u32; 2] {
    let [mut ran, mut refused] = [0, 0];
    for axis in axes {
        for value in ends(axis, most(axis)) {
            let fits = |setting: &&Setting| (axis.setting)(setting, value).is_some();
            let Some(setting) = settings.iter().find(fits) else {
                panic!("{} at {value} means nothing", axis.id);
            };
            let place = format!("{} at {value}, {}", axis.id, setting.technique);
            match check(axis, case, setting, value) {
                Ok(checked) => {
                    assert!(!(axis.must_refuse)(value), "{place} was accepted");
                    let error = checked.errors[metric];
                    assert!((0.0..=1.0).contains(&error), "{place}: {error}");
                    ran += 1;
                }
                Err(error) => {
                    assert_eq!(error.exit_code(), 2, "{place}: {error}");
                    let may = (axis.must_refuse)(value) || may_refuse(axis, value);
                    assert!(may, "{place}: {error}");
                    refused += 1;
                }
            }
        }
    }
    [ran, refused]
}

/// Axis, word, technique, and what the refusal must say.
pub type Refusal = (&'static str, &'static str, &'static str, [&'static str; 3]);

/// Holds each refusal to what it must name. At home each axis among them must run.
pub fn expect_refusals(
    axes: &[Axis],
    case: &Case,
    setting: fn(&str) -> Setting,
    expected: &[Refusal],
) {
    let mut seen = BTreeSet::new();
    for (id, word, technique, parts) in expected {
        let (axis, setting) = (axes.iter().find(|a| a.id == *id).unwrap(), setting(technique));
        let value = axis.values.parse(id, word).unwrap();
        let error = check(axis, case, &setting, value).unwrap_err().to_string();
        for part in parts {
            assert!(error.contains(part), "{id} {word}: {error}");
        }
        if seen.insert(id) {
            check(axis, case, &setting, axis.home).unwrap();
        }
    }
}
