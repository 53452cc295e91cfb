//! The problem end to end on small cases.

use super::{SPEC, TranslucentCase, TranslucentShadow, scene, scene::Wishes};
use crate::{
    SuiteError, case,
    case::Case,
    knob::{self, Knobs},
    problem::{Form, Picture, Prepared, Problem, Setting},
    testing,
};
use dapple_gpu::testing::test_gpu;
use dapple_opacity_maps::Receiver;
use serde_json::Value;
use std::{io::Write, path::PathBuf};

fn case(scene: &str, given: &[(&str, Value)]) -> Case {
    testing::case(&SPEC, scene, given)
}

fn small(scene: &str) -> Case {
    case(scene, &[("width", 64.into()), ("truth_rays", 2.into())])
}

/// The same with one more parameter.
fn but(case: Case, name: &str, value: impl Into<Value>) -> Case {
    let mut case = case;
    case.parameters.insert(name.into(), value.into());
    case
}

fn setting(technique: &str, variant: &str, form: Form, given: &[(&str, Value)]) -> Setting {
    testing::setting(&SPEC, technique, variant, form, given)
}

fn prepare(case: &Case) -> TranslucentCase<'static> {
    TranslucentCase::prepare(case, None).unwrap()
}

fn prepare_error(case: &Case) -> SuiteError {
    match TranslucentShadow.prepare(case, None) {
        Ok(_) => panic!("{} was accepted", case.scene),
        Err(error) => error,
    }
}

/// The error of a technique at 128 texels, and its picture.
fn judged(
    prepared: &TranslucentCase<'_>,
    technique: &str,
    given: &[(&str, Value)],
) -> (f64, Picture) {
    let mut all = vec![("resolution", 128.into())];
    all.extend_from_slice(given);
    let mut subject = prepared.subject(&setting(technique, "", Form::Cpu, &all)).unwrap();
    let checked = subject.check().unwrap();
    assert!(checked.violations.is_empty(), "{technique}: {:?}", checked.violations);
    (checked.errors["rmse"], subject.picture().unwrap().unwrap())
}

/// Root mean square of the difference of two images.
fn differ(a: &[f32], b: &[f32]) -> f64 {
    dapple_metrics::rmse(a, b, None).unwrap()
}

#[test]
fn every_technique_passes_its_check_in_every_variant_and_form() {
    let gpu = test_gpu();
    if gpu.is_none() {
        say("skipped: translucent shadows on a device: there is none");
    }
    let prepared = TranslucentCase::prepare(&small("grass_sparse"), gpu).unwrap();
    let mut ran = 0;
    for technique in SPEC.techniques {
        for variant in technique.variants {
            for form in technique.forms {
                if *form == Form::Gpu && gpu.is_none() {
                    continue;
                }
                let s = setting(technique.id, variant.id, *form, &[("resolution", 64.into())]);
                let mut subject = match prepared.subject(&s) {
                    Ok(subject) => subject,
                    Err(error) => {
                        assert!(!technique.has(variant.id, *form), "{s}: {error}");
                        assert!(error.to_string().contains("no graphics form"), "{s}: {error}");
                        continue;
                    }
                };
                assert!(technique.has(variant.id, *form), "{s}");
                subject.reset().unwrap();
                let checked = subject.check().unwrap();
                assert!(checked.violations.is_empty(), "{s}: {:?}", checked.violations);
                for (name, error) in &checked.errors {
                    assert!(error.is_finite(), "{s}: {name} is {error}");
                    assert!(SPEC.metrics.iter().any(|m| m.name == name), "{s}: {name}");
                }
                for name in ["rmse", "p95", "max", "leak", "dark", "flip", "ssim_loss"] {
                    assert!(checked.errors.contains_key(name), "{s} has no {name}");
                }
                let mut wall_ns = 0;
                for frame in 0..subject.frames() {
                    wall_ns += subject.frame(frame).unwrap().wall_ns;
                }
                if *form != Form::Reference {
                    assert!(checked.memory_bytes > 0 && wall_ns > 0, "{s}");
                    assert!(!checked.counters.is_empty(), "{s}");
                }
                let picture = subject.picture().unwrap().unwrap();
                assert_eq!(picture.result.len(), (picture.width * picture.height) as usize, "{s}");
                ran += 1;
            }
        }
    }
    let least: usize = SPEC.techniques.iter().map(|t| 2 * t.variants.len()).sum();
    assert!(ran > least * 2 / 3, "{ran}");
}

