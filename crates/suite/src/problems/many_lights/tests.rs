//! The problem end to end on small cases.

use super::{LightsCase, ManyLights, SPEC};
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
    let few = [("width", 24.into()), ("frames", 2.into()), ("truth_pixels", 200.into())];
    testing::case(&SPEC, scene, &few)
}

/// The same with one more parameter.
fn but(mut case: Case, name: &str, value: impl Into<Value>) -> Case {
    case.parameters.insert(name.into(), value.into());
    case
}

fn seen_from(case: Case, view: &str) -> Case {
    Case { view: view.into(), ..case }
}

fn setting(technique: &str, variant: &str, form: Form, given: &[(&str, Value)]) -> Setting {
    testing::setting(&SPEC, technique, variant, form, given)
}

fn prepare(case: &Case) -> LightsCase<'static> {
    LightsCase::prepare(case, None).unwrap()
}

fn prepare_error(case: &Case) -> SuiteError {
    match ManyLights.prepare(case, None) {
        Ok(_) => panic!("{} was accepted", case.scene),
        Err(error) => error,
    }
}

fn check(prepared: &LightsCase<'_>, setting: &Setting) -> Checked {
    let checked = prepared.subject(setting).unwrap().check().unwrap();
    assert!(checked.violations.is_empty(), "{setting}: {:?}", checked.violations);
    for (name, error) in &checked.errors {
        assert!(error.is_finite(), "{setting}: {name} is {error}");
    }
    checked
}

/// Past the harness, which keeps what a passing test prints to itself.
fn say(what: &str) {
    let _ = writeln!(std::io::stderr(), "{what}");
}

/// A real model, as the command line names it; says so where there is none.
fn real(path: &str) -> Option<Case> {
    if std::env::var_os(case::DATA_VARIABLE).is_none() {
        say(&format!("skipped: {path}: {} is not set", case::DATA_VARIABLE));
        return None;
    }
    Some(small(&format!("data:{path}")))
}

/// Checks the default variant of every technique on the processor; their errors.
fn check_all(prepared: &LightsCase<'_>) -> Vec<(&'static str, f64)> {
    let one = |technique: &'static crate::problem::Technique| {
        let s = setting(technique.id, "", Form::Cpu, &[]);
        (technique.id, check(prepared, &s).errors["error_p99"])
    };
    SPEC.techniques.iter().map(one).collect()
}

fn of(found: &[(&str, f64)], technique: &str) -> f64 {
    found.iter().find(|(id, _)| *id == technique).unwrap().1
}

#[test]
fn every_technique_passes_its_check_in_every_variant_and_form() {
    let gpu = test_gpu();
    if gpu.is_none() {
        say("skipped: many lights on a device: there is none");
    }
    let prepared = LightsCase::prepare(&but(small("light_cloud"), "lights", 150), gpu).unwrap();
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
                let names: BTreeSet<&str> = checked.errors.keys().map(String::as_str).collect();
                assert_eq!(names, SPEC.metrics.iter().map(|m| m.name).collect(), "{s}");
                assert_eq!(checked.counters["frames"], 2, "{s}");
                assert!(checked.memory_bytes > 0, "{s}");
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
    assert!(ran == expected && ran >= 24, "{ran} of {expected}");
}

#[test]
fn techniques_rank_as_they_must_on_the_city() {
    let found = check_all(&prepare(&small("city_small")));
    assert!(of(&found, "brute-force") < 1e-5, "{found:?}");
    assert!(of(&found, "absolute-cut") < 2.0 / 255.0, "{found:?}");
    for technique in ["light-bvh", "stochastic-lightcuts", "reservoirs", "capped"] {
        assert!(of(&found, technique) > of(&found, "absolute-cut"), "{found:?}");
    }
}

#[test]
fn lights_of_several_kinds_are_lit_in_one_scene() {
    let helsinki = real("city/Helsinki.osm.pbf").map(|case| (case, 2));
    for (case, kinds) in [(small("light_cloud"), 3)].into_iter().chain(helsinki) {
        let prepared = prepare(&but(but(case, "width", 16), "frames", 1));
        let lights = &prepared.world().lights;
        let codes: BTreeSet<u32> = lights.iter().map(|light| light.emission.code()).collect();
        assert_eq!(codes.len(), kinds, "{}", prepared.facts().scene);
        let s = setting("absolute-cut", "pixel", Form::Cpu, &[("threshold", 0.0.into())]);
        assert!(check(&prepared, &s).errors["error_max"] < 1e-4, "{}", prepared.facts().scene);
    }
    for emission in ["omni", "oriented", "spot", "directional"] {
        let case = but(but(small("light_cloud"), "lights", 60), "emission", emission);
        let prepared = prepare(&case);
        let first = prepared.world().lights[0].emission.code();
        assert!(prepared.world().lights.iter().all(|light| light.emission.code() == first));
        check_all(&prepared);
    }
}

#[test]
fn bad_names_and_parameters_say_what_to_do() {
    let known = prepare_error(&small("cty"));
    assert!(known.to_string().contains("no scene `cty`"), "{known}");
    let view = prepare_error(&seen_from(small("city_small"), "moon"));
    assert!(view.to_string().contains("no view `moon`; there is: street, turn, tour"), "{view}");
    let file = prepare_error(&small("no/such.obj"));
    assert!(file.to_string().contains("no/such.obj"), "{file}");
    let city = prepare_error(&small("no/such.city.json"));
    assert!(city.to_string().contains("no/such.city.json"), "{city}");
    for error in [known, view, file, city] {
        assert_eq!(error.exit_code(), 2, "{error}");
    }
}

