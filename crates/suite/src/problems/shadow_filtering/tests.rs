//! The problem end to end on small cases.

use super::{SPEC, ShadowCase, ShadowFiltering};
use crate::{
    SuiteError,
    case::Case,
    problem::{Form, Prepared, Problem, Setting},
    scene, testing,
};
use dapple_gpu::testing::test_gpu;
use dapple_scene::{AlphaTest, Light, Scene, Texture, generate};

fn case(scene: &str, given: &[(&str, serde_json::Value)]) -> Case {
    testing::case(&SPEC, scene, given)
}

fn small(scene: &str) -> Case {
    case(scene, &[("width", 96.into()), ("truth_rays", 4.into()), ("footprint", 0.03.into())])
}

fn setting(
    technique: &str,
    variant: &str,
    form: Form,
    given: &[(&str, serde_json::Value)],
) -> Setting {
    testing::setting(&SPEC, technique, variant, form, given)
}

fn prepare_error(case: &Case) -> SuiteError {
    match ShadowFiltering.prepare(case, None) {
        Ok(_) => panic!("{} was accepted", case.scene),
        Err(error) => error,
    }
}

#[test]
fn a_missing_file_unset_data_and_unknown_names_say_what_to_do() {
    let known = prepare_error(&small("sphere"));
    assert!(
        known.to_string().contains("no scene `sphere`; there is: spheres, chairs, car"),
        "{known}"
    );
    let view = prepare_error(&Case { view: "moon".into(), ..small("half_plane") });
    assert!(view.to_string().contains("no view `moon`; there is: edge"), "{view}");
    let file = prepare_error(&small("no/such.obj"));
    assert!(file.to_string().contains("no/such.obj"), "{file}");
    let data = crate::case::missing_data("tree.obj");
    assert!(data.to_string().contains("set DAPPLE_DATA"), "{data}");
    for error in [known, view, file, data] {
        assert_eq!(error.exit_code(), 2, "{error}");
    }
}

#[test]
fn unset_test_data_are_a_usage_error_naming_the_variable() {
    if std::env::var_os(crate::case::DATA_VARIABLE).is_some() {
        // The message for that case is held by the test above.
        return;
    }
    let error = prepare_error(&small("data:bunny.obj"));
    assert!(
        error.to_string().contains("data:bunny.obj") && error.to_string().contains("DAPPLE_DATA")
    );
}

fn of(scene: Scene, case: &Case) -> ShadowCase<'static> {
    ShadowCase::of(scene::complete(scene, Vec::new()).unwrap(), case, None).unwrap()
}

#[test]
fn a_scene_without_light_or_camera_gets_the_defaults_and_says_so() {
    let mut bare = generate::by_name("cube", 0).unwrap();
    bare.lights.clear();
    bare.cameras.clear();
    let facts = of(bare, &small("cube")).facts();
    for expected in ["no light", "no camera", "receivers"] {
        assert!(facts.notes.iter().any(|n| n.contains(expected)), "{expected}: {:?}", facts.notes);
    }
    assert_eq!(facts.view, "three-quarter");
}

#[test]
fn area_lights_alone_are_refused() {
    let mut scene = generate::by_name("cube", 0).unwrap();
    let up = glam::DVec3::Y * 5.0;
    scene.lights = vec![Light::Area { centre: up, half_u: glam::DVec3::X, half_v: glam::DVec3::Z }];
    let loaded = scene::complete(scene, Vec::new()).unwrap();
    let error = ShadowCase::of(loaded, &small("cube"), None).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("none of its 1 lights"), "{error}");
    assert_eq!(error.exit_code(), 2);
}

#[test]
fn truth_of_the_half_plane_is_a_ramp_as_wide_as_the_footprint() {
    let case = case(
        "half_plane",
        &[("width", 96.into()), ("truth_rays", 16.into()), ("footprint", 0.05.into())],
    );
    let prepared = ShadowCase::prepare(&case, None).unwrap();
    // The edge is the line x = 0 of the floor, which the light meets head on: a point at x sees
    // the share of its window that lies beyond it, unless it is on the occluder itself.
    let edge = prepared.view().project(glam::DVec3::ZERO);
    let (mut ramp, mut flat) = (0, 0);
    for (i, r) in prepared.receivers().iter().enumerate().filter(|(_, r)| r.in_map()) {
        let on_floor = (f64::from(r.z) - edge.z).abs() < 1e-3;
        // u grows to one side of the edge; which one follows from the light's axes.
        let side = prepared.view().right.x.signum();
        let x = (f64::from(r.u) - edge.x) * side;
        let far_from_ends = (f64::from(r.v) - 0.5).abs() < 0.3 && x > -0.3;
        if !on_floor || !far_from_ends {
            continue;
        }
        let x = x / prepared.footprint();
        let expected = (x + 0.5).clamp(0.0, 1.0);
        let found = f64::from(prepared.truth()[i]);
        // 16 strata across the edge, of which one is cut: 1/16 at most, mean of 16 rows.
        assert!((found - expected).abs() < 0.04, "x {x}: {found} {expected}");
        if x.abs() < 0.5 { ramp += 1 } else { flat += 1 }
    }
    assert!(ramp > 20 && flat > 500, "{ramp} {flat}");
}

fn rmse(prepared: &ShadowCase<'_>, setting: &Setting) -> f64 {
    let checked = prepared.subject(setting).unwrap().check().unwrap();
    assert!(checked.violations.is_empty(), "{setting}: {:?}", checked.violations);
    checked.errors["rmse"]
}

