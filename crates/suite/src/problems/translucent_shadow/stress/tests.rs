//! The extremes themselves: what they must leave alone, what they must break, what must be refused.

use super::{Loaded, axes, checked, column, world};
use crate::{
    SuiteError,
    case::Case,
    knob::Knobs,
    problem::{Form, Setting},
    problems::translucent_shadow::{SPEC, TranslucentCase, scene, scene::Wishes},
    stress::{
        Axis, edit,
        testing::{self as stress, Refusal},
    },
    testing,
};
use dapple_opacity_maps::Model;
use std::collections::BTreeMap;

fn case(scene: &str) -> Case {
    testing::case(&SPEC, scene, &[("width", 48.into()), ("truth_rays", 2.into())])
}

fn setting(technique: &str) -> Setting {
    let mut setting = testing::setting(&SPEC, technique, "", Form::Cpu, &[]);
    setting.knobs.insert("resolution".into(), 64.into());
    setting
}

fn axis(id: &str) -> Axis {
    stress::find(axes(), id)
}

/// The error of a technique at a value, or why it was refused.
fn rmse(axis: &Axis, case: &Case, technique: &str, value: f64) -> Result<f64, SuiteError> {
    Ok(stress::check(axis, case, &setting(technique), value)?.errors["rmse"])
}

/// Techniques that between them have every knob; `bom` has what most axes push.
const PUSHED: [&str; 7] = ["bom", "dom", "moments", "avsm", "stochastic", "fourier", "deep"];

#[test]
fn every_axis_runs_at_its_ends_and_refuses_what_it_must() {
    let all = axes();
    assert!(all.len() >= 25, "{}", all.len());
    let most = |axis: &Axis| if axis.id == "map" { 500 } else { 2_000 };
    let searched = |axis: &Axis, value| axis.id == "nodes" && value > 64.0;
    let (case, settings) = (case("grass_sparse"), PUSHED.map(setting));
    let [ran, refused] = stress::run_ends(&all, &case, &settings, "rmse", most, searched);
    assert!(ran >= 70 && refused >= 30, "{ran} ran, {refused} were refused");
}

#[test]
fn every_technique_holds_in_a_column_of_one_and_of_many_and_on_one_texel() {
    let axis = axis("fragments");
    let parameters = axis.case_parameters(&SPEC, &Knobs::new()).unwrap();
    let case = Case { parameters, ..case("none") };
    let mut ran = 0;
    for value in [1.0, 1_000.0] {
        let prepared = (axis.prepare)(&case, value, None).unwrap();
        for technique in SPEC.techniques {
            stress::check_prepared(&axis, prepared.as_ref(), &setting(technique.id), value)
                .unwrap();
            let mut single = setting(technique.id);
            single.knobs.insert("resolution".into(), 1.into());
            match prepared.subject(&single).and_then(|mut subject| subject.check()) {
                Ok(checked) => {
                    assert!(checked.violations.is_empty(), "{single}: {:?}", checked.violations);
                    ran += 1;
                }
                // A cascade has a margin of a texel around what it covers.
                Err(error) => assert_eq!((technique.id, error.exit_code()), ("pssm", 2), "{error}"),
            }
        }
    }
    assert_eq!(ran, 2 * (SPEC.techniques.len() - 1));
}

