//! The extremes themselves: what they must leave alone, what they must break, what must be refused.

use super::{LightsCase, axes, known, lights, made, places, walls, world};
use crate::{
    case::Case,
    problem::{Form, Setting, Technique},
    problems::many_lights::{
        SPEC,
        input::{self, Input},
    },
    stress::{
        Axis,
        judge::{Home, Verdict},
        testing as stress,
    },
    testing,
};
use dapple_many_lights::{Light, radiance, sample::Random};
use glam::DVec3;

fn case(axis: &Axis) -> Case {
    stress::case(&SPEC, axis)
}

fn setting(technique: &str) -> Setting {
    testing::setting(&SPEC, technique, "", Form::Cpu, &[])
}

fn axis(id: &str) -> Axis {
    stress::find(axes(), id)
}

/// More lights, columns or samples show no more here than these do, in seconds less.
const MOST: u32 = 500;

/// Whether single precision does not tell how far lights are from a surface there: 20 m from the
/// middle of the scene it holds places to 2e-6 m.
fn is_too_close(axis: &Axis, value: f64) -> bool {
    let close = ["above-surface", "before-a-wall", "behind-a-wall"].contains(&axis.id);
    close && value > 0.0 && value < 1e-3
}

#[test]
fn every_axis_runs_at_its_ends_and_refuses_what_it_must() {
    let (all, mut ran, mut refused) = (axes(), 0, 0);
    assert!(all.len() >= 45, "{}", all.len());
    // A million lights take seconds.
    for axis in all.into_iter().filter(|axis| axis.id != "a-million") {
        let case = case(&axis);
        for value in stress::ends(&axis, MOST) {
            let prepared = (axis.prepare)(&case, value, None);
            let of = |technique: &Technique| setting(technique.id);
            let meant = |technique: &&Technique| (axis.setting)(&of(technique), value).is_some();
            let meant: Vec<Setting> = SPEC.techniques.iter().filter(meant).map(of).collect();
            assert!(!meant.is_empty(), "{} at {value} means nothing", axis.id);
            for setting in meant {
                let place = format!("{} at {value}, {setting}", axis.id);
                let judged = stress::judged(&axis, &prepared, &setting, value, &Home::Here);
                // The clamp grows with the scene: below what single precision holds. And generated
                // cities have no street lamps.
                let too_small = axis.id == "scale" && value < 1e-5;
                let no_lamps = axis.id == "lit" && axis.values.label(value) == "lamps";
                if (axis.must_refuse)(value) || too_small || no_lamps {
                    assert_eq!(judged.verdict, Verdict::Refused, "{place}: {}", judged.reason);
                    refused += 1;
                    continue;
                }
                if is_too_close(&axis, value) {
                    let port = judged.reason.is_empty() || judged.reason.starts_with("port");
                    assert!(port, "{place}: {}", judged.reason);
                    continue;
                }
                assert_eq!(judged.verdict, Verdict::Safe, "{place}: {}", judged.reason);
                ran += 1;
            }
        }
    }
    assert!(ran >= 400 && refused >= 200, "{ran} ran, {refused} were refused");
}

