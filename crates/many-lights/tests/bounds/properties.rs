//! Estimates and bounds of clusters: P14 at random and adversarial points, in f64 and f32.

use crate::support::{CLAMP_M, Case, FORMS, broken, broken_f64, case, cluster, node_around};
use dapple_many_lights::{
    BoundForm, Point,
    bound::{self, Region, packed},
};
use glam::DVec3;
use proptest::{prelude::*, strategy::ValueTree, test_runner::TestRunner};

// Files of failures would be looked for beside lib.rs.
fn cases(count: u32) -> ProptestConfig {
    ProptestConfig { cases: count, failure_persistence: None, ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(cases(20_000))]

    #[test]
    fn clusters_give_at_most_their_bound(case in case()) {
        prop_assert_eq!(broken_f64(&case, CLAMP_M, CLAMP_M), None);
    }

    #[test]
    fn clusters_give_at_most_their_bound_in_f32(case in case()) {
        let (node, clamp) = (case.packed(), packed::clamp_squared(CLAMP_M));
        let estimate = packed::estimate(&node, &case.point, clamp).as_dvec3();
        for form in FORMS {
            let bound = f64::from(packed::point(form, &node, &case.point, clamp));
            prop_assert_eq!(broken(&case, estimate, bound, f64::EPSILON), None, "{:?}", form);
            let region = Region::at(&case.point);
            let (least, most) = bound::band(form, &case.node, &node, &region, CLAMP_M);
            prop_assert!(
                least * (1.0 - 1e-12) <= bound + 1e-30 && bound <= most * (1.0 + 1e-12) + 1e-30,
                "{:?}: {} outside of {}..={}", form, bound, least, most
            );
        }
    }

    #[test]
    fn the_cheap_form_is_nowhere_below_walters(case in case()) {
        let node = case.packed();
        let [walter, cheap] = FORMS.map(|f| bound::point(f, &case.node, &case.point, CLAMP_M));
        prop_assert!(walter <= cheap * (1.0 + 1e-12), "{} {}", walter, cheap);
        let region = Region::at(&case.point);
        let walter = packed::point(
            BoundForm::Walter, &node, &case.point, packed::clamp_squared(CLAMP_M),
        );
        let (_, cheap) = bound::band(BoundForm::Cheap, &case.node, &node, &region, CLAMP_M);
        prop_assert!(f64::from(walter) <= cheap * (1.0 + 1e-12) + 1e-30, "{} {}", walter, cheap);
    }

    #[test]
    fn a_region_is_bounded_by_at_least_every_point_of_it(
        lights in cluster(),
        points in prop::collection::vec(case(), 1..5),
        flat in any::<bool>(),
    ) {
        let node = Case::new(lights, Point::default());
        let mut points: Vec<Point> = points.iter().map(|case| case.point).collect();
        let first = points[0].normal;
        for point in &mut points {
            point.normal = if flat { first } else { point.normal };
        }
        let region = Region::of(points.iter()).unwrap();
        let packed_region = packed::PackedRegion::of(points.iter()).unwrap();
        let (packed_node, clamp) = (node.packed(), packed::clamp_squared(CLAMP_M));
        for (form, point) in FORMS.iter().flat_map(|f| points.iter().map(move |p| (*f, p))) {
            let all = bound::region(form, &node.node, &region, CLAMP_M);
            let one = bound::point(form, &node.node, point, CLAMP_M);
            prop_assert!(!flat || one <= all * (1.0 + 1e-5) + 1e-30, "{:?}: {} above {}", form, one, all);
            let at = Case { point: *point, ..node.clone() };
            let estimate = bound::estimate(&node.node, point, CLAMP_M);
            prop_assert_eq!(broken(&at, estimate, all, 0.0), None, "{:?}", form);
            let all = packed::region(form, &packed_node, &packed_region, clamp);
            let estimate = packed::estimate(&packed_node, point, clamp).as_dvec3();
            prop_assert_eq!(
                broken(&at, estimate, f64::from(all), f64::EPSILON), None, "f32 {:?}", form
            );
        }
    }
}

/// The first of `count` seeded cases that breaks P14 by `check`.
fn first_broken(count: usize, check: impl Fn(&Case) -> Option<String>) -> Option<String> {
    let mut runner = TestRunner::deterministic();
    let strategy = case();
    (0..count).find_map(|_| check(&strategy.new_tree(&mut runner).unwrap().current()))
}

#[test]
fn the_seeded_cases_break_nothing_by_themselves() {
    assert_eq!(first_broken(5000, |case| broken_f64(case, CLAMP_M, CLAMP_M)), None);
}

#[test]
fn clamping_the_estimate_alone_or_the_bound_alone_is_found() {
    let tiny = 1e-9;
    let bound_alone = first_broken(5000, |case| broken_f64(case, tiny, CLAMP_M)).unwrap();
    assert!(bound_alone.contains("estimate") && bound_alone.contains("not in"), "{bound_alone}");
    // Without a clamp in truth and bound, a clamped estimate breaks no inequality: it is a leaf's
    // estimate that is not its light's radiance any more.
    let estimate_alone = first_broken(5000, |case| broken_f64(case, 10.0, tiny)).unwrap();
    assert!(estimate_alone.contains("leaf"), "{estimate_alone}");
}

#[test]
fn a_cone_without_the_lights_axes_is_found() {
    let found = first_broken(5000, |case| {
        let node = dapple_many_lights::Node { cone_rad: 0.0, ..case.node };
        broken_f64(&Case { node, ..case.clone() }, CLAMP_M, CLAMP_M)
    });
    assert!(found.unwrap().contains("the lights give"));
}

#[test]
fn a_box_without_the_last_light_is_found() {
    let found = first_broken(5000, |case| {
        let few = node_around(&case.lights[..case.lights.len().div_ceil(2)]);
        let node = dapple_many_lights::Node { min: few.min, max: few.max, ..case.node };
        broken_f64(&Case { node, ..case.clone() }, CLAMP_M, CLAMP_M)
    });
    assert!(found.is_some());
}

#[test]
fn walters_form_is_often_below_the_cheap_one() {
    let mut runner = TestRunner::deterministic();
    let below = (0..2000)
        .filter(|_| {
            let case = case().new_tree(&mut runner).unwrap().current();
            let bound = |form| bound::point(form, &case.node, &case.point, CLAMP_M);
            bound(BoundForm::Walter) < 0.99 * bound(BoundForm::Cheap)
        })
        .count();
    assert!(below > 50, "{below} of 2000");
}

#[test]
fn a_region_of_nothing_is_none() {
    let points = [Point::nothing(), Point::nothing()];
    assert_eq!(Region::of(points.iter()), None);
    assert_eq!(packed::PackedRegion::of(points.iter()), None);
    assert_eq!(Region::of([].iter()), None);
}

#[test]
fn what_lies_behind_is_bounded_by_nothing_at_all() {
    let light = dapple_many_lights::Light {
        position: DVec3::new(0.0, -1.0, 0.0),
        axis: DVec3::Y,
        intensity: DVec3::ONE,
        emission: dapple_many_lights::Emission::Omni,
    };
    let point = Point { normal: glam::Vec3::Y, albedo: glam::Vec3::ONE, ..Point::default() };
    let case = Case::new(vec![light], point);
    for form in [BoundForm::Walter, BoundForm::Cheap] {
        assert_eq!(bound::point(form, &case.node, &point, CLAMP_M), 0.0);
        assert_eq!(packed::point(form, &case.packed(), &point, 0.01), 0.0);
    }
}
