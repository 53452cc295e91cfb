//! The problem end to end on small cases.

use super::{RegionCase, RegionLightVisibility, SPEC};
use crate::{
    SuiteError, case,
    case::Case,
    knob::{self, Knobs},
    problem::{Checked, Form, Prepared, Problem, Setting},
    testing,
};
use serde_json::Value;
use std::{collections::BTreeSet, io::Write};

fn small(scene: &str) -> Case {
    let few = [
        ("width", 24.into()),
        ("frames", 2.into()),
        ("truth_faces", 5.into()),
        ("truth_lights", 80.into()),
        ("truth_points", 24.into()),
    ];
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

fn prepare(case: &Case) -> RegionCase {
    RegionCase::prepare(case).unwrap()
}

fn prepare_error(case: &Case) -> SuiteError {
    match RegionLightVisibility.prepare(case, None) {
        Ok(_) => panic!("{} was accepted", case.scene),
        Err(error) => error,
    }
}

fn check(prepared: &RegionCase, setting: &Setting) -> Checked {
    let checked = prepared.subject(setting).unwrap().check().unwrap();
    assert!(checked.violations.is_empty(), "{setting}: {:?}", checked.violations);
    for (name, error) in &checked.errors {
        assert!((0.0..=1.0).contains(error), "{setting}: {name} is {error}");
    }
    checked
}

/// Past the harness, which keeps what a passing test prints to itself.
fn say(what: &str) {
    let _ = writeln!(std::io::stderr(), "{what}");
}

#[test]
fn every_technique_passes_its_check_in_every_variant_and_form() {
    let prepared = prepare(&small("city_small"));
    let mut ran = 0;
    for technique in SPEC.techniques {
        for variant in technique.variants {
            for form in technique.forms.iter().filter(|form| technique.has(variant.id, **form)) {
                let s = setting(technique.id, variant.id, *form, &[]);
                let checked = check(&prepared, &s);
                let names: BTreeSet<&str> = checked.errors.keys().map(String::as_str).collect();
                assert_eq!(names, SPEC.metrics.iter().map(|m| m.name).collect(), "{s}");
                assert!(checked.counters["faces"] > 0, "{s}");
                assert!(checked.memory_bytes > 0 || technique.id == "all-lights", "{s}");
                if technique.id != "sampled" {
                    assert_eq!(checked.errors["false_hidden"], 0.0, "{s}");
                }
                let mut subject = prepared.subject(&s).unwrap();
                subject.reset().unwrap();
                assert_eq!(subject.frames(), 2);
                for frame in 0..2 {
                    assert!(subject.frame(frame).unwrap().wall_ns > 0, "{s}");
                }
                let picture = subject.picture().unwrap().unwrap();
                assert_eq!(picture.result.len(), (picture.width * picture.height) as usize, "{s}");
                assert!(picture.truth.contains(&1.0), "{s}: nothing is seen");
                ran += 1;
            }
        }
    }
    assert!(ran >= 9, "{ran}");
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
                let sound = checked.errors["false_hidden"] == 0.0;
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
    let kept = |technique: &str, variant: &str| {
        let s = setting(technique, variant, Form::Cpu, &[]);
        check(&prepared, &s).errors["kept_hidden"]
    };
    assert_eq!(kept("all-lights", ""), 1.0);
    let [ordered, inserted, single] =
        ["height-ordered", "insertion", "no-fusion"].map(|variant| kept("facade-cluster", variant));
    assert!(ordered <= inserted && ordered <= single, "{ordered} {inserted} {single}");
    assert!(ordered < 0.5, "{ordered}");
    assert!(kept("extended-projection", "") < 1.0);
}

#[test]
fn bad_names_and_parameters_say_what_to_do() {
    let known = prepare_error(&small("cty"));
    assert!(known.to_string().contains("no scene `cty`"), "{known}");
    let view = prepare_error(&Case { view: "moon".into(), ..small("city_small") });
    assert!(view.to_string().contains("no view `moon`; there is: street, turn, tour"), "{view}");
    let file = prepare_error(&small("no/such.city.json"));
    assert!(file.to_string().contains("no/such.city.json"), "{file}");
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
        ("width", Value::from(15), "16..=7680"),
        ("frames", 0.into(), "1..=10000"),
        ("tau", (-1).into(), "0..=2000000"),
        ("most_split", "window".into(), "building"),
        ("truth_faces", 0.into(), "1..="),
        ("truth_points", 7.into(), "8..="),
        ("threshold", 1.5.into(), "0..=1"),
        ("clamp", 0.0.into(), "..=1000"),
    ] {
        let given = Knobs::from([(name.to_string(), value)]);
        let error = knob::complete("parameter", SPEC.parameters, &given).unwrap_err();
        assert!(error.to_string().contains(name) && error.to_string().contains(limit), "{error}");
        assert_eq!(error.exit_code(), 2, "{error}");
    }
    // Whoever sets them: what is read is held to the range as well.
    let prepared = prepare(&but(small("city_small"), "frames", 1));
    for (technique, knob, value, limit) in [
        ("facade-cluster", "least_step", Value::from(-1.0), "0..=10000"),
        ("facade-cluster", "divisions", ((1_i64 << 32) - 1).into(), "-1..=64"),
        ("facade-cluster", "occluders", "guessed".into(), "bounding-boxes"),
        ("extended-projection", "texels", 8192.into(), "16..=4096"),
        ("sampled", "rays", 0.into(), "1..=16384"),
    ] {
        let mut s = setting(technique, "", Form::Cpu, &[]);
        s.knobs.insert(knob.into(), value);
        let error = prepared.subject(&s).map(|_| ()).unwrap_err();
        assert!(error.to_string().contains(knob) && error.to_string().contains(limit), "{error}");
        assert_eq!(error.exit_code(), 2, "{error}");
    }
}