#[test]
fn a_refusal_names_the_element_and_the_limit() {
    let expected: &[Refusal] = &[
        ("bad-vertices", "nan", "bom", ["grass_sparse: mesh 0", "vertex", "not finite"]),
        ("bad-vertices", "+inf", "bom", ["grass_sparse: mesh 0", "vertex", "not finite"]),
        ("bad-vertices", "-inf", "bom", ["grass_sparse: mesh 0", "vertex", "not finite"]),
        ("bad-vertices", "1e38", "bom", ["instance 0, mesh 0", "vertex", "at most 1e9 m"]),
        ("bad-vertices", "index", "bom", ["mesh 0", "triangle", "there are"]),
        ("bad-vertices", "no-triangle", "bom", ["instances", "no triangle", "needs one"]),
        ("bad-vertices", "opacity-nan", "bom", ["material 0", "opacity NaN", "0..=1"]),
        ("bad-vertices", "opacity-minus-0.1", "bom", ["material 0", "opacity -0.1", "0..=1"]),
        ("bad-vertices", "opacity-1.5", "bom", ["material 0", "opacity 1.5", "0..=1"]),
        ("bad-settings", "map-0", "bom", ["`resolution`", "= 0", "1..=8192"]),
        ("bad-settings", "map-minus-1", "bom", ["`resolution`", "= -1", "1..=8192"]),
        ("bad-settings", "map-8193", "bom", ["`resolution`", "= 8193", "1..=8192"]),
        ("bad-settings", "map-2^32+64", "bom", ["`resolution`", "= 4294967360", "1..=8192"]),
        ("bad-settings", "bias-minus-1e-3", "bom", ["bias", "-0.001", "0..=0.1"]),
        ("bad-settings", "bias-1e39", "bom", ["bias", "inf", "0..=0.1"]),
        ("bad-settings", "weight-0", "bom", ["opaque weight", "0", "above 0"]),
        ("bad-settings", "layers-0", "bom", ["layers", "0", "1..=256"]),
        ("bad-settings", "layers-257", "bom", ["layers", "257", "1..=256"]),
        ("bad-settings", "lambda-1.5", "bom", ["lambda", "1.5", "0..=1"]),
        ("bad-settings", "lambda-minus-0.5", "bom", ["lambda", "-0.5", "0..=1"]),
        ("bad-settings", "span-11", "dom", ["span", "11", "10"]),
        ("bad-settings", "growth-0.5", "dom", ["growth", "0.5", "1"]),
        ("bad-settings", "nodes-1", "avsm", ["nodes", "1", "2..=64"]),
        ("bad-settings", "samples-65", "stochastic", ["samples", "65", "1..=64"]),
        ("bad-settings", "pairs-16", "fourier", ["pairs", "16", "1..=15"]),
        ("bad-settings", "moment-bias-0.6", "moments", ["moment bias", "0.6", "0..=0.5"]),
        ("bad-settings", "tolerance-minus-0.1", "deep", ["tolerance", "-0.1", "0..=0.5"]),
        ("content", "empty-view", "bom", ["grass_sparse", "view", "sees nothing"]),
        ("content", "all-opaque", "bom", ["grass_sparse", "no material", "translucent"]),
        ("content", "all-clear", "bom", ["grass_sparse", "no material", "translucent"]),
    ];
    stress::expect_refusals(&axes(), &case("grass_sparse"), setting, expected);
}

fn loaded(case: &Case) -> Loaded {
    super::load(case).unwrap()
}

fn of(loaded: Loaded, case: &Case) -> TranslucentCase<'static> {
    TranslucentCase::of(checked(loaded).unwrap(), case, None).unwrap()
}

/// Root mean square of the difference of two truths over the receivers that both have, pixel by
/// pixel in order, and the share of receivers that one alone has.
fn difference(a: &TranslucentCase<'_>, b: &TranslucentCase<'_>) -> (f64, f64) {
    let (n, m) = (a.truth().len(), b.truth().len());
    if n != m {
        return (1.0, n.abs_diff(m) as f64 / n as f64);
    }
    let both: Vec<bool> = a.mask().iter().zip(b.mask()).map(|(a, b)| *a && *b).collect();
    let one = a.mask().iter().zip(b.mask()).filter(|(a, b)| a != b).count();
    (dapple_metrics::rmse(a.truth(), b.truth(), Some(&both)).unwrap(), one as f64 / n as f64)
}

#[test]
fn the_truth_of_a_scaled_or_moved_scene_is_that_of_the_scene() {
    for name in ["grass", "hair"] {
        let case = case(name);
        let home = of(loaded(&case), &case);
        for (what, pushed) in [
            ("1e-6", world::scaled(loaded(&case), 1e-6)),
            ("1e6", world::scaled(loaded(&case), 1e6)),
            ("1 radius", world::moved(loaded(&case), 1.0)),
            ("1e7 radii", world::moved(loaded(&case), 1e7)),
        ] {
            let (rmse, one) = difference(&home, &of(pushed, &case));
            assert!(rmse < 0.003 && one < 1e-3, "{name} {what}: {rmse} {one}");
        }
        // A truth traced in f32 coordinates would not survive the same move.
        let naive = super::both(world::moved(loaded(&case), 1e7), edit::in_single_precision);
        let naive = checked(naive).and_then(|naive| TranslucentCase::of(naive, &case, None));
        assert!(naive.is_err() || difference(&home, &naive.unwrap()).0 > 0.1, "{name}");
    }
}

