//! The problem end to end on small cases.

use super::{NightCase, NightCity, SPEC};
use crate::{
    SuiteError, case,
    case::Case,
    knob::{self, Knobs},
    problem::{Checked, Form, Prepared, Problem, Setting},
    testing,
};
use dapple_gpu::testing::test_gpu;
use serde_json::Value;
use std::{collections::BTreeSet, io::Write};

fn small(scene: &str) -> Case {
    let few = [("width", 24.into()), ("frames", 2.into()), ("truth_pixels", 60.into())];
    testing::case(&SPEC, scene, &few)
}

/// The same with one more parameter.
fn but(mut case: Case, name: &str, value: impl Into<Value>) -> Case {
    case.parameters.insert(name.into(), value.into());
    case
}

fn setting(technique: &str, variant: &str, form: Form, given: &[(&str, Value)]) -> Setting {
    testing::setting(&SPEC, technique, variant, form, given)
}

fn prepare(case: &Case) -> NightCase<'static> {
    NightCase::prepare(case, None).unwrap()
}

fn prepare_error(case: &Case) -> SuiteError {
    match NightCity.prepare(case, None) {
        Ok(_) => panic!("{} was accepted", case.scene),
        Err(error) => error,
    }
}

fn check(prepared: &NightCase<'_>, setting: &Setting) -> Checked {
    let checked = prepared.subject(setting).unwrap().check().unwrap();
    assert!(checked.violations.is_empty(), "{setting}: {:?}", checked.violations);
    for (name, error) in &checked.errors {
        assert!(error.is_finite() && *error >= 0.0, "{setting}: {name} is {error}");
    }
    checked
}

/// Past the harness, which keeps what a passing test prints to itself.
fn say(what: &str) {
    let _ = writeln!(std::io::stderr(), "{what}");
}

#[test]
fn every_technique_passes_its_check_in_every_variant_and_form() {
    let gpu = test_gpu();
    if gpu.is_none() {
        say("skipped: a city at night on a device: there is none");
    }
    let prepared = NightCase::prepare(&small("city_small"), gpu).unwrap();
    let (mut ran, mut expected) = (0, 0);
    for technique in SPEC.techniques {
        for variant in technique.variants {
            for form in technique.forms {
                if *form == Form::Gpu && gpu.is_none() || !technique.has(variant.id, *form) {
                    continue;
                }
                expected += 1;
                let s = setting(technique.id, variant.id, *form, &[]);
                let checked = check(&prepared, &s);
                let known: BTreeSet<&str> = SPEC.metrics.iter().map(|m| m.name).collect();
                let names: BTreeSet<&str> = checked.errors.keys().map(String::as_str).collect();
                assert!(names.is_subset(&known) && names.contains("error_p99"), "{s}: {names:?}");
                if technique.id != "reservoirs" {
                    assert_eq!(names, known, "{s}");
                    assert_eq!(checked.errors["lost_lights"], 0.0, "{s}");
                }
                assert!(checked.memory_bytes > 0 && checked.counters["objects_drawn"] > 0, "{s}");
                let mut subject = prepared.subject(&s).unwrap();
                subject.reset().unwrap();
                assert_eq!(subject.frames(), 2);
                for frame in 0..2 {
                    assert!(subject.frame(frame).unwrap().wall_ns > 0, "{s}");
                }
                let picture = subject.picture().unwrap().unwrap();
                assert_eq!(picture.result.len(), (picture.width * picture.height) as usize, "{s}");
                assert!(picture.truth.iter().any(|grey| *grey > 0.1), "{s}");
                ran += 1;
            }
        }
    }
    assert!(ran == expected && ran >= 7, "{ran} of {expected}");
}

#[test]
fn every_word_of_every_knob_runs_and_only_boxes_around_clusters_may_lose_light() {
    let prepared = prepare(&but(small("city_small"), "frames", 1));
    let mut ran = 0;
    for technique in SPEC.techniques {
        for own in technique.knobs {
            let knob::Range::Choice(words) = own.range else { continue };
            for word in words {
                let s = setting(technique.id, "", Form::Cpu, &[(own.name, (*word).into())]);
                let checked = check(&prepared, &s);
                let sound = checked.errors["lost_lights"] == 0.0;
                assert!(sound || *word == "bounding-boxes", "{s}: {:?}", checked.errors);
                ran += 1;
            }
        }
    }
    assert!(ran >= 12, "{ran}");
}

#[test]
fn techniques_rank_as_they_must_on_the_city() {
    let prepared = prepare(&small("city_small"));
    let errors = |technique: &str, given: &[(&str, Value)]| {
        check(&prepared, &setting(technique, "", Form::Cpu, given)).errors
    };
    let [full, cells] = ["full-tree", "facade-cluster"].map(|t| errors(t, &[]));
    assert!(cells["leak"] < 0.7 * full["leak"], "{} {}", cells["leak"], full["leak"]);
    assert!(cells["error_p99"] <= full["error_p99"]);
    let rays = errors("facade-cluster", &[("shadow_rays", "on".into())]);
    assert!(rays["leak"] < 0.5 * cells["leak"], "{} {}", rays["leak"], cells["leak"]);
    // Every light by itself, with a ray for each, is the truth.
    let exact = errors("traced-cut", &[("cut", 0.0.into())]);
    assert!(exact["error_max"] < 1e-4 && exact["leak"] < 1e-6, "{exact:?}");
}