#[test]
fn a_refusal_names_the_element_and_the_limit() {
    let expected = [
        ("bad-vertices", "nan", "brute-force", ["mesh 0", "vertex", "not finite"]),
        ("bad-vertices", "1e38", "brute-force", ["mesh 0", "vertex", "at most 1e9 m"]),
        ("bad-vertices", "index", "brute-force", ["mesh 0", "triangle 1", "there are 4"]),
        ("bad-vertices", "placement", "brute-force", ["instance 0", "transform", "not finite"]),
        ("bad-vertices", "mesh", "brute-force", ["instance 0", "mesh 77", "of 4"]),
        ("bad-vertices", "albedo", "brute-force", ["material 0", "albedo", ""]),
        ("bad-lights", "place-nan", "capped", ["light 3", "position", "finite"]),
        ("bad-lights", "place-1e10", "capped", ["light 3", "coordinate", "1e9 m"]),
        ("bad-lights", "intensity-nan", "capped", ["light 3", "intensity", "finite"]),
        ("bad-lights", "intensity-negative", "capped", ["light 3", "intensity", "negative"]),
        ("bad-lights", "intensity-1e16", "capped", ["light 3", "intensity", "above 1e15"]),
        ("bad-lights", "axis-zero", "capped", ["light 3", "axis", "unit length"]),
        ("bad-lights", "axis-long", "capped", ["light 3", "axis", "unit length"]),
        ("bad-lights", "half-angle-0", "capped", ["light 3", "half angle", "(0, π]"]),
        ("bad-lights", "half-angle-4", "capped", ["light 3", "half angle", "(0, π]"]),
        ("bad-lights", "half-angle-nan", "capped", ["light 3", "half angle", "(0, π]"]),
        ("bad-parameters", "clamp-0", "capped", ["clamp", "1e-6", "1e6 m"]),
        ("bad-parameters", "frames-0", "capped", ["frame", "shows anything", "view"]),
        ("bad-parameters", "width-0", "capped", ["frame", "shows anything", "view"]),
        ("bad-settings", "threshold-minus-1", "absolute-cut", ["`threshold`", "= -1", "0..="]),
        ("bad-settings", "epsilon-101", "lightcuts", ["`epsilon`", "= 101", "0..=100"]),
        ("bad-settings", "most-2^32+1", "capped", ["`most`", "= 4294967297", "1..=1000000"]),
        ("bad-settings", "samples-0", "light-bvh", ["`samples`", "= 0", "1..=4096"]),
        ("bad-settings", "cut-1025", "stochastic-lightcuts", ["`cut`", "= 1025", "1..=1024"]),
        ("bad-settings", "history-0", "reservoirs", ["`history`", "= 0", "1..=1000"]),
        ("bad-settings", "radius-0", "reservoirs", ["`radius`", "= 0", "1..=1000"]),
        ("bad-settings", "cutoff-0", "clustered", ["`cutoff`", "= 0", "..=1"]),
        ("bad-settings", "tile-2^32+32", "clustered", ["`tile`", "= 4294967328", "1..=1024"]),
        ("bad-settings", "tree-oak", "relative-cut", ["`tree`", "oak", "median"]),
        ("content", "empty-view", "capped", ["scene rectangles", "view", "shows anything"]),
        ("content", "nothing", "capped", ["rectangles", "no triangle", "needs one"]),
        ("fanout", "1", "absolute-cut", ["children", "1", "at least 2"]),
        ("scale", "1e-6", "capped", ["clamp", "1e-6", "1e6 m"]),
        ("lit", "lamps", "capped", ["scene city_small", "no light", "burns"]),
    ];
    for (id, word, technique, parts) in expected {
        let axis = axis(id);
        let value = axis.values.parse(id, word).unwrap();
        let prepared = (axis.prepare)(&case(&axis), value, None);
        let judged = stress::judged(&axis, &prepared, &setting(technique), value, &Home::Here);
        assert_eq!(judged.verdict, Verdict::Refused, "{id} {word}: {}", judged.reason);
        for part in parts {
            assert!(judged.reason.contains(part), "{id} {word}: {}", judged.reason);
        }
    }
}

/// The verdict on a technique at a value, judged by itself at home.
fn verdict(id: &str, technique: &str, value: f64) -> (Verdict, String) {
    let axis = axis(id);
    let (case, setting) = (case(&axis), setting(technique));
    let at = |value, home: &Home| {
        stress::judged(&axis, &(axis.prepare)(&case, value, None), &setting, value, home)
    };
    let home = at(axis.home, &Home::Here);
    assert_eq!(home.verdict, Verdict::Safe, "{id}, {technique}: {}", home.reason);
    let judged = at(value, &Home::Error(home.error.unwrap()));
    (judged.verdict, judged.reason)
}

