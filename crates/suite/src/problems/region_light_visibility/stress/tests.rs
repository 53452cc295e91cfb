//! The extremes themselves: what they must leave alone, what they must break, what must be refused.

use super::axes;
use crate::{
    case::Case,
    problem::{Form, Setting, Technique},
    problems::region_light_visibility::SPEC,
    stress::{
        Axis,
        judge::{Home, Judgement, Verdict},
        testing as stress,
    },
    testing,
};

fn case(axis: &Axis) -> Case {
    stress::case(&SPEC, axis)
}

fn setting(technique: &str) -> Setting {
    testing::setting(&SPEC, technique, "", Form::Cpu, &[])
}

fn axis(id: &str) -> Axis {
    stress::find(axes(), id)
}

/// More columns, lamps, points or texels show no more here than these do, in seconds less.
const MOST: u32 = 300;

/// Whether a case may be refused there though nothing about it is bad: nothing is seen of it that a
/// light could reach.
fn may_show_nothing(axis: &Axis, value: f64) -> bool {
    let label = axis.values.label(value);
    match axis.id {
        "camera" => ["in-a-house", "below-ground", "far-away"].contains(&label.as_str()),
        // A single pixel shows the sky.
        "columns" => value == 1.0,
        // As dim from near as from so far away.
        "clamp" => value > 10.0,
        _ => false,
    }
}

#[test]
fn no_light_is_lost_at_the_ends_of_any_axis_and_bad_input_is_refused() {
    let (all, mut ran, mut refused, mut wrong) = (axes(), 0, 0, Vec::new());
    assert!(all.len() >= 40, "{}", all.len());
    for axis in all {
        let case = case(&axis);
        for value in stress::ends(&axis, MOST) {
            let prepared = (axis.prepare)(&case, value, None);
            let of = |technique: &Technique| setting(technique.id);
            let meant = |technique: &&Technique| (axis.setting)(&of(technique), value).is_some();
            let meant: Vec<Setting> = SPEC.techniques.iter().filter(meant).map(of).collect();
            assert!(!meant.is_empty(), "{} at {value} means nothing", axis.id);
            for setting in meant {
                let place = format!("{} at {}, {setting}", axis.id, axis.values.label(value));
                let judged = stress::judged(&axis, &prepared, &setting, value, &Home::Here);
                let Judgement { verdict, error, ref reason, .. } = judged;
                let refuses = (axis.must_refuse)(value);
                let lost = axis.criterion.metric == "false_hidden"
                    && error.is_some_and(|error| error > 0.0)
                    && setting.technique != "sampled"
                    && axis.values.label(value) != "bounding-boxes";
                let right = match verdict {
                    Verdict::Refused => refuses || may_show_nothing(&axis, value),
                    Verdict::Safe => !refuses && !lost,
                    _ => false,
                };
                if !right {
                    wrong.push(format!("{place}: {verdict:?} {error:?} {reason}"));
                }
                match verdict {
                    Verdict::Refused => refused += 1,
                    _ => ran += 1,
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(ran >= 400 && refused >= 100, "{ran} ran, {refused} were refused");
}

#[test]
fn a_refusal_names_the_element_and_the_limit() {
    let expected = [
        ("bad-vertices", "nan", "all-lights", ["mesh 0", "vertex", "not finite"]),
        ("bad-vertices", "1e38", "all-lights", ["mesh 0", "vertex", "at most 1e9 m"]),
        ("bad-vertices", "index", "all-lights", ["mesh 0", "triangle", "there are"]),
        ("bad-vertices", "placement", "all-lights", ["instance 0", "transform", "not finite"]),
        ("bad-vertices", "albedo", "all-lights", ["material 0", "albedo", ""]),
        ("bad-city", "base-nan", "all-lights", ["instance", "transform", "finite"]),
        ("bad-city", "roof-nan", "all-lights", ["mesh", "not finite", ""]),
        ("bad-city", "light-nan", "all-lights", ["light 3", "position", "finite"]),
        ("bad-city", "light-1e10", "all-lights", ["light 3", "coordinate", "1e9 m"]),
        ("bad-city", "light-axis-0", "all-lights", ["light 3", "axis", "unit length"]),
        ("bad-city", "light-cone-0", "all-lights", ["light 3", "half angle", "(0, π]"]),
        ("bad-city", "light-negative", "all-lights", ["light 3", "intensity", "negative"]),
        ("bad-city", "camera-nan", "all-lights", ["key 1", "NaN", "finite"]),
        ("bad-parameters", "clamp-0", "all-lights", ["clamp", "1e-6", "1e6 m"]),
        ("bad-settings", "least-step-minus-1", "facade-cluster", ["`least_step`", "-1", "0..="]),
        ("bad-settings", "divisions-65", "facade-cluster", ["`divisions`", "= 65", "-1..=64"]),
        ("bad-settings", "edge-round", "facade-cluster", ["`edge`", "round", "sloped"]),
        ("bad-settings", "texels-15", "extended-projection", ["`texels`", "= 15", "16..=4096"]),
        ("bad-settings", "rays-0", "sampled", ["`rays`", "= 0", "1..=16384"]),
        ("bad-truth", "no-faces", "all-lights", ["city_small", "no face", "light"]),
        ("content", "no-light", "all-lights", ["no light", "burns", ""]),
        ("content", "all-dark", "all-lights", ["no face", "light", "matter"]),
        ("content", "nothing", "all-lights", ["no triangle", "needs one", ""]),
    ];
    for (id, word, technique, parts) in expected {
        let axis = axis(id);
        let value = axis.values.parse(id, word).unwrap();
        let prepared = (axis.prepare)(&case(&axis), value, None);
        let judged = stress::judged(&axis, &prepared, &setting(technique), value, &Home::Here);
        assert_eq!(judged.verdict, Verdict::Refused, "{id} {word}: {}", judged.reason);
        for part in parts {
            assert!(judged.reason.contains(part), "{id} {word}: {}", judged.reason);
        }
    }
}

/// The verdict on a technique at a value, judged by itself at home.
fn verdict(id: &str, technique: &str, value: f64) -> (Verdict, String) {
    let axis = axis(id);
    let (case, setting) = (case(&axis), setting(technique));
    let at = |value, home: &Home| {
        stress::judged(&axis, &(axis.prepare)(&case, value, None), &setting, value, home)
    };
    let home = at(axis.home, &Home::Here);
    assert_eq!(home.verdict, Verdict::Safe, "{id}, {technique}: {}", home.reason);
    let judged = at(value, &Home::Error(home.error.unwrap()));
    (judged.verdict, judged.reason)
}

#[test]
fn what_keeps_hidden_lights_breaks_and_what_does_not_holds() {
    for (id, technique, value) in [
        ("least-step", "facade-cluster", 1e4),
        ("divisions", "facade-cluster", 1.0),
        ("texels", "extended-projection", 16.0),
    ] {
        let (broken, reason) = verdict(id, technique, value);
        assert_eq!(broken, Verdict::Broken, "{id}, {technique}");
        assert!(reason.contains("kept_hidden"), "{id}, {technique}: {reason}");
    }
    for (id, technique, value) in [
        ("least-step", "facade-cluster", 0.0),
        ("projections", "facade-cluster", 1.0),
        ("edge", "facade-cluster", 2.0),
        ("scale", "facade-cluster", 1e-4),
        ("scale", "facade-cluster", 1e6),
        ("turn-of-city", "facade-cluster", 90.0),
        ("wall-gap", "facade-cluster", -3.0),
    ] {
        assert_eq!(verdict(id, technique, value), (Verdict::Safe, String::new()), "{id}");
    }
}