#[test]
fn bad_names_and_parameters_say_what_to_do() {
    let known = prepare_error(&small("gras"));
    assert!(known.to_string().contains("no scene `gras`"), "{known}");
    assert!(known.to_string().contains("grass_dense"), "{known}");
    let view = prepare_error(&Case { view: "moon".into(), ..small("grass_sparse") });
    assert!(view.to_string().contains("no view `moon`; there is: front, low"), "{view}");
    let file = prepare_error(&small("no/such.hair"));
    assert!(file.to_string().contains("no/such.hair"), "{file}");
    let opaque = prepare_error(&small("cube"));
    assert!(opaque.to_string().contains("scene cube: no material is translucent"), "{opaque}");
    let light = prepare_error(&but(small("grass_sparse"), "light", "below"));
    assert!(
        light.to_string().contains("`below`; there is: scene, above, slanted, side"),
        "{light}"
    );
    for error in [known, view, file, opaque, light] {
        assert_eq!(error.exit_code(), 2, "{error}");
    }
    let refused = |name: &str, value: Value| {
        let given = Knobs::from([(name.to_string(), value)]);
        knob::complete("parameter", SPEC.parameters, &given).unwrap_err().to_string()
    };
    for (name, value, limit) in [
        ("width", Value::from(8), "16..=7680"),
        ("truth_rays", 33.into(), "1..=32"),
        ("footprint", 0.6.into(), "0..=0.5"),
        ("opacity", 1.5.into(), "0..=1"),
        ("law", "linear".into(), "product, exponential"),
        ("hair", "wigs".into(), "lines, ribbons"),
        ("lihgt", "above".into(), "lihgt"),
    ] {
        let error = refused(name, value);
        assert!(error.contains(limit) && error.contains(name), "{name}: {error}");
    }
}

#[test]
fn light_words_turn_the_light_and_nothing_else() {
    let forward =
        |light: &str| prepare(&but(small("grass_sparse"), "light", light)).view(true).forward;
    let above = forward("above");
    assert_eq!(above.to_array(), [0.0, -1.0, 0.0]);
    assert_eq!(forward("scene"), above, "grass is lit from straight above");
    assert!((forward("slanted").y + 0.5_f64.sqrt()).abs() < 1e-12);
    assert!((forward("side").y + 10.0_f64.to_radians().sin()).abs() < 1e-12);
    let [above, side] = ["above", "side"].map(|l| prepare(&but(small("grass_sparse"), "light", l)));
    assert_eq!(above.camera().position, side.camera().position);
    assert!(side.facts().notes.iter().any(|n| n.contains("replaced by one from side")));
    let mean = |c: &TranslucentCase<'_>| {
        c.truth().iter().map(|t| f64::from(*t)).sum::<f64>() / c.truth().len() as f64
    };
    // More blades lie on a long, level way.
    assert!(mean(&side) < mean(&above) - 0.1, "{} {}", mean(&side), mean(&above));
}

