//! The extremes themselves: what they must leave alone, what they must break, what must be refused.

use super::{Loaded, axes, checked, made, of, walls, world};
use crate::{
    case::Case,
    problem::{Form, Setting},
    problems::camera_visibility::{SPEC, VisibilityCase, errors::Score, truth::Owned},
    stress::{
        Axis, edit,
        judge::{Home, Verdict},
        motion, testing as stress,
    },
    testing,
};
use std::collections::{BTreeMap, BTreeSet};

fn case(axis: &Axis) -> Case {
    stress::case(&SPEC, axis)
}

fn setting(technique: &str, variant: &str) -> Setting {
    testing::setting(&SPEC, technique, variant, Form::Cpu, &[])
}

fn axis(id: &str) -> Axis {
    stress::find(axes(), id)
}

/// More objects, triangles or columns show no more here than these do, in seconds less.
const MOST: u32 = 2_000;

/// Techniques that between them have every knob.
const PUSHED: &[&str] = &["chcpp", "hierarchical-depth", "masked"];

#[test]
fn every_axis_runs_at_its_ends_and_refuses_what_it_must() {
    let (all, mut ran, mut refused) = (axes(), 0, 0);
    assert!(all.len() >= 35, "{}", all.len());
    for axis in all {
        let case = case(&axis);
        for value in stress::ends(&axis, MOST) {
            let prepared = (axis.prepare)(&case, value, None);
            let meant = PUSHED.iter().filter(|t| (axis.setting)(&setting(t, ""), value).is_some());
            let meant: Vec<&&str> = meant.collect();
            assert!(!meant.is_empty(), "{} at {value} means nothing", axis.id);
            for technique in meant {
                let place = format!("{} at {value}, {technique}", axis.id);
                let judged =
                    stress::judged(&axis, &prepared, &setting(technique, ""), value, &Home::Here);
                let too_wide = axis.id == "opening" && value > 179.0;
                if (axis.must_refuse)(value) || too_wide {
                    assert_eq!(judged.verdict, Verdict::Refused, "{place}: {}", judged.reason);
                    refused += 1;
                    continue;
                }
                // The one end at which forms show different things: hidden behind half a snap.
                if axis.id == "slit" && value < 1.0 / 256.0 {
                    assert!(judged.reason.is_empty() || judged.reason.starts_with("port"));
                    continue;
                }
                assert_eq!(judged.verdict, Verdict::Safe, "{place}: {}", judged.reason);
                ran += 1;
            }
        }
    }
    assert!(ran >= 150 && refused >= 80, "{ran} ran, {refused} were refused");
}

#[test]
fn a_refusal_names_the_element_and_the_limit() {
    let expected = [
        ("bad-vertices", "nan", "chc", ["field: mesh 0", "vertex", "not finite"]),
        ("bad-vertices", "+inf", "chc", ["field: mesh 0", "vertex", "not finite"]),
        ("bad-vertices", "-inf", "chc", ["field: mesh 0", "vertex", "not finite"]),
        ("bad-vertices", "1e38", "chc", ["mesh 0", "vertex", "at most 1e9 m"]),
        ("bad-vertices", "index", "chc", ["mesh 0", "triangle 1", "there are 4"]),
        ("bad-vertices", "uv", "chc", ["mesh 0", "uv", "not finite"]),
        ("bad-vertices", "placement", "chc", ["instance 0", "transform", "not finite"]),
        ("bad-vertices", "mesh", "chc", ["instance 0", "mesh 77", "of 3"]),
        ("bad-vertices", "texture", "chc", ["texture 0", "0 texels", "needs 3"]),
        ("bad-cameras", "place-nan", "chc", ["key 1", "NaN", "finite"]),
        ("bad-cameras", "place-1e30", "chc", ["key 1", "position", "at most 1e9"]),
        ("bad-cameras", "no-direction", "chc", ["key 1", "target", "equals position"]),
        ("bad-cameras", "up-along", "chc", ["key 1", "up", "parallel"]),
        ("bad-cameras", "up-zero", "chc", ["key 1", "up", "no length"]),
        ("bad-cameras", "opening-0", "chc", ["key 1", "opening 0", "(0, pi)"]),
        ("bad-cameras", "opening-180", "chc", ["key 1", "opening 3.14", "(0, pi)"]),
        ("bad-cameras", "height-0", "chc", ["key 1", "height 0", "(0, 1e9]"]),
        ("bad-cameras", "height-inf", "chc", ["key 1", "height inf", "(0, 1e9]"]),
        ("bad-settings", "batch-0", "chcpp", ["`batch`", "= 0", "1..=200"]),
        ("bad-settings", "batch-2^32+50", "chcpp", ["`batch`", "= 4294967346", "1..=200"]),
        ("bad-settings", "tau-minus-1", "chc", ["`tau`", "= -1", "0..=1000"]),
        ("bad-settings", "tight-area-1e39", "chcpp", ["`tight_area`", "= 1e+39", "1..=4"]),
        ("bad-settings", "latency-2^32", "chc", ["`latency`", "= 4294967296", "0..=1000000"]),
        ("bad-settings", "across-2^32+2", "hierarchical-depth", ["`across`", "= 4294", "1..=64"]),
        ("bad-settings", "buffer-16385", "masked", ["`buffer`", "= 16385", "0..=8192"]),
        ("bad-settings", "occluders-minus-1", "masked", ["`occluder_triangles`", "= -1", "0..="]),
        ("bad-settings", "tree-oak", "frustum", ["`tree`", "oak", "bottom-up"]),
        ("content", "empty-view", "chc", ["scene field", "view made", "shows anything"]),
        ("content", "nothing", "chc", ["field", "no triangle", "needs one"]),
    ];
    for (id, word, technique, parts) in expected {
        let axis = axis(id);
        let value = axis.values.parse(id, word).unwrap();
        let prepared = (axis.prepare)(&case(&axis), value, None);
        let judged = stress::judged(&axis, &prepared, &setting(technique, ""), value, &Home::Here);
        assert_eq!(judged.verdict, Verdict::Refused, "{id} {word}");
        for part in parts {
            assert!(judged.reason.contains(part), "{id} {word}: {}", judged.reason);
        }
    }
}

