//! The problem end to end on small cases.

use super::{CameraVisibility, SPEC, VisibilityCase, truth::NOTHING};
use crate::{
    SuiteError, case,
    case::Case,
    knob::{self, Knobs},
    problem::{Form, Prepared, Problem, Setting},
    stress::edit,
};
use dapple_gpu::testing::test_gpu;
use serde_json::Value;
use std::{io::Write, path::PathBuf, rc::Rc};

/// A case with a few parameters given.
fn case(scene: &str, given: &[(&str, Value)]) -> Case {
    let given: Knobs = given.iter().map(|(n, v)| (n.to_string(), v.clone())).collect();
    Case {
        problem: SPEC.id.into(),
        scene: scene.into(),
        view: String::new(),
        seed: 0,
        parameters: knob::complete("parameter", SPEC.parameters, &given).unwrap(),
    }
}

fn small(scene: &str) -> Case {
    case(scene, &[("width", 64.into()), ("frames", 4.into()), ("truth_samples", 1.into())])
}

/// The same with one more parameter.
fn but(case: Case, name: &str, value: impl Into<Value>) -> Case {
    let mut case = case;
    case.parameters.insert(name.into(), value.into());
    case
}

fn seen_from(case: Case, view: &str) -> Case {
    Case { view: view.into(), ..case }
}

fn setting(technique: &str, variant: &str, form: Form, given: &[(&str, Value)]) -> Setting {
    let technique = SPEC.technique(technique).unwrap();
    let given: Knobs = given.iter().map(|(n, v)| (n.to_string(), v.clone())).collect();
    let variant = if variant.is_empty() { technique.variants[0].id } else { variant };
    Setting {
        technique: technique.id.into(),
        variant: variant.into(),
        form,
        knobs: knob::complete("knob", technique.knobs, &given).unwrap(),
    }
}

fn prepare(case: &Case) -> VisibilityCase<'static> {
    VisibilityCase::prepare(case, None).unwrap()
}

fn prepare_error(case: &Case) -> SuiteError {
    match CameraVisibility.prepare(case, None) {
        Ok(_) => panic!("{} was accepted", case.scene),
        Err(error) => error,
    }
}

/// Past the harness, which keeps what a passing test prints to itself.
fn say(what: &str) {
    let _ = writeln!(std::io::stderr(), "{what}");
}

/// A real model, as the command line names it; says so where there is none.
fn real(path: &str) -> Option<Case> {
    let there = std::env::var_os(case::DATA_VARIABLE).map(PathBuf::from);
    if there.is_none() {
        say(&format!("skipped: {path}: {} is not set", case::DATA_VARIABLE));
        return None;
    }
    Some(small(&format!("data:{path}")))
}

/// Checks the default variant of every technique on the processor and returns what each wasted.
fn check_all(prepared: &VisibilityCase<'_>) -> Vec<(&'static str, f64)> {
    let one = |technique: &'static crate::problem::Technique| {
        let s = setting(technique.id, "", Form::Cpu, &[]);
        let checked = prepared.subject(&s).unwrap().check().unwrap();
        assert!(checked.violations.is_empty(), "{s}: {:?}", checked.violations);
        assert_eq!(checked.errors["missed"], 0.0, "{s}");
        (technique.id, checked.errors["overdraw"])
    };
    SPEC.techniques.iter().map(one).collect()
}