#[test]
fn what_leaves_light_out_breaks_and_what_does_not_holds() {
    for (id, technique, value) in [
        ("threshold", "absolute-cut", 1e9),
        ("own-epsilon", "relative-cut", 1e6),
        ("epsilon", "lightcuts", 100.0),
        ("most", "lightcuts", 1.0),
        ("most", "capped", 1.0),
        ("cutoff", "clustered", 1.0),
        ("lights", "capped", 10_000.0),
        ("lights", "clustered", 10_000.0),
    ] {
        let (broken, reason) = verdict(id, technique, value);
        assert_eq!(broken, Verdict::Broken, "{id}, {technique}");
        assert!(reason.contains("error_p99"), "{id}, {technique}: {reason}");
    }
    for (id, technique, value) in [
        ("threshold", "absolute-cut", 0.0),
        ("epsilon", "lightcuts", 0.0),
        ("most", "capped", 16_384.0),
        ("cutoff", "clustered", 1e-9),
        ("lights", "absolute-cut", 10_000.0),
        ("coincident", "absolute-cut", 1.0),
        ("opposite-axes", "absolute-cut", 1.0),
        ("brightness-range", "light-bvh", 1e12),
        ("speed", "reservoirs", 1e4),
        ("turn", "reservoirs", 180.0),
    ] {
        assert_eq!(verdict(id, technique, value), (Verdict::Safe, String::new()), "{id}");
    }
}

fn prepared(input: Input, case: &Case) -> LightsCase<'static> {
    input.scene.validate().unwrap();
    LightsCase::of(known(input), case, None).unwrap()
}

/// What the pixels of the first frame should show.
fn truth(case: &LightsCase<'_>) -> Vec<DVec3> {
    case.truth().frame(0).map(|(_, radiance)| radiance).collect()
}

fn sum(radiances: &[DVec3]) -> f64 {
    radiances.iter().map(|radiance| radiance.element_sum()).sum()
}

/// The mean difference of two truths over the mean of the first.
fn difference(a: &LightsCase<'_>, b: &LightsCase<'_>) -> f64 {
    let (a, b) = (truth(a), truth(b));
    assert_eq!(a.len(), b.len());
    let apart = a.iter().zip(&b).map(|(a, b)| (*a - *b).abs().element_sum()).sum::<f64>();
    apart / sum(&a)
}

#[test]
fn the_truth_of_a_scaled_or_moved_scene_is_that_of_the_scene() {
    let case = case(&axis("scale"));
    let load = || input::load(&case).unwrap();
    let at = |input: Input, scale: f64| {
        let mut case = case.clone();
        case.parameters.insert("clamp".into(), (0.1 * scale).into());
        prepared(input, &case)
    };
    let home = at(load(), 1.0);
    let one = 1.0 / load().scene.bounds().radius();
    for (what, pushed, scale) in [
        ("1e-5", world::scaled(load(), 1e-5), 1e-5),
        ("1e6", world::scaled(load(), 1e6), 1e6),
        ("1 radius", world::moved(load(), 1.0), 1.0),
        ("1e7 radii", world::moved(world::scaled(load(), one), 1e7), one),
    ] {
        let apart = difference(&home, &at(pushed, scale));
        assert!(apart < 0.002, "{what}: {apart}");
    }
    // With the intensities left as they were it is another scene.
    let mut dim = world::scaled(load(), 10.0);
    for light in &mut dim.lights {
        light.intensity /= 100.0;
    }
    assert!(difference(&home, &at(dim, 10.0)) > 0.9);
}

#[test]
fn lights_on_the_very_points_do_not_light_them_and_above_them_do() {
    let case = case(&axis("above-surface"));
    let at = |distance_m| prepared(places::lifted(distance_m, &case).unwrap(), &case);
    let (on, above) = (at(0.0), at(0.5));
    let mut met = 0;
    for light in &on.world().lights {
        let points = on.world().frames[0].points.iter().filter(|point| point.is_there());
        for point in points.filter(|point| point.position.as_dvec3() == light.position) {
            assert_eq!(radiance(point, light, on.world().clamp_m), DVec3::ZERO);
            met += 1;
        }
    }
    assert!(met >= 100, "{met} lights lie on points");
    assert!(sum(&truth(&above)) > sum(&truth(&on)));
}