/// The verdict on a technique at a value, judged by itself at home.
fn verdict(id: &str, technique: &str, variant: &str, value: f64) -> (Verdict, String) {
    let axis = axis(id);
    let (case, setting) = (case(&axis), setting(technique, variant));
    let at = |value, home: &Home| {
        stress::judged(&axis, &(axis.prepare)(&case, value, None), &setting, value, home)
    };
    let home = at(axis.home, &Home::Here);
    assert_eq!(home.verdict, Verdict::Safe, "{id}, {technique}: {}", home.reason);
    let judged = at(value, &Home::Error(home.error.unwrap()));
    (judged.verdict, judged.reason)
}

#[test]
fn what_gives_up_pixels_breaks_and_what_does_not_holds() {
    for technique in ["stop-and-wait", "chc", "chcpp"] {
        let (broken, reason) = verdict("tau", technique, "", 320.0);
        assert!(broken == Verdict::Broken && reason.contains("missed"), "{technique}: {reason}");
    }
    for technique in ["chc", "chcpp"] {
        assert_eq!(verdict("speed", technique, "next-frame", 1000.0).0, Verdict::Broken);
        assert_eq!(verdict("speed", technique, "exact", 1000.0).0, Verdict::Safe);
    }
    // Nothing hides anything: it pays as little as the frustum alone.
    let (broken, reason) = verdict("occluders", "masked", "meshes", 0.0);
    assert!(broken == Verdict::Broken && reason.contains("overdraw"), "{reason}");
}

fn loaded(case: &Case) -> Loaded {
    super::load(case).unwrap()
}

fn prepared(loaded: Loaded, case: &Case) -> VisibilityCase<'static> {
    VisibilityCase::of(checked(loaded).unwrap(), case, None).unwrap()
}

/// Share of what two truths own, in sure pixels, that one alone has.
fn difference(a: &VisibilityCase<'_>, b: &VisibilityCase<'_>) -> f64 {
    let sure = |case: &VisibilityCase<'_>| -> BTreeMap<(usize, u32), u32> {
        let frames = case.truth().frames.iter().enumerate();
        frames.flat_map(|(f, owned)| owned.iter().map(move |o| ((f, o.object), o.sure))).collect()
    };
    let (a, b) = (sure(a), sure(b));
    let keys: BTreeSet<_> = a.keys().chain(b.keys()).collect();
    let of = |map: &BTreeMap<(usize, u32), u32>, key| map.get(key).copied().unwrap_or(0);
    let apart: u32 = keys.iter().map(|key| of(&a, *key).abs_diff(of(&b, *key))).sum();
    f64::from(apart) / f64::from(a.values().sum::<u32>())
}

#[test]
fn the_truth_of_a_scaled_or_moved_scene_is_that_of_the_scene() {
    let case = case(&axis("scale"));
    let home = prepared(loaded(&case), &case);
    for (what, pushed) in [
        ("1e-6", world::scaled(loaded(&case), 1e-6)),
        ("1e6", world::scaled(loaded(&case), 1e6)),
        ("1 radius", world::moved(loaded(&case), 1.0)),
        ("1e7 radii", world::moved(loaded(&case), 1e7)),
    ] {
        let pushed = prepared(pushed, &case);
        assert!(difference(&home, &pushed) < 0.002, "{what}: {}", difference(&home, &pushed));
        let [a, b] = [&home, &pushed].map(|case| case.inner().unwrap().len());
        assert!(a == b && a > 0, "{what}: {a} boxes, {b}");
    }
    // Placed in f32 coordinates it would not survive the same move.
    let mut naive = world::moved(loaded(&case), 1e7);
    naive = of(edit::in_single_precision(naive.scene));
    let apart = checked(naive)
        .and_then(|naive| VisibilityCase::of(naive, &case, None))
        .map_or(1.0, |naive| difference(&home, &naive));
    assert!(apart > 0.1, "{apart}");
}

