//! Shadow filtering on four scenes at 160 x 90: the truth, and four filters that differ in kind.

use crate::shadow_truth;
use dapple_metrics::rmse;
use dapple_suite::{
    case::Case,
    knob::{self, Knobs},
    problem::{self, Form, Prepared, Setting},
    problems,
    problems::shadow_filtering::{SPEC, ShadowCase},
};
use dapple_tests::golden::{LSB, Picture, RASTER, Tolerance, assert_golden, assert_like_golden};

/// Techniques, and forms on a graphics adapter.
const TECHNIQUES: [(&str, bool); 4] =
    [("vsm", true), ("gaussian-cdf", false), ("power-cdf", false), ("msm", true)];

/// Scenes with the greatest error (rmse of visibility against rays) that each technique may have.
///
/// Two rules stand behind the figures. On the half plane every window holds two depths, where
/// Chebyshev's bound and four moments are exact: what is left is the map's raster (a kernel of 7
/// texels for a footprint of 7.68, half a texel's steps along the edge), 0.01. Elsewhere a
/// technique may keep its own leaks and its own slope, but half the error of no shadow at all is no
/// picture of a shadow any more.
const SCENES: [(&str, [f64; 4]); 4] = [
    ("spheres", [0.06, 0.06, 0.13, 0.03]),
    ("chairs", [0.12, 0.12, 0.17, 0.08]),
    ("car", [0.07, 0.08, 0.13, 0.05]),
    ("half_plane", [0.01, 0.04, 0.12, 0.01]),
];

/// Names and tolerances of this file's goldens.
pub fn goldens() -> Vec<(String, Tolerance)> {
    let of = |scene: &str| {
        let techniques = TECHNIQUES.iter().map(|t| t.0);
        std::iter::once("truth")
            .chain(techniques)
            .map(|t| format!("{scene}-{t}"))
            .collect::<Vec<_>>()
    };
    SCENES.iter().flat_map(|s| of(s.0)).map(|name| (name, LSB)).collect()
}

fn case_of(scene: &str) -> Case {
    let given = Knobs::from([("width".into(), 160.into())]);
    let parameters = knob::complete("parameter", SPEC.parameters, &given).unwrap();
    Case { problem: SPEC.id.into(), scene: scene.into(), view: String::new(), seed: 1, parameters }
}

fn setting(technique: &str, form: Form) -> Setting {
    let spec = problems::find(SPEC.id).unwrap().spec().technique(technique).unwrap();
    assert!(spec.forms.contains(&form), "{technique} has no {form} form");
    Setting {
        technique: technique.into(),
        variant: spec.variants[0].id.into(),
        form,
        knobs: knob::complete("knob", spec.knobs, &Knobs::new()).unwrap(),
    }
}

/// The technique's picture, after its gates and its error against the truth.
fn checked(case: &ShadowCase<'_>, setting: &Setting, bound: f64) -> problem::Picture {
    let mut subject = case.subject(setting).unwrap();
    let checked = subject.check().unwrap();
    assert_eq!(checked.violations, Vec::<String>::new(), "{setting}");
    let picture = subject.picture().unwrap().unwrap();
    let error = rmse(&picture.result, &picture.truth, Some(case.mask())).unwrap();
    let reported = checked.errors["rmse"];
    assert!((error - reported).abs() <= 1e-6, "{setting}: {error}, reported {reported}");
    println!("{setting}: rmse {error:.5} of at most {bound}");
    assert!(error <= bound, "{setting}: rmse {error} against the truth exceeds {bound}");
    picture
}

fn scene(index: usize) {
    let (name, bounds) = SCENES[index];
    let gpu = dapple_gpu::testing::test_gpu();
    let case = case_of(name);
    let seed = case.seed;
    let case = ShadowCase::prepare(&case, gpu).unwrap();
    assert_eq!(case.size(), [160, 90]);
    shadow_truth::check(&case, seed);
    if name == "half_plane" {
        shadow_truth::check_half_plane(&case);
    }
    let truth = Picture::from_values(160, 90, case.truth());
    assert_golden(&format!("{name}-truth"), &truth, LSB);

    let unshadowed = vec![1.0_f32; case.truth().len()];
    let no_shadow = rmse(&unshadowed, case.truth(), Some(case.mask())).unwrap();
    for ((technique, on_gpu), bound) in TECHNIQUES.iter().zip(bounds) {
        assert!(2.0 * bound <= no_shadow, "{technique}: {bound} against {no_shadow}");
        let golden = format!("{name}-{technique}");
        let result = checked(&case, &setting(technique, Form::Cpu), bound);
        assert_golden(&golden, &Picture::from_values(160, 90, &result.result), LSB);
        if *on_gpu && gpu.is_some() {
            let result = checked(&case, &setting(technique, Form::Gpu), bound);
            let picture = Picture::from_values(160, 90, &result.result);
            assert_like_golden(&golden, "gpu", &picture, RASTER);
        }
    }
}

#[test]
fn spheres() {
    scene(0);
}

#[test]
fn chairs() {
    scene(1);
}

#[test]
fn car() {
    scene(2);
}

#[test]
fn half_plane() {
    scene(3);
}

/// Control: the bound is one that a wrong result breaks, here the picture of another technique's
/// failure: no shadow at all, and the truth moved by two pixels.
#[test]
fn a_wrong_picture_breaks_the_bound_before_any_golden_is_asked() {
    let case = ShadowCase::prepare(&case_of("half_plane"), None).unwrap();
    let bound = SCENES[3].1[0];
    let truth = Picture::from_values(160, 90, case.truth());
    let moved: Vec<f32> =
        truth.shifted().shifted().codes.iter().map(|c| f32::from(*c) / 255.0).collect();
    for wrong in [vec![1.0; 160 * 90], vec![0.0; 160 * 90], moved] {
        let error = rmse(&wrong, case.truth(), Some(case.mask())).unwrap();
        assert!(error > bound, "{error}");
    }
}