#[test]
fn files_that_are_broken_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [
        ("empty.city.json", ""),
        ("cut.city.json", "{\"type\": \"CityJSON\", \"version\":"),
        ("other.city.json", "{\"type\": \"FeatureCollection\", \"features\": []}"),
        (
            "none.city.json",
            "{\"type\": \"CityJSON\", \"version\": \"1.1\", \"CityObjects\": {}, \"vertices\": []}",
        ),
        ("empty.osm.pbf", ""),
        ("cut.osm.pbf", "\u{0}\u{0}\u{0}\u{d}\n\tOSMHeader"),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        let error = prepare_error(&small(path.to_str().unwrap()));
        assert_eq!(error.exit_code(), 2, "{name}: {error}");
        assert!(error.to_string().contains(name), "{name}: {error}");
    }
}

#[test]
fn cities_from_files_lose_no_light() {
    for file in ["city/delft.city.json", "city/Helsinki.osm.pbf"] {
        if std::env::var_os(case::DATA_VARIABLE).is_none() {
            say(&format!("skipped: {file}: {} is not set", case::DATA_VARIABLE));
            continue;
        }
        let case = but(but(small(&format!("data:{file}")), "frames", 1), "tau", 200_000);
        let prepared = prepare(&case);
        let wide = [("least_step", Value::from(20.0))];
        for (technique, knobs) in
            [("all-lights", &[][..]), ("facade-cluster", &wide[..]), ("sampled", &[][..])]
        {
            let s = setting(technique, "", Form::Cpu, knobs);
            let fast = prepared.subject(&s).unwrap().frame(0).unwrap();
            assert!(fast.wall_ns > 0);
        }
        // The clear form of hundreds of planes takes minutes: the fast one is judged by itself.
        let s = setting("facade-cluster", "", Form::Cpu, &wide);
        let mut precuts = Vec::new();
        let asked: Vec<_> = prepared.frames()[0].iter().map(|q| q.asked()).collect();
        prepared.many(&s).unwrap().all(&asked, &mut precuts);
        let found = prepared.judge(0, &precuts);
        assert!(found.false_hidden() == 0.0 && found.tightness() > 0.0, "{file}: {found:?}");
        let blocks = prepare_error(&but(case, "blocks", 3));
        assert!(blocks.to_string().contains("not a generated city"), "{blocks}");
    }
}