fn of<'a>(found: &'a [(&'static str, f64)], technique: &str) -> &'a f64 {
    &found.iter().find(|(id, _)| *id == technique).unwrap().1
}

#[test]
fn every_technique_passes_its_check_in_every_variant_and_form() {
    let gpu = test_gpu();
    if gpu.is_none() {
        say("skipped: camera visibility on a device: there is none");
    }
    let case = but(small("city_small"), "frames", 3);
    let prepared = VisibilityCase::prepare(&case, gpu).unwrap();
    let (mut ran, mut expected) = (0, 0);
    for technique in SPEC.techniques {
        for variant in technique.variants {
            for form in technique.forms {
                if *form == Form::Gpu && gpu.is_none() || !technique.has(variant.id, *form) {
                    continue;
                }
                expected += 1;
                let s = setting(technique.id, variant.id, *form, &[]);
                let mut subject = prepared.subject(&s).unwrap();
                let checked = subject.check().unwrap();
                assert!(checked.violations.is_empty(), "{s}: {:?}", checked.violations);
                for (name, error) in &checked.errors {
                    assert!(error.is_finite(), "{s}: {name} is {error}");
                    assert!(SPEC.metrics.iter().any(|m| m.name == name), "{s}: {name}");
                }
                for name in ["overdraw", "overdraw_objects", "missed", "wrong_pixels"] {
                    assert!(checked.errors.contains_key(name), "{s} has no {name}");
                }
                assert_eq!(checked.counters["frames"], 3, "{s}");
                assert!(checked.counters["triangles"] > 0 && checked.memory_bytes > 0, "{s}");
                subject.reset().unwrap();
                assert_eq!(subject.frames(), 3);
                for frame in 0..3 {
                    assert!(subject.frame(frame).unwrap().wall_ns > 0, "{s}");
                }
                let picture = subject.picture().unwrap().unwrap();
                assert_eq!(picture.result.len(), (picture.width * picture.height) as usize, "{s}");
                ran += 1;
            }
        }
    }
    assert!(ran == expected && ran >= 20, "{ran} of {expected}");
}

#[test]
fn everything_is_drawn_once_and_again_only_for_more_frames() {
    let prepared = prepare(&small("city_small"));
    let port = || {
        let s = setting("frustum", "", Form::Cpu, &[]);
        prepared.subject(&s).unwrap().check().unwrap().port_errors
    };
    let start = prepared.everything_at_start(Form::Reference, 2).unwrap();
    let before = port();
    let all = prepared.everything(Form::Reference).unwrap();
    assert_eq!((start.len(), all.len()), (2, 4));
    assert_eq!(start[..], all[..2]);
    assert!(Rc::ptr_eq(&all, &prepared.everything_at_start(Form::Reference, 2).unwrap()));
    assert!(Rc::ptr_eq(&all, &prepared.everything_at_start(Form::Reference, 9).unwrap()));
    // Held against the same frames, however many there are.
    assert_eq!(port(), before);
}

#[test]
fn techniques_rank_as_they_must_on_the_city() {
    let found = check_all(&prepare(&small("city_small")));
    assert!(of(&found, "none") > of(&found, "frustum"), "{found:?}");
    for technique in ["stop-and-wait", "chc", "chcpp", "hierarchical-depth", "masked"] {
        assert!(*of(&found, technique) < 0.5 * of(&found, "frustum"), "{found:?}");
        assert!(of(&found, "oracle") <= of(&found, technique), "{found:?}");
    }
}

#[test]
fn bad_names_and_parameters_say_what_to_do() {
    let known = prepare_error(&small("cty"));
    assert!(known.to_string().contains("no scene `cty`"), "{known}");
    assert!(known.to_string().contains("city_small"), "{known}");
    let view = prepare_error(&seen_from(small("city_small"), "moon"));
    assert!(view.to_string().contains("no view `moon`; there is: street, turn, tour"), "{view}");
    let file = prepare_error(&small("no/such.obj"));
    assert!(file.to_string().contains("no/such.obj"), "{file}");
    let city = prepare_error(&small("no/such.city.json"));
    assert!(city.to_string().contains("no/such.city.json"), "{city}");
    let data = case::missing_data("city/delft.city.json");
    assert!(data.to_string().contains("set DAPPLE_DATA"), "{data}");
    for error in [known, view, file, city, data] {
        assert_eq!(error.exit_code(), 2, "{error}");
    }
}

#[test]
fn parameters_and_knobs_out_of_range_are_refused_with_their_limits() {
    let refused = |name: &str, value: Value| {
        let given = Knobs::from([(name.to_string(), value)]);
        knob::complete("parameter", SPEC.parameters, &given).unwrap_err()
    };
    for (name, value, limit) in [
        ("width", 15.into(), "16..=7680"),
        ("frames", 0.into(), "1..=10000"),
        ("truth_samples", 17.into(), "1..=16"),
        ("object_triangles", 0.into(), "1..=1048576"),
        ("blocks", 25.into(), "0..=24"),
        ("heights", "tall".into(), "varied"),
        ("empty", 0.6.into(), "0..=0.5"),
    ] {
        let error = refused(name, value);
        assert!(error.to_string().contains(name) && error.to_string().contains(limit), "{error}");
        assert_eq!(error.exit_code(), 2, "{error}");
    }
    // Whoever sets them: what is read is held to the range as well.
    let prepared = prepare(&small("city_small"));
    let with = |knob: &str, value: Value| {
        let mut s = setting("chcpp", "", Form::Cpu, &[]);
        s.knobs.insert(knob.into(), value);
        prepared.subject(&s).map(|_| ()).unwrap_err()
    };
    for (knob, value, limit) in [
        ("batch", Value::from((1_i64 << 32) + 50), "1..=200"),
        ("latency", (-1).into(), "0..=1000000"),
        ("tree", "oak".into(), "bottom-up"),
        ("readiness", "polled".into(), "no device"),
    ] {
        let error = with(knob, value);
        assert!(error.to_string().contains(knob) && error.to_string().contains(limit), "{error}");
        assert_eq!(error.exit_code(), 2, "{error}");
    }
}

#[test]
fn parameters_of_cities_are_refused_for_other_scenes_by_name() {
    for (name, value) in [
        ("blocks", Value::from(3)),
        ("heights", "seven".into()),
        ("layout", "grid".into()),
        ("empty", 0.2.into()),
        ("street", 20.0.into()),
    ] {
        let error = prepare_error(&but(small("cube"), name, value.clone()));
        assert!(error.to_string().contains("scene cube is not a generated city"), "{error}");
        assert!(error.to_string().contains(name), "{error}");
        assert_eq!(error.exit_code(), 2);
        // A city takes it, and is another city.
        let changed = prepare(&but(small("city_small"), name, value));
        assert_ne!(changed.facts().scene_hash, prepare(&small("city_small")).facts().scene_hash);
    }
    let prepared = prepare(&small("cube"));
    let tree = setting("chc", "", Form::Cpu, &[("tree", "city".into())]);
    let boxes = setting("masked", "boxes", Form::Cpu, &[]);
    for (s, part) in [(tree, "`tree` = city"), (boxes, "variant `boxes`")] {
        let error = prepared.subject(&s).map(|_| ()).unwrap_err();
        assert!(error.to_string().contains("scene cube"), "{error}");
        assert!(error.to_string().contains(part), "{error}");
        assert_eq!(error.exit_code(), 2);
    }
}

#[test]
fn a_view_is_a_path_or_a_still_that_is_repeated() {
    let first = prepare(&small("city_small"));
    assert_eq!(first.facts().view, "street");
    let mut froms = Vec::new();
    for (view, still) in [("street", false), ("turn", false), ("tour", false), ("facade", true)] {
        let prepared = prepare(&seen_from(small("city_small"), view));
        assert_eq!((prepared.facts().view.as_str(), prepared.views().len()), (view, 4));
        let [from, to] = [0, 3].map(|i| (prepared.views()[i].eye, prepared.views()[i].forward));
        assert_eq!(from == to, still, "{view}: {from:?} {to:?}");
        froms.push(from);
    }
    assert_eq!(froms[0], (first.views()[0].eye, first.views()[0].forward));
    // A path that is asked for more frames than it has ends with its last.
    let long = prepare(&but(small("cube"), "frames", 10_000));
    assert!(long.views().len() < 10_000, "{}", long.views().len());
}

#[test]
fn a_camera_that_sees_nothing_is_refused() {
    let city = dapple_scene::generate::by_name("cube", 0).unwrap();
    let scene = edit::seen_from_behind(city);
    let loaded = crate::city::Loaded { scene, city: None, hash: "away".into(), notes: vec![] };
    let error = VisibilityCase::of(loaded, &small("cube"), None).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("scene cube"), "{error}");
    assert!(error.to_string().contains("no frame shows anything"), "{error}");
    assert_eq!(error.exit_code(), 2);
}

/// Rows of boxes behind a wide one, as a user's file without light or camera.
fn boxes_as_obj() -> String {
    let mut text = String::from("# boxes\no boxes\n");
    let mut first = 1;
    for (i, j) in (0..8).flat_map(|i| (0..8).map(move |j| (i, j))) {
        let (x, z, wide) =
            (2.0 * f64::from(i), -2.0 * f64::from(j), if j == 0 { 2.0 } else { 1.0 });
        for corner in 0..8 {
            let pick = |bit: u32, size: f64| if corner >> bit & 1 == 0 { 0.0 } else { size };
            text += &format!("v {} {} {}\n", x + pick(0, wide), pick(1, 2.0), z + pick(2, 1.0));
        }
        for [a, b, c, d] in
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
        {
            text += &format!("f {} {} {} {}\n", first + a, first + b, first + c, first + d);
        }
        first += 8;
    }
    text
}

#[test]
fn a_users_mesh_is_cut_into_objects_and_seen_by_all_techniques() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("boxes.obj");
    std::fs::write(&path, boxes_as_obj()).unwrap();
    let case = but(small(path.to_str().unwrap()), "object_triangles", 12);
    let prepared = prepare(&case);
    let facts = prepared.facts();
    assert!(facts.notes.iter().any(|n| n.contains("no camera")), "{:?}", facts.notes);
    assert!(facts.notes.iter().any(|n| n.contains("of 768 triangles")), "{:?}", facts.notes);
    assert!(prepared.objects().objects.len() >= 64, "{:?}", facts.notes);
    check_all(&prepared);
    let one = prepare(&but(case, "object_triangles", 1_000_000));
    assert_eq!(one.objects().objects.len(), 1);
    let found = check_all(&one);
    assert_eq!(of(&found, "none"), of(&found, "chcpp"));
    if let Some(bunny) = real("classic/bunny.obj") {
        let prepared = prepare(&bunny);
        assert!(prepared.objects().objects.len() > 100, "{:?}", prepared.facts().notes);
        let found = check_all(&prepared);
        assert!(of(&found, "chc") < of(&found, "none"), "{found:?}");
    }
}