#[test]
fn parameters_and_knobs_out_of_range_are_refused_with_their_limits() {
    for (name, value, limit) in [
        ("width", 7.into(), "8..=7680"),
        ("frames", 0.into(), "1..=10000"),
        ("truth_pixels", 0.into(), "1..=100000000"),
        ("clamp", 0.0.into(), "..=1000"),
        ("lights", 1_000_001.into(), "0..=1000000"),
        ("lit", "moon".into(), "lamps"),
        ("emission", "laser".into(), "oriented"),
        ("visibility", "maybe".into(), "on"),
    ] {
        let given = Knobs::from([(name.to_string(), value)]);
        let error = knob::complete("parameter", SPEC.parameters, &given).unwrap_err();
        assert!(error.to_string().contains(name) && error.to_string().contains(limit), "{error}");
        assert_eq!(error.exit_code(), 2, "{error}");
    }
    // Whoever sets them: what is read is held to the range as well.
    let prepared = prepare(&but(small("light_cloud"), "lights", 5));
    for (technique, knob, value, limit) in [
        ("absolute-cut", "threshold", Value::from(-1.0), "0..=1000000000"),
        ("capped", "most", ((1_i64 << 32) + 1).into(), "1..=1000000"),
        ("light-bvh", "samples", 0.into(), "1..=4096"),
        ("reservoirs", "history", (-1).into(), "1..=1000"),
        ("clustered", "cutoff", 0.0.into(), "..=1"),
        ("lightcuts", "tree", "oak".into(), "median"),
    ] {
        let mut s = setting(technique, "", Form::Cpu, &[]);
        s.knobs.insert(knob.into(), value);
        let error = prepared.subject(&s).map(|_| ()).unwrap_err();
        assert!(error.to_string().contains(knob) && error.to_string().contains(limit), "{error}");
        assert_eq!(error.exit_code(), 2, "{error}");
    }
}

#[test]
fn parameters_are_refused_by_name_where_they_do_not_apply() {
    for (scene, name, value) in [
        ("city_small", "lights", Value::from(9)),
        ("light_facade", "lights", 9.into()),
        ("light_cloud", "lit", "lamps".into()),
        ("light_facade", "lit", "windows".into()),
        ("light_cloud", "blocks", 3.into()),
        ("light_cloud", "street", 20.0.into()),
        ("cube", "lit", "lamps".into()),
        ("cube", "layout", "grid".into()),
    ] {
        let error = prepare_error(&but(small(scene), name, value));
        assert!(error.to_string().contains(scene), "{error}");
        assert!(error.to_string().contains(&format!("`{name}` does not apply")), "{error}");
        assert_eq!(error.exit_code(), 2);
    }
    let prepared = prepare(&but(small("cube"), "lights", 20));
    let city = setting("absolute-cut", "", Form::Cpu, &[("tree", "city".into())]);
    let error = prepared.subject(&city).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("`tree` = city does not apply"), "{error}");
    assert_eq!(error.exit_code(), 2);
}

#[test]
fn a_view_is_a_path_or_a_still_that_is_repeated() {
    let first = prepare(&small("city_small"));
    assert_eq!(first.facts().view, "street");
    for (view, still) in [("street", false), ("turn", false), ("tour", false), ("facade", true)] {
        let prepared = prepare(&seen_from(small("city_small"), view));
        assert_eq!(prepared.facts().view, view);
        let frames = &prepared.world().frames;
        assert_eq!(frames.len(), 2);
        assert_eq!(frames[0].points == frames[1].points, still, "{view}");
    }
}

#[test]
fn a_users_mesh_is_lit_by_its_own_lights_or_by_random_ones() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("roof.obj");
    let roof = "v 0 0 0\nv 4 0 0\nv 4 0 4\nv 0 0 4\nv 2 3 2\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n\
                f 1 4 3 2\n";
    std::fs::write(&path, roof).unwrap();
    let case = small(path.to_str().unwrap());
    let own = prepare(&case);
    assert!(own.facts().notes.iter().any(|n| n.contains("own lights")), "{:?}", own.facts().notes);
    let random = prepare(&but(case.clone(), "lights", 40));
    assert_eq!(random.world().lights.len(), 40);
    assert!(random.facts().notes.iter().any(|n| n.contains("40 random lights")));
    let shadowed = prepare(&but(but(case, "lights", 40), "visibility", "on"));
    for prepared in [own, random, shadowed] {
        let found = check_all(&prepared);
        assert!(of(&found, "brute-force") < 1e-4, "{found:?}");
    }
}

#[test]
fn files_that_are_broken_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [
        ("empty.obj", ""),
        ("cut.obj", "v 0 0 0\nv 1 0 0\nf 1 2"),
        ("nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("empty.city.json", ""),
        ("cut.city.json", "{\"type\": \"CityJSON\", \"version\":"),
        ("empty.osm.pbf", ""),
        ("cut.glb", "glTF"),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        let error = prepare_error(&small(path.to_str().unwrap()));
        assert_eq!(error.exit_code(), 2, "{name}: {error}");
        assert!(error.to_string().contains(name), "{name}: {error}");
    }
}

#[test]
fn cities_from_files_are_lit_by_all_techniques() {
    for file in ["city/delft.city.json", "city/Helsinki.osm.pbf"] {
        let Some(case) = real(file) else { continue };
        let prepared = prepare(&but(but(case.clone(), "width", 16), "frames", 1));
        assert!(prepared.world().lights.len() > 100, "{file}: {:?}", prepared.facts().notes);
        let found = check_all(&prepared);
        assert!(of(&found, "brute-force") < 1e-4, "{file}: {found:?}");
        assert!(of(&found, "absolute-cut") < 8.0 / 255.0, "{file}: {found:?}");
        let blocks = prepare_error(&but(case, "blocks", 3));
        assert!(blocks.to_string().contains("not a generated city"), "{blocks}");
    }
}