#[test]
fn opacity_law_and_window_reach_the_truth() {
    let base = || small("grass_sparse");
    let truth = |case: &Case| prepare(case).truth().to_vec();
    let plain = truth(&base());
    let faint = truth(&but(base(), "opacity", 0.1));
    let exponential = truth(&but(base(), "law", "exponential"));
    let point = truth(&but(base(), "footprint", 0.0));
    assert_eq!(plain.len(), faint.len());
    let less = |a: &[f32], b: &[f32]| a.iter().zip(b).all(|(a, b)| *a <= *b + 1e-6);
    // exp(-alpha) lets more through than 1 - alpha; a tenth of it more still.
    assert!(less(&plain, &exponential) && less(&exponential, &faint));
    assert!(differ(&plain, &exponential) > 0.02 && differ(&plain, &faint) > 0.1);
    assert!(differ(&plain, &point) > 0.005);
    // One ray passes a whole number of blades.
    let blades =
        |t: &f32| f64::from(*t).ln() / (1.0 - f64::from(dapple_scene::generate::LEAF_OPACITY)).ln();
    for t in point.iter().filter(|t| **t > 0.0) {
        assert!((blades(t) - blades(t).round()).abs() < 1e-3, "{t}: {} blades", blades(t));
    }
}

#[test]
fn a_shadow_is_seen_and_layers_bring_it_closer_to_the_truth() {
    let prepared = prepare(&case("tree", &[("width", 96.into())]));
    let (none, lit) = judged(&prepared, "unshadowed", &[]);
    let (binary, _) = judged(&prepared, "shadow-map", &[]);
    let (bounded, shadowed) = judged(&prepared, "bom", &[]);
    assert!(bounded < 0.2 * none && bounded < 0.7 * binary, "{bounded} {none} {binary}");
    let (away, near) = (differ(&lit.result, &lit.truth), differ(&shadowed.result, &shadowed.truth));
    assert!(near < 0.5 * away, "{near} {away}");
    assert!(differ(&lit.result, &shadowed.result) > 0.05);
    assert_eq!(lit.truth, shadowed.truth);
    // The trunk is opaque, and some of it in the leaves' shadow; the sky is no receiver.
    let receivers = prepared.receivers(true);
    let opaque = receivers.iter().filter(|r| r.flags & Receiver::OPAQUE != 0).count();
    assert!(opaque > 500 && opaque < receivers.len() - 500, "{opaque} of {}", receivers.len());
}

/// A HAIR file: strands of equal numbers of points, one thickness (a diameter) for all.
fn hair_file(strands: &[Vec<[f32; 3]>], thickness: f32) -> Vec<u8> {
    let points: usize = strands.iter().map(Vec::len).sum();
    let mut bytes = b"HAIR".to_vec();
    // Only points follow the header of 128 bytes.
    for word in [strands.len() as u32, points as u32, 2, strands[0].len() as u32 - 1] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend(thickness.to_le_bytes());
    bytes.resize(128, 0);
    bytes.extend(strands.iter().flatten().flatten().flat_map(|x| x.to_le_bytes()));
    bytes
}

/// Strands that stand on a square in rows, leaning with the wind.
fn meadow() -> Vec<Vec<[f32; 3]>> {
    let strand = |i: u16| {
        let (x, z) = (f32::from(i % 24) / 24.0, f32::from(i / 24) / 24.0);
        (0..5_u16).map(|k| f32::from(k) / 4.0).map(|t| [x + 0.3 * t * t, t, z]).collect()
    };
    (0..576).map(strand).collect()
}

#[test]
fn a_hair_file_casts_as_lines_or_as_the_ribbons_that_are_seen() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("meadow.hair");
    std::fs::write(&path, hair_file(&meadow(), 0.02)).unwrap();
    let case = but(small(path.to_str().unwrap()), "light", "slanted");
    let [lines, ribbons] =
        ["lines", "ribbons"].map(|hair| prepare(&but(case.clone(), "hair", hair)));
    let notes = |c: &TranslucentCase<'_>| c.facts().notes.join("\n");
    assert!(notes(&lines).contains("ribbons of the same width that face the light cast shadows"));
    assert!(notes(&ribbons).contains("the same ribbons cast shadows"));
    assert!(notes(&lines).contains("no ground: a square below"), "{}", notes(&lines));
    // What is seen does not change; what casts does.
    assert_eq!(lines.receivers(true).len(), ribbons.receivers(true).len());
    assert_ne!(lines.casters().hash(), ribbons.casters().hash());
    assert!(differ(lines.truth(), ribbons.truth()) > 0.01);
    for prepared in [&lines, &ribbons] {
        let (none, _) = judged(prepared, "unshadowed", &[]);
        let (bounded, _) = judged(prepared, "bom", &[("resolution", 512.into())]);
        assert!(bounded < none, "{bounded} {none}");
    }
    // A strand's own line does not shadow it: outermost ones are lit.
    let lit = lines.truth().iter().filter(|t| **t > 0.99).count();
    assert!(lit > 50, "{lit} of {}", lines.truth().len());
    // Cut short, the file is refused by name.
    std::fs::write(&path, &hair_file(&meadow(), 0.02)[..1000]).unwrap();
    let error = prepare_error(&small(path.to_str().unwrap()));
    assert!(error.to_string().contains("meadow.hair"), "{error}");
    assert_eq!(error.exit_code(), 2);
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
    let name = format!("data:{path}");
    Some(case(&name, &[("width", 128.into()), ("truth_rays", 2.into())]))
}

