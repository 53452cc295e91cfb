//! The extremes themselves: what they must leave alone, what they must break, what must be refused.

use super::axes;
use crate::{
    SuiteError,
    case::Case,
    problem::{Form, Prepared, Setting},
    problems::shadow_filtering::{SPEC, ShadowCase, given::Given},
    scene,
    stress::{
        Axis, edit, settings,
        testing::{self as stress, Refusal},
    },
    testing,
};
use dapple_scene::Scene;

fn case(scene: &str) -> Case {
    testing::case(&SPEC, scene, &[("width", 64.into()), ("truth_rays", 2.into())])
}

fn setting(technique: &str) -> Setting {
    testing::setting(&SPEC, technique, "", Form::Cpu, &[])
}

fn axis(id: &str) -> Axis {
    stress::find(axes(), id)
}

/// The error of a technique at a value, or why it was refused.
fn rmse(axis: &Axis, case: &Case, technique: &str, value: f64) -> Result<f64, SuiteError> {
    Ok(stress::check(axis, case, &setting(technique), value)?.errors["rmse"])
}

#[test]
fn every_axis_runs_at_its_ends_and_refuses_what_it_must() {
    let all = axes();
    assert!(all.len() >= 10, "{}", all.len());
    let settings = ["vsm", "pcf", "msm", "esm", "lvsm"].map(setting);
    let most = |axis: &Axis| if axis.id == "map" { 1_000 } else { 10_000 };
    let past_the_format = |axis: &Axis, value| axis.id == "exponent" && value > 500.0;
    let [ran, refused] =
        stress::run_ends(&all, &case("cube"), &settings, "rmse", most, past_the_format);
    assert!(ran >= 40 && refused >= 18, "{ran} ran, {refused} were refused");
}

#[test]
fn a_refusal_names_the_element_and_the_limit() {
    let expected: &[Refusal] = &[
        ("bad-vertices", "nan", "vsm", ["cube: mesh 0", "vertex 2", "not finite"]),
        ("bad-vertices", "+inf", "vsm", ["cube: mesh 0", "vertex 2", "not finite"]),
        ("bad-vertices", "-inf", "vsm", ["cube: mesh 0", "vertex 2", "not finite"]),
        ("bad-vertices", "1e38", "vsm", ["instance 0, mesh 0", "vertex 2", "at most 1e9 m"]),
        ("bad-vertices", "index", "vsm", ["cube: mesh 0", "triangle 1", "there are 4 vertices"]),
        ("bad-vertices", "no-triangle", "vsm", ["cube: instances", "no triangle", "needs one"]),
        ("bad-settings", "map-0", "vsm", ["`resolution`", "= 0", "1..=16384"]),
        ("bad-settings", "map-minus-1", "vsm", ["`resolution`", "= -1", "1..=16384"]),
        ("bad-settings", "map-16385", "vsm", ["`resolution`", "= 16385", "1..=16384"]),
        ("bad-settings", "map-2^32+64", "vsm", ["`resolution`", "= 4294967360", "1..=16384"]),
        ("bad-settings", "bias-1e39", "vsm", ["bias", "inf", "finite"]),
        ("bad-settings", "min-variance-2", "vsm", ["min_variance", "2", "0..=1"]),
        ("bad-settings", "moment-bias-1", "msm", ["moment_bias", "1", "0..1"]),
        ("bad-settings", "exponent-1e4", "esm", ["exponent", "10000", "700"]),
        ("bad-settings", "layers-0", "lvsm", ["0 layers", "1, 2, 4 and 8", "supported"]),
        ("bad-settings", "taps-minus-1", "pcf", ["`taps`", "= -1", "0..=4095"]),
        ("layers", "3", "lvsm", ["3 layers", "1, 2, 4 and 8", "supported"]),
        ("content", "empty-view", "vsm", ["cube", "view", "no surface in view"]),
    ];
    stress::expect_refusals(&axes(), &case("cube"), setting, expected);
}

fn complete(scene: Scene) -> scene::Loaded {
    scene::complete(scene, Vec::new()).unwrap()
}

fn given(scene: Scene, given: Given, case: &Case) -> ShadowCase<'static> {
    ShadowCase::given(complete(scene), given, case, None).unwrap()
}

fn plain(scene: Scene, case: &Case) -> ShadowCase<'static> {
    given(scene, Given::default(), case)
}

/// Root mean square of the difference of two truths over the pixels that take part in both, and
/// the share of pixels that take part in one only.
fn difference(a: &ShadowCase<'_>, b: &ShadowCase<'_>) -> (f64, f64) {
    let both: Vec<bool> = a.mask().iter().zip(b.mask()).map(|(a, b)| *a && *b).collect();
    let one = a.mask().iter().zip(b.mask()).filter(|(a, b)| a != b).count();
    let rmse = dapple_metrics::rmse(a.truth(), b.truth(), Some(&both)).unwrap();
    (rmse, one as f64 / both.len() as f64)
}

#[test]
fn the_truth_of_a_scaled_or_moved_scene_is_that_of_the_scene() {
    for name in ["chairs", "spheres"] {
        let case = case(name);
        let scene = || scene::load(name, 0).unwrap().scene;
        let home = plain(scene(), &case);
        for (what, pushed) in [
            ("1e-6", edit::scaled(scene(), 1e-6)),
            ("1e6", edit::scaled(scene(), 1e6)),
            ("1 radius", edit::moved(scene(), 1.0)),
            ("1e7 radii", edit::moved(scene(), 1e7)),
        ] {
            let pushed = plain(pushed, &case);
            let (rmse, one) = difference(&home, &pushed);
            // One ray of four on the other side of an edge, at a pixel or two of 2304.
            assert!(rmse < 0.01 && one < 1e-3, "{name} {what}: {rmse} {one}");
        }
        // A truth traced in f32 coordinates would not survive the same move.
        let naive = edit::in_single_precision(edit::moved(scene(), 1e7));
        let naive = ShadowCase::of(complete(naive), &case, None);
        assert!(naive.is_err() || difference(&home, &naive.unwrap()).0 > 0.1, "{name}");
    }
}