#[test]
fn cities_from_files_are_seen_by_all_techniques_on_their_paths() {
    for (file, objects) in [("city/delft.city.json", 1_000), ("city/Helsinki.osm.pbf", 1_000)] {
        let Some(case) = real(file) else { continue };
        let prepared = prepare(&case);
        let facts = prepared.facts();
        assert!(prepared.objects().objects.len() > objects, "{file}: {:?}", facts.notes);
        assert!(prepared.inner().is_some_and(|boxes| !boxes.is_empty()), "{file}");
        let found = check_all(&prepared);
        assert!(*of(&found, "chcpp") < 0.7 * of(&found, "frustum"), "{file}: {found:?}");
        let boxes = setting("masked", "boxes", Form::Cpu, &[]);
        let checked = prepared.subject(&boxes).unwrap().check().unwrap();
        assert!(checked.violations.is_empty(), "{file}: {:?}", checked.violations);
        let blocks = prepare_error(&but(case, "blocks", 3));
        assert!(blocks.to_string().contains("not a generated city"), "{blocks}");
    }
}

#[test]
fn pictures_show_the_truth_where_a_pixels_owner_is_sure() {
    let prepared = prepare(&but(small("city_small"), "width", 128));
    let s = setting("chcpp", "", Form::Cpu, &[]);
    let picture = prepared.subject(&s).unwrap().picture().unwrap().unwrap();
    assert_eq!((picture.width, picture.height), (128, 72));
    let pairs = picture.truth.iter().zip(&picture.result);
    assert!(pairs.clone().all(|(a, b)| (0.0..=1.0).contains(a) && (0.0..=1.0).contains(b)));
    let differ = pairs.filter(|(a, b)| (*a - *b).abs() > 1e-6).count();
    assert!(differ * 50 < picture.truth.len(), "{differ}");
    let mut greys: Vec<u32> = picture.result.iter().map(|g| g.to_bits()).collect();
    greys.sort_unstable();
    greys.dedup();
    assert!(greys.len() > 30, "{}", greys.len());
    let nothing = prepared.truth().last.iter().filter(|t| **t == NOTHING).count();
    let sky = picture.truth.iter().filter(|g| **g == super::picture::SKY).count();
    assert!(sky >= nothing && nothing < picture.truth.len(), "{sky} {nothing}");
}

#[test]
fn a_form_that_cannot_run_is_refused() {
    let prepared = prepare(&small("cube"));
    assert!(prepared.subject(&setting("chc", "", Form::Gpu, &[])).is_err());
}