/// Bounding opacity maps see most of the shadow of a real model, and its notes say what was made
/// of it.
fn holds_for(case: &Case, notes: &[&str], least_translucent: usize) -> TranslucentCase<'static> {
    let prepared = prepare(case);
    let said = prepared.facts().notes.join("\n");
    for note in notes {
        assert!(said.contains(note), "{note}: {said}");
    }
    let receivers = prepared.receivers(true);
    let translucent = receivers.iter().filter(|r| r.flags & Receiver::OPAQUE == 0).count();
    assert!(translucent >= least_translucent, "{translucent}");
    let (none, _) = judged(&prepared, "unshadowed", &[]);
    let (bounded, _) = judged(&prepared, "bom", &[("resolution", 512.into())]);
    assert!(bounded < 0.5 * none, "{}: {bounded} {none}", case.scene);
    prepared
}

#[test]
fn the_authors_tree_holds_if_it_is_there() {
    let Some(case) = real("trees/crystalspace_tree.obj") else { return };
    let case = Case { view: "eye:0,6,13,0,3,0".into(), ..but(case, "light", "above") };
    let prepared = holds_for(&case, &["replaced by one from above"], 300);
    assert_eq!(prepared.view(true).forward.to_array(), [0.0, -1.0, 0.0]);
}

#[test]
fn the_real_hair_holds_if_it_is_there() {
    let Some(case) = real("hair/Ratboy_mohawk.tfx") else { return };
    holds_for(&case, &["2228 strands", "face the light cast shadows"], 200);
}

#[test]
fn the_real_pine_is_leaves_by_its_alpha_test_if_it_is_there() {
    let Some(case) = real("trees/smallpine/scene.gltf") else { return };
    let prepared = holds_for(&case, &["alpha-tested materials are taken as leaves"], 200);
    let cut = prepared.casters().materials.iter().filter(|m| m.alpha_test.is_some()).count();
    assert!(cut > 0);
}

#[test]
fn wholly_opaque_leaves_are_another_problem_and_nearly_so_are_black() {
    let case = small("grass_sparse");
    let wishes = Wishes { opacity: 1.0, ..Wishes::of(&case.parameters).unwrap() };
    let loaded = scene::load(&case.scene, "", 0, &wishes).unwrap();
    let error = TranslucentCase::of(loaded, &case, None).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("no material is translucent"), "{error}");
    // Nearly so: a ray that meets a blade is all but dark.
    let dark = prepare(&but(but(case, "opacity", 0.999), "footprint", 0.0));
    let between = dark.truth().iter().filter(|t| (2e-3..0.998).contains(*t)).count();
    assert_eq!(between, 0);
    assert!(dark.truth().iter().any(|t| *t < 2e-3));
}

#[test]
fn a_form_that_cannot_run_is_refused() {
    let prepared = prepare(&small("grass_sparse"));
    let s = setting("bom", "", Form::Gpu, &[]);
    let error = prepared.subject(&s).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("needs a graphics adapter"), "{error}");
}