#[test]
fn single_precision_breaks_far_from_the_origin_and_placements_do_not() {
    let case = case("chairs");
    for (id, broken) in [("offset", false), ("offset-f32", true)] {
        let axis = axis(id);
        let home = rmse(&axis, &case, "pcf", axis.home).unwrap();
        let far = rmse(&axis, &case, "pcf", 1e7).unwrap();
        let limit = axis.criterion.times * home + axis.criterion.plus;
        assert_eq!(far > limit, broken, "{id}: {home} at home, {far} far away");
    }
}

#[test]
fn triangles_without_area_change_nothing() {
    for name in ["chairs", "spheres"] {
        let case = case(name);
        let scene = || scene::load(name, 0).unwrap().scene;
        let with = edit::with_degenerate_triangles(scene(), 3_000, 0);
        let added = with.triangle_count() - scene().triangle_count();
        assert!(added >= 3_000, "{name}: {added}");
        // A line of a billionth of a metre is left a sliver by its placement's rounding.
        let degenerate = with.degenerate_triangles() - scene().degenerate_triangles();
        assert!(1000 * degenerate >= 999 * added, "{name}: {degenerate} of {added}");
        let (home, with) = (plain(scene(), &case), plain(with, &case));
        assert_eq!(home.receivers(), with.receivers(), "{name}");
        assert_eq!(home.truth(), with.truth(), "{name}");
        assert_eq!(home.depth_map(128), with.depth_map(128), "{name}");
        let picture = |prepared: &ShadowCase<'_>| {
            let setting = settings::with(&setting("vsm"), "resolution", 128).unwrap();
            prepared.subject(&setting).unwrap().check().unwrap();
            prepared.subject(&setting).unwrap().picture().unwrap().unwrap().result
        };
        assert_eq!(picture(&home), picture(&with), "{name}");
        // Triangles with an area do.
        let strewn = plain(edit::with_confetti(scene(), 100, 0), &case);
        assert_ne!(home.depth_map(128), strewn.depth_map(128), "{name}");
    }
}

#[test]
fn a_longer_depth_range_moves_depths_and_nothing_else() {
    let case = case("chairs");
    let scene = || scene::load("chairs", 0).unwrap().scene;
    let home = plain(scene(), &case);
    let long = given(scene(), Given { depth_range: 1000.0, ..Given::default() }, &case);
    assert_eq!((home.mask(), home.truth()), (long.mask(), long.truth()));
    let mut compared = 0;
    for (a, b) in home.receivers().iter().zip(long.receivers()).filter(|(a, _)| a.in_map()) {
        assert_eq!((a.u, a.v), (b.u, b.v));
        let expected = 1.0 - (1.0 - f64::from(a.z)) / 1000.0;
        assert!((f64::from(b.z) - expected).abs() < 1e-7, "{} {}", b.z, expected);
        compared += 1;
    }
    assert!(compared > 500, "{compared}");
    // A shorter one clips what is near the light.
    let short = given(scene(), Given { depth_range: 0.1, ..Given::default() }, &case);
    let covered = |c: &ShadowCase<'_>| c.depth_map(64).depths.iter().filter(|z| **z < 1.0).count();
    assert!(covered(&short) < covered(&home));
    assert_eq!(home.truth(), short.truth());
}

#[test]
fn one_depth_is_one_depth_and_all_of_it_is_lit() {
    for name in ["cube", "spheres"] {
        let prepared = plain(edit::one_depth(scene::load(name, 0).unwrap().scene), &case(name));
        let map = prepared.depth_map(64);
        let covered: Vec<f32> = map.depths.iter().copied().filter(|z| *z < 1.0).collect();
        let (least, greatest) =
            covered.iter().fold((1.0_f32, 0.0_f32), |(l, g), z| (l.min(*z), g.max(*z)));
        assert!(covered.len() > 1000 && greatest - least < 1e-6, "{name}: {least}..{greatest}");
        let counted = prepared.mask().iter().filter(|m| **m).count();
        assert!(counted > 300, "{name}: {counted}");
        let lit = prepared.mask().iter().zip(prepared.truth()).filter(|(m, _)| **m);
        assert!(lit.clone().all(|(_, v)| *v == 1.0), "{name}");
    }
}

#[test]
fn light_falls_at_the_angle_asked_for() {
    use dapple_scene::Light;
    for name in ["half_plane", "cube"] {
        for degrees in [0.0_f64, 30.0, 89.9] {
            let scene = edit::lit_at(scene::load(name, 0).unwrap().scene, degrees);
            let Light::Directional { direction } = scene.lights[0] else { panic!("{name}") };
            let cosine = -direction.normalize().y;
            assert!((cosine - degrees.to_radians().cos()).abs() < 1e-12, "{name} {degrees}");
        }
    }
}

#[test]
fn an_axis_that_means_nothing_to_a_technique_is_left_out() {
    let meant = |id: &str, technique: &str, value: f64| {
        (axis(id).setting)(&setting(technique), value).is_some()
    };
    assert!(meant("precision", "vsm", 2.0) && !meant("precision", "esm", 2.0));
    assert!(meant("precision", "esm", 1.0));
    assert!(meant("layers", "lvsm", 0.0) && !meant("layers", "vsm", 0.0));
    assert!(meant("exponent", "evsm", 1.0) && !meant("exponent", "pcf", 1.0));
}