/// On flat surfaces: on curved ones the receiver's plane is not where the surface is, which no
/// resolution mends.
#[test]
fn percentage_closer_filtering_converges_to_truth_with_resolution() {
    let case = case(
        "chairs",
        &[("width", 96.into()), ("truth_rays", 16.into()), ("footprint", 0.03.into())],
    );
    let prepared = ShadowCase::prepare(&case, None).unwrap();
    let error = |resolution: u32| {
        let given = [("resolution", resolution.into()), ("bias", 2e-4.into())];
        rmse(&prepared, &setting("pcf", "", Form::Cpu, &given))
    };
    let errors = [64, 256, 2048].map(error);
    assert!(errors[1] < 0.5 * errors[0] && errors[2] < 0.5 * errors[1], "{errors:?}");
    assert!(errors[2] < 0.015, "{errors:?}");
}

#[test]
fn the_hard_map_equals_ray_traced_visibility_away_from_edges() {
    // Row 35: a footprint far below a texel makes the truth a single point of the plane.
    let case =
        case("car", &[("width", 160.into()), ("truth_rays", 1.into()), ("footprint", 1e-4.into())]);
    let prepared = ShadowCase::prepare(&case, None).unwrap();
    let given = [("resolution", 1024.into())];
    let mut hard = prepared.subject(&setting("hard", "", Form::Cpu, &given)).unwrap();
    hard.check().unwrap();
    let picture = hard.picture().unwrap().unwrap();
    let map = prepared.depth_map(1024);
    let (mut compared, mut differ) = (0, 0);
    for (i, r) in prepared.receivers().iter().enumerate().filter(|(_, r)| r.in_map()) {
        // Away from edges: the nine texels around agree about this receiver's plane.
        let (x, y) = ((r.u * 1024.0) as i32, (r.v * 1024.0) as i32);
        let occluded = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))).map(|(dx, dy)| {
            let (i, j) = ((x + dx).clamp(0, 1023), (y + dy).clamp(0, 1023));
            let plane = r.z
                + r.dz_du * ((i as f32 + 0.5) / 1024.0 - r.u)
                + r.dz_dv * ((j as f32 + 0.5) / 1024.0 - r.v);
            map.depths[(j * 1024 + i) as usize] < plane - 1e-3
        });
        let share = occluded.filter(|o| *o).count();
        if share == 0 || share == 9 {
            compared += 1;
            differ += u32::from(picture.result[i] != prepared.truth()[i]);
        }
    }
    assert!(compared > 5000, "{compared}");
    // Occluders thinner than a texel, or closer than the bias, escape the map.
    assert!(f64::from(differ) < 0.003 * f64::from(compared), "{differ} of {compared}");
}

#[test]
fn leaving_the_alpha_test_out_where_it_is_not_needed_changes_nothing() {
    let mut opaque = generate::by_name("cube", 0).unwrap();
    let texels = vec![[255; 4]; 4];
    opaque.textures.push(Texture { name: "leaf".into(), width: 2, height: 2, texels });
    for material in &mut opaque.materials {
        material.alpha_test = Some(AlphaTest { texture: 0, cutoff: 0.5 });
    }
    let case = small("cube");
    let with = scene::Loaded { scene: opaque.clone(), hash: "with".into(), notes: Vec::new() };
    let with = ShadowCase::of(with, &case, None).unwrap();
    let without = of(opaque, &case);
    assert!(with.scene().materials.iter().all(|m| m.alpha_test.is_some()));
    assert!(without.scene().materials.iter().all(|m| m.alpha_test.is_none()));
    assert!(without.facts().notes.iter().any(|n| n.contains("alpha test left out")));
    assert_eq!(with.receivers(), without.receivers());
    assert_eq!(with.truth(), without.truth());
    assert_eq!(with.depth_map(128), without.depth_map(128));
}

#[test]
fn holes_that_are_needed_stay_and_let_light_through() {
    let mut holed = generate::by_name("cube", 0).unwrap();
    holed.textures.push(Texture { name: "air".into(), width: 1, height: 1, texels: vec![[0; 4]] });
    let cube = holed.meshes[1].material as usize;
    holed.materials[cube].alpha_test = Some(AlphaTest { texture: 0, cutoff: 0.5 });
    let prepared = of(holed, &small("cube"));
    let mask = prepared.mask().iter().zip(prepared.truth());
    assert!(mask.filter(|(m, _)| **m).all(|(_, v)| *v == 1.0), "the cube casts no shadow");
}

#[test]
fn every_technique_passes_its_check_in_every_form() {
    let gpu = test_gpu();
    let prepared = ShadowCase::prepare(&small("chairs"), gpu).unwrap();
    for technique in SPEC.techniques {
        for form in technique.forms {
            if *form == Form::Gpu && gpu.is_none() {
                continue;
            }
            let s = setting(technique.id, "", *form, &[("resolution", 128.into())]);
            let mut subject = prepared.subject(&s).unwrap();
            let checked = subject.check().unwrap();
            assert!(checked.violations.is_empty(), "{s}: {:?}", checked.violations);
            for metric in SPEC.metrics.iter().filter(|m| m.name != "leak") {
                assert!(checked.errors[metric.name].is_finite(), "{s}: {}", metric.name);
            }
            let time = subject.frame(0).unwrap();
            if *form != Form::Reference {
                assert!(checked.counters["bytes_read"] > 0);
                assert!(checked.memory_bytes > 128 * 128 * 4);
                assert!(time.wall_ns > 0 && !time.passes.is_empty(), "{s}");
            }
            let picture = subject.picture().unwrap().unwrap();
            assert_eq!(picture.result.len(), (picture.width * picture.height) as usize);
        }
    }
}

#[test]
fn a_form_that_cannot_run_is_refused() {
    let prepared = ShadowCase::prepare(&small("cube"), None).unwrap();
    let s = setting("vsm", "", Form::Gpu, &[]);
    assert!(prepared.subject(&s).is_err());
}