#[test]
fn bad_names_and_parameters_say_what_to_do() {
    let known = prepare_error(&small("cty"));
    assert!(known.to_string().contains("no scene `cty`"), "{known}");
    let view = prepare_error(&Case { view: "moon".into(), ..small("city_small") });
    assert!(view.to_string().contains("no view `moon`; there is: street, turn, tour"), "{view}");
    let file = prepare_error(&small("no/such.osm.pbf"));
    assert!(file.to_string().contains("no/such.osm.pbf"), "{file}");
    for scene in ["cube", "grass"] {
        let none = prepare_error(&small(scene));
        assert!(none.to_string().contains(&format!("scene {scene} is no city")), "{none}");
        assert_eq!(none.exit_code(), 2);
    }
    for error in [known, view, file] {
        assert_eq!(error.exit_code(), 2, "{error}");
    }
}

#[test]
fn parameters_and_knobs_out_of_range_are_refused_with_their_limits() {
    for (name, value, limit) in [
        ("width", Value::from(7), "8..=7680"),
        ("frames", 0.into(), "1..=10000"),
        ("truth_pixels", 0.into(), "1..=100000000"),
        ("clamp", 0.0.into(), "..=1000"),
        ("blocks", 25.into(), "0..=24"),
    ] {
        let given = Knobs::from([(name.to_string(), value)]);
        let error = knob::complete("parameter", SPEC.parameters, &given).unwrap_err();
        assert!(error.to_string().contains(name) && error.to_string().contains(limit), "{error}");
        assert_eq!(error.exit_code(), 2, "{error}");
    }
    // Whoever sets them: what is read is held to the range as well.
    let prepared = prepare(&but(small("city_small"), "frames", 1));
    for (technique, knob, value, limit) in [
        ("full-tree", "cut", Value::from(-1.0), "0..=1000000000"),
        ("facade-cluster", "threshold", 1.5.into(), "0..=1"),
        ("facade-cluster", "tau", (1_i64 << 32).into(), "0..=2000000"),
        ("facade-cluster", "validity", (-1).into(), "0..=1000000"),
        ("facade-cluster", "most_split", "window".into(), "building"),
        ("facade-cluster", "shadow_rays", "some".into(), "on"),
        ("reservoirs", "candidates", 0.into(), "1..=4096"),
    ] {
        let mut s = setting(technique, "", Form::Cpu, &[]);
        s.knobs.insert(knob.into(), value);
        let error = prepared.subject(&s).map(|_| ()).unwrap_err();
        assert!(error.to_string().contains(knob) && error.to_string().contains(limit), "{error}");
        assert_eq!(error.exit_code(), 2, "{error}");
    }
    // Without a device there is no such form.
    assert!(prepared.subject(&setting("full-tree", "", Form::Gpu, &[])).is_err());
}

#[test]
fn a_view_is_a_path_or_a_still_that_is_repeated() {
    let first = prepare(&small("city_small"));
    assert_eq!(first.facts().view, "street");
    for (view, still) in [("street", false), ("turn", false), ("tour", false), ("facade", true)] {
        let prepared = prepare(&Case { view: view.into(), ..small("city_small") });
        assert_eq!(prepared.facts().view, view);
        let frames = &prepared.night().town.world(false).frames;
        assert_eq!(frames.len(), 2);
        assert_eq!(frames[0].points == frames[1].points, still, "{view}");
    }
}

#[test]
fn cities_from_files_take_nothing_for_hidden_that_is_seen() {
    for file in ["city/delft.city.json", "city/Helsinki.osm.pbf"] {
        if std::env::var_os(case::DATA_VARIABLE).is_none() {
            say(&format!("skipped: {file}: {} is not set", case::DATA_VARIABLE));
            continue;
        }
        let case = but(but(small(&format!("data:{file}")), "frames", 1), "truth_pixels", 24);
        let prepared = prepare(&case);
        let wide = [("least_step", Value::from(20.0)), ("tau", 200_000.into())];
        let cells = check(&prepared, &setting("facade-cluster", "", Form::Cpu, &wide)).errors;
        let full = check(&prepared, &setting("full-tree", "", Form::Cpu, &[])).errors;
        assert_eq!(cells["lost_lights"], 0.0, "{file}");
        assert!(cells["leak"] < full["leak"], "{file}: {cells:?} {full:?}");
        let blocks = prepare_error(&but(case, "blocks", 3));
        assert!(blocks.to_string().contains("not a generated city"), "{blocks}");
    }
}