#[test]
fn a_light_a_hair_off_the_vertical_sees_what_the_vertical_one_sees() {
    let case = case("grass");
    let at = |degrees| of(world::lit_at(&case, degrees).unwrap(), &case);
    let above = at(0.0);
    for degrees in [1e-9, 1e-6, 1e-4] {
        let (rmse, one) = difference(&above, &at(degrees));
        assert!(rmse < 0.003 && one < 1e-3, "{degrees}: {rmse} {one}");
    }
    assert!(difference(&above, &at(45.0)).0 > 0.1);
    for degrees in [0.0_f64, 30.0, 90.0] {
        let cosine = -at(degrees).view(true).forward.y;
        assert!((cosine - degrees.to_radians().cos()).abs() < 1e-12, "{degrees}");
    }
}

#[test]
fn lines_of_hair_face_the_light_that_they_are_given() {
    let case = case("hair");
    let [above, level] = [0.0, 80.0].map(|d| world::lit_at(&case, d).unwrap().casters.unwrap());
    assert_ne!(above.hash(), level.hash());
    let ribbons = |scene: &dapple_scene::Scene| {
        let mesh = scene.meshes.iter().max_by_key(|m| m.triangles.len()).unwrap();
        mesh.positions.clone()
    };
    assert_ne!(ribbons(&above), ribbons(&level));
}

#[test]
fn triangles_without_area_change_nothing() {
    let case = case("grass_sparse");
    let home = of(loaded(&case), &case);
    let add = |scene| edit::with_degenerate_triangles(scene, 3_000, 0);
    let with = of(super::both(loaded(&case), add), &case);
    let added = with.casters().degenerate_triangles() - home.casters().degenerate_triangles();
    assert!(added >= 2_990, "{added}");
    assert_eq!(home.receivers(true), with.receivers(true));
    assert_eq!(home.truth(), with.truth());
    let map = |c: &TranslucentCase<'_>| c.fragments(true, 64, Model::ExpTau).unwrap();
    assert_eq!(map(&home), map(&with));
    // Triangles with an area do.
    let strewn = of(super::both(loaded(&case), |s| edit::with_confetti(s, 100, 0)), &case);
    assert_ne!(map(&home), map(&strewn));
}

#[test]
fn a_longer_depth_range_moves_depths_and_nothing_else() {
    let case = case("grass_sparse");
    let ranged = |depth_range| {
        let given = super::Given { depth_range, ..super::Given::default() };
        TranslucentCase::given(loaded(&case), &given, &case, None).unwrap()
    };
    let (home, long) = (ranged(1.0), ranged(1000.0));
    assert_eq!((home.mask(), home.truth()), (long.mask(), long.truth()));
    let mut compared = 0;
    for (a, b) in home.receivers(true).iter().zip(long.receivers(true).iter()) {
        assert_eq!((a.u, a.v), (b.u, b.v));
        let expected = 1.0 - (1.0 - f64::from(a.depth)) / 1000.0;
        assert!((f64::from(b.depth) - expected).abs() < 1e-7, "{} {expected}", b.depth);
        compared += 1;
    }
    assert!(compared > 500, "{compared}");
    // A shorter one clips what is near the light.
    let short = ranged(0.1);
    let met = |c: &TranslucentCase<'_>| c.fragments(true, 64, Model::ExpTau).unwrap().items.len();
    assert!(met(&short) < met(&home) && met(&home) > 0);
    assert_eq!(home.truth(), short.truth());
}

/// Transmittance at each sheet of a column, by the formula.
fn at_sheet(count: u32, thickness: f64, above: u32) -> f64 {
    (1.0 - f64::from(column::sheet_opacity(count, thickness))).powi(above as i32)
}

