//! The extremes themselves: what they must leave alone, what they must break, what must be refused.

use super::axes;
use crate::{
    case::Case,
    problem::{Form, Setting, Technique},
    problems::night_city::SPEC,
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

/// More columns, lamps or candidates show no more here than these do, in seconds less.
const MOST: u32 = 300;

#[test]
fn no_light_is_taken_for_hidden_at_the_ends_of_any_axis_and_bad_input_is_refused() {
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
                let lost = axis.criterion.metric == "lost_lights"
                    && error.is_some_and(|error| error > 0.0)
                    && axis.values.label(value) != "bounding-boxes";
                // A camera far away in a small image may see nothing, and a single pixel the sky.
                let label = axis.values.label(value);
                let nothing = axis.id == "camera" && label == "far-away"
                    || axis.id == "columns" && value == 1.0;
                let right = match verdict {
                    Verdict::Refused => refuses || nothing,
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
        ("bad-vertices", "nan", "full-tree", ["mesh 0", "vertex", "not finite"]),
        ("bad-vertices", "placement", "full-tree", ["instance 0", "transform", "not finite"]),
        ("bad-vertices", "albedo", "full-tree", ["material 0", "albedo", ""]),
        ("bad-city", "base-nan", "full-tree", ["instance", "transform", "finite"]),
        ("bad-city", "light-nan", "full-tree", ["light 3", "position", "finite"]),
        ("bad-city", "light-inf", "full-tree", ["light 3", "intensity", "finite"]),
        ("bad-city", "light-cone-nan", "full-tree", ["light 3", "half angle", "(0, π]"]),
        ("bad-city", "camera-no-direction", "full-tree", ["key 1", "target", "equals position"]),
        ("bad-parameters", "clamp-minus-1", "full-tree", ["clamp", "1e-6", "1e6 m"]),
        ("bad-settings", "cut-minus-1", "full-tree", ["`cut`", "= -1", "0..="]),
        ("bad-settings", "threshold-2", "facade-cluster", ["`threshold`", "= 2", "0..=1"]),
        ("bad-settings", "tau-minus-1", "facade-cluster", ["`tau`", "= -1", "0..=2000000"]),
        (
            "bad-settings",
            "validity-2^32+50",
            "facade-cluster",
            ["`validity`", "4294967346", "0..="],
        ),
        ("bad-settings", "candidates-0", "reservoirs", ["`candidates`", "= 0", "1..=4096"]),
        ("bad-settings", "neighbours-65", "reservoirs", ["`neighbours`", "= 65", "0..=64"]),
        ("content", "no-light", "full-tree", ["no light", "burns", ""]),
        ("content", "empty-view", "full-tree", ["view made", "no frame", "shows anything"]),
        ("content", "nothing", "full-tree", ["no triangle", "needs one", ""]),
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
fn what_gives_up_light_breaks_and_what_does_not_holds() {
    for (id, technique, value) in [
        ("cut", "full-tree", 1e6),
        ("cut", "traced-cut", 1e9),
        ("threshold", "facade-cluster", 1.0),
    ] {
        let (broken, reason) = verdict(id, technique, value);
        assert_eq!(broken, Verdict::Broken, "{id}, {technique}");
        assert!(reason.contains("error_p99"), "{id}, {technique}: {reason}");
    }
    for (id, technique, value) in [
        ("cut", "traced-cut", 0.0),
        ("threshold", "facade-cluster", 0.0),
        ("shadow-rays", "facade-cluster", 1.0),
        ("validity", "facade-cluster", 1.0),
        ("validity", "facade-cluster", 0.0),
        ("scale", "facade-cluster", 1e-4),
        ("scale", "facade-cluster", 1e6),
        ("speed", "facade-cluster", 1e4),
    ] {
        assert_eq!(verdict(id, technique, value), (Verdict::Safe, String::new()), "{id}");
    }
}