#[test]
fn a_slit_shows_what_is_behind_it_and_leaving_that_out_is_noticed() {
    let case = case(&axis("slit"));
    let at = |slit_px, turn| prepared(of(walls::behind_a_slit(slit_px, turn, &case)), &case);
    // Objects 0 and 1 are the walls.
    let behind = |case: &VisibilityCase<'_>| -> Vec<Vec<u32>> {
        let frame = |owned: &Vec<Owned>| {
            owned.iter().filter(|o| o.object > 1 && o.sure > 0).map(|o| o.object).collect()
        };
        case.truth().frames.iter().map(frame).collect()
    };
    for turn in [0.0, 0.21] {
        // Rasterisers may close what is narrower than the distance at which an owner is sure.
        assert!(behind(&at(1e-3, turn)).iter().all(Vec::is_empty));
        // Aslant it passes beside the centres of all rows by up to a tenth of a pixel.
        for slit_px in if turn > 0.0 { [0.5, 1.0, 10.0] } else { [0.0625, 1.0, 10.0] } {
            let case = at(slit_px, turn);
            let behind = behind(&case);
            assert!(behind.iter().all(|seen| !seen.is_empty()), "{slit_px} {turn}: {behind:?}");
            let mut score = Score::default();
            for frame in 0..case.views().len() {
                score.add(&case, frame, &[0, 1], 0);
            }
            assert!(score.errors()["missed"] > 0.0, "{slit_px}");
        }
    }
}

#[test]
fn a_cube_around_the_eye_is_all_that_is_seen() {
    let axis = axis("content");
    let case = case(&axis);
    let value = axis.values.parse("content", "inside-a-cube").unwrap();
    let prepared = (axis.prepare)(&case, value, None).unwrap();
    for technique in SPEC.techniques.iter().filter(|t| t.id != "none" && t.id != "frustum") {
        let s = setting(technique.id, "");
        let checked = prepared.subject(&s).unwrap().check().unwrap();
        assert!(checked.violations.is_empty(), "{s}: {:?}", checked.violations);
        let few = 8 * checked.counters["frames"];
        let all = 300 * checked.counters["frames"];
        assert!(checked.counters["draws"] < all, "{s}: {} of {few}", checked.counters["draws"]);
    }
}

#[test]
fn triangles_without_area_own_nothing() {
    let case = case(&axis("degenerate"));
    let one = |scene| prepared(of(world::as_one_mesh(scene)), &case);
    let home = one(made::field(60, 0));
    let more = |count| {
        let scene = world::as_one_mesh(made::field(60, 0));
        prepared(of(edit::with_degenerate_triangles(scene, count, 0)), &case)
    };
    let owners = |case: &VisibilityCase<'_>| -> Vec<(u32, u32)> {
        let sum = |f: fn(&Owned) -> u32| case.truth().frames.last().unwrap().iter().map(f).sum();
        vec![(sum(|o| o.samples), sum(|o| o.triangles))]
    };
    let with = more(3_000);
    assert_eq!(owners(&home), owners(&with));
    let drawn = |case: &VisibilityCase<'_>| -> u64 {
        let objects = 0..case.objects().objects.len() as u32;
        objects.map(|object| u64::from(case.objects().triangle_count(object))).sum()
    };
    assert!(drawn(&with) >= drawn(&home), "{} {}", drawn(&with), drawn(&home));
}

#[test]
fn a_walk_takes_even_steps_and_a_turn_even_angles() {
    let case = case(&axis("speed"));
    let scene = loaded(&case).scene;
    let still: Vec<_> = (0..3).map(|i| motion::walk(&scene, 0.0, i).unwrap().position).collect();
    assert!(still[0] == still[1] && still[1] == still[2]);
    for speed in [1e-3, 0.5, 2.0] {
        let [a, b] = [1, 2].map(|i| motion::walk(&scene, speed, i).unwrap().position);
        assert!((a.distance(b) / speed - 1.0).abs() < 1e-6, "{speed}: {a} {b}");
    }
    for speed in [1e3, 1e4] {
        let far: Vec<_> =
            (0..6).map(|i| motion::walk(&scene, speed, i).unwrap().position).collect();
        assert!(far.iter().all(|p| p.is_finite()));
        assert!(far.windows(2).all(|pair| pair[0].distance(pair[1]) > 1.0), "{speed}: {far:?}");
    }
    for degrees in [1e-3, 30.0, 180.0] {
        let [a, b] = [3, 4].map(|i| motion::spin(&scene, degrees, i).unwrap());
        assert_eq!(a.position, b.position);
        let [a, b] = [a, b].map(|c| c.target - c.position);
        let angle = a.angle_between(b).to_degrees();
        // Views that look down turn by less.
        assert!(angle <= degrees + 1e-6 && angle > 0.5 * degrees, "{degrees}: {angle}");
    }
}