#[test]
fn the_truth_in_a_column_is_a_power_of_one_sheets() {
    let parameters = axis("fragments").case_parameters(&SPEC, &Knobs::new()).unwrap();
    let case = Case { parameters, ..case("none") };
    for (count, thickness) in [(1, 0.7), (2, 0.7), (64, 0.7), (16, 100.0), (2_000, 0.7)] {
        let prepared = of(column::loaded(column::column(count, thickness)).unwrap(), &case);
        // Depth from the light to the number of sheets above.
        let map = prepared.fragments(true, 1, Model::ExpTau).unwrap();
        assert_eq!(map.items.len(), count as usize);
        let mut depths: Vec<f32> = map.items.iter().map(|f| f.depth).collect();
        depths.sort_by(f32::total_cmp);
        let mut seen = BTreeMap::new();
        for (receiver, truth) in prepared.receivers(true).iter().zip(prepared.truth()) {
            let above =
                depths.iter().filter(|d| **d < receiver.depth - 1e-3 / count as f32).count();
            let expected = at_sheet(count, thickness, above as u32);
            assert!((f64::from(*truth) - expected).abs() < 2e-6, "{count}: {truth} {expected}");
            seen.insert(above, ());
        }
        // The camera sees a few sheets of many, and the floor where there is one sheet.
        let least = if count < 10 { 1 } else { count as usize / 4 };
        assert!(seen.len() >= least.min(20), "{count}: {} of its sheets are seen", seen.len());
        // Every texel meets the same.
        let map = prepared.fragments(true, 4, Model::ExpTau).unwrap();
        assert!((0..16).all(|t| map.texel(t) == map.texel(0)));
    }
}

#[test]
fn faint_sheets_stall_a_half_float_and_vanish_from_bytes() {
    let parameters = axis("fragments").case_parameters(&SPEC, &Knobs::new()).unwrap();
    let case = Case { parameters, ..case("none") };
    let error = |id: &str, value: f64| rmse(&axis(id), &case, "bom", value).unwrap();
    let broken = |id: &str, value: f64| {
        let axis = axis(id);
        let limit = axis.criterion.times * error(id, axis.home) + axis.criterion.plus;
        error(id, value) > limit
    };
    // A sheet below 1/510 rounds to no byte; half a step of a half float at 0.25 is 1.2e-4.
    assert!(broken("fragments-unorm8", 2_000.0));
    assert!(broken("fragments-f16", 8_000.0));
    assert!(!broken("fragments-f16", 500.0));
    assert!(!broken("fragments", 8_000.0));
    assert!(!broken("fragments-fixed", 8_000.0));
    // A byte is full at 1.
    assert!(broken("thickness-unorm8", 40.0));
    assert!(!broken("thickness-unorm8-scaled", 4.0));
}

#[test]
fn one_square_is_one_depth_or_none() {
    let case = case("grass_sparse");
    let square = |pose, half| {
        let change = |scene| world::one_square(scene, pose, half);
        of(super::both(loaded(&case), change), &case)
    };
    let facing = square(world::Pose::Facing, world::LEAF);
    let map = facing.fragments(false, 64, Model::ExpTau).unwrap();
    let depths = map.items.iter().map(|f| f.depth);
    let (least, greatest) = depths.fold((1.0_f32, 0.0_f32), |(l, g), d| (l.min(d), g.max(d)));
    assert!(map.items.len() > 50 && greatest - least < 1e-6, "{least}..{greatest}");
    // The floor below it is darker, the square itself is lit.
    let dark = facing.truth().iter().filter(|t| **t < 0.4).count();
    assert!(dark > 10, "{dark}");
    let along = square(world::Pose::Along, world::LEAF);
    let met = along.fragments(false, 64, Model::ExpTau).unwrap().items.len();
    assert!(met <= 64, "{met}");
    assert!(along.truth().iter().all(|t| *t > 0.25));
}

#[test]
fn an_axis_that_means_nothing_to_a_technique_is_left_out() {
    let meant = |id: &str, technique: &str, value: f64| {
        (axis(id).setting)(&setting(technique), value).is_some()
    };
    assert!(meant("precision", "bom", 2.0) && !meant("precision", "fourier", 2.0));
    assert!(meant("layers", "osm", 1.0) && !meant("layers", "avsm", 1.0));
    assert!(meant("fragments-f16", "moments", 1.0) && !meant("fragments-f16", "deep", 1.0));
    assert!(meant("span", "dom", 1.0) && !meant("span", "bom", 1.0));
}

#[test]
fn wishes_of_a_case_turn_no_light_by_themselves() {
    let case = case("grass_sparse");
    let wishes = Wishes::of(&case.parameters).unwrap();
    assert_eq!((wishes.degrees, wishes.light.as_str()), (None, "scene"));
    let plain = scene::load(&case.scene, "", 0, &wishes).unwrap();
    assert!(plain.notes.iter().all(|n| !n.contains("lights are replaced")), "{:?}", plain.notes);
}