#[test]
fn lights_below_the_ground_light_little_that_shows() {
    let case = case(&axis("behind"));
    let below = |share| {
        let change = |light: &mut Light| light.position.y = -light.position.y;
        sum(&truth(&prepared(made::with_share(share, 0, change), &case)))
    };
    let (none, half, all) = (below(0.0), below(0.5), below(1.0));
    assert!(none > half && half > 2.0 * all, "{none} {half} {all}");
}

#[test]
fn a_wall_hides_what_is_behind_it_and_not_what_is_before_it() {
    let with = |distance_m, shadows: &str| {
        let mut case = case(&axis("behind-a-wall"));
        case.parameters.insert("visibility".into(), shadows.into());
        sum(&truth(&prepared(walls::at_the_wall(distance_m, 0), &case)))
    };
    for distance_m in [1e-5, 1e-3, 0.1] {
        // Beside and over the wall nothing shows that they could light.
        assert_eq!(with(-distance_m, "on"), 0.0, "{distance_m}");
        assert!(with(-distance_m, "off") > 1.0, "{distance_m}");
        let [on, off] = ["on", "off"].map(|shadows| with(distance_m, shadows));
        assert!(on > 0.5 * off && on <= off, "{distance_m}: {on} of {off}");
    }
}

#[test]
fn worlds_are_what_their_axes_say() {
    let luminances = |input: &Input| -> Vec<f64> {
        input.lights.iter().map(|light| light.luminance()).collect()
    };
    let (plain, wide) = (luminances(&made::cloud(200, 3)), luminances(&lights::ranged(1e12, 3)));
    let [a, b] = [&plain, &wide].map(|all| all.iter().sum::<f64>());
    assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
    let least = wide.iter().copied().fold(f64::INFINITY, f64::min);
    let most = wide.iter().copied().fold(0.0, f64::max);
    assert!((1e11..=1e12).contains(&(most / least)), "{most} {least}");

    let paired = lights::opposed(0.5, 3);
    let (pairs, _) = paired.lights.as_chunks::<2>();
    let back_to_back = |[a, b]: &&[Light; 2]| a.position == b.position && a.axis == -b.axis;
    assert_eq!(pairs.iter().filter(back_to_back).count(), 50);

    for spread in [0.0, 1e-6, 0.5, 3.0] {
        let angles = (0..200).map(|index| {
            let axis = made::downwards(spread, &mut Random::new(1, 2, index));
            assert!((axis.length() - 1.0).abs() < 1e-12);
            axis.cross(DVec3::NEG_Y).length().atan2(axis.dot(DVec3::NEG_Y))
        });
        let widest = angles.fold(0.0, f64::max);
        assert!(widest <= spread * (1.0 + 1e-3), "{spread}: {widest}");
        assert!(widest >= 0.8 * spread, "{spread}: {widest}");
    }

    // More are changed for a larger share, and the same ones.
    let dark = |share| -> Vec<usize> {
        let input = made::with_share(share, 3, |light| light.intensity = DVec3::ZERO);
        let is_dark = |index: &usize| input.lights[*index].intensity == DVec3::ZERO;
        (0..input.lights.len()).filter(is_dark).collect()
    };
    let (few, many) = (dark(0.25), dark(0.75));
    assert!(few.iter().all(|index| many.contains(index)));
    assert_eq!((dark(0.0).len(), dark(1.0).len()), (0, 200));
    assert!((30..70).contains(&few.len()) && (130..170).contains(&many.len()));
}

#[test]
fn the_narrowest_cones_light_no_pixel_and_the_widest_most() {
    let axis = axis("half-angle");
    let case = case(&axis);
    let lit = |degrees: f64| {
        let prepared = (axis.prepare)(&case, degrees, None).unwrap();
        let picture =
            prepared.subject(&setting("brute-force")).unwrap().picture().unwrap().unwrap();
        picture.truth.iter().filter(|grey| **grey > 0.0).count()
    };
    let [needle, usual, all] = [1e-4, 45.0, 180.0].map(lit);
    assert!(needle == 0 && usual > 50 && all >= usual, "{needle} {usual} {all}");
}
