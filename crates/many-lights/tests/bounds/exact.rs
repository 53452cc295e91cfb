//! Radiance, estimates and bounds where the answer is known, and what is refused.

use crate::support::{CLAMP_M, Case, FORMS};
use dapple_many_lights::{
    Emission, Eye, Frame, Light, Point, World, bound, bound::packed, radiance,
};
use glam::{DVec3, Vec3};
use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, PI};

fn point() -> Point {
    Point { normal: Vec3::Y, albedo: Vec3::new(0.5, 0.25, 1.0), ..Point::default() }
}

fn light(position: DVec3, axis: DVec3, emission: Emission) -> Light {
    Light { position, axis, intensity: DVec3::new(4.0, 8.0, 2.0), emission }
}

/// Holds the exact value, estimates and both bounds of a single light against `share` of
/// albedo · intensity / π: for one light the bound is the value itself.
fn holds(light: Light, share: f64) {
    let case = Case::new(vec![light], point());
    let expected = DVec3::new(2.0, 2.0, 2.0) * FRAC_1_PI * share;
    let near = |what: &str, got: DVec3, tolerance: f64| {
        let off = (got - expected).abs().max_element();
        assert!(off <= tolerance * expected.max_element().max(1e-9), "{what}: {got}, {expected}");
    };
    near("exact", radiance(&case.point, &light, CLAMP_M), 1e-14);
    near("f64", bound::estimate(&case.node, &case.point, CLAMP_M), 1e-14);
    let clamp = packed::clamp_squared(CLAMP_M);
    near("f32", packed::estimate(&case.packed(), &case.point, clamp).as_dvec3(), 1e-6);
    for form in FORMS {
        let bound = bound::point(form, &case.node, &case.point, CLAMP_M);
        near("bound", DVec3::splat(bound), 1e-2);
        let bound = packed::point(form, &case.packed(), &case.point, clamp);
        near("bound in f32", DVec3::splat(f64::from(bound)), 1e-2);
    }
}

#[test]
fn single_lights_give_what_the_formula_says() {
    let above = |height| DVec3::new(0.0, height, 0.0);
    let spot = Emission::Spot { half_angle_rad: FRAC_PI_4 };
    holds(light(above(2.0), DVec3::X, Emission::Omni), 0.25);
    holds(light(above(0.1), DVec3::X, Emission::Omni), 100.0);
    // Below the clamp, all distances are the clamp's.
    holds(light(above(0.01), DVec3::X, Emission::Omni), 100.0);
    // 45 degrees aside, and twice the squared distance.
    holds(light(DVec3::new(1.0, 1.0, 0.0), DVec3::X, Emission::Omni), 0.5 * FRAC_PI_4.cos());
    // A patch that faces away by 60 degrees.
    let aside = DVec3::new((PI / 3.0).sin(), -(PI / 3.0).cos(), 0.0);
    holds(light(above(2.0), aside, Emission::Oriented), 0.125);
    // Half the way out of a spot light's cone.
    let aside = DVec3::new((PI / 8.0).sin(), -(PI / 8.0).cos(), 0.0);
    holds(light(above(2.0), aside, spot), 0.125);
    holds(light(above(2.0), -DVec3::Y, spot), 0.25);
    holds(light(above(1e9), -DVec3::Y, Emission::Directional), 1.0);
    let aside = DVec3::new((PI / 3.0).sin(), -(PI / 3.0).cos(), 0.0);
    holds(light(above(0.0), aside, Emission::Directional), 0.5);
}

#[test]
fn nothing_comes_from_behind_beside_the_cone_or_the_very_point() {
    let above = DVec3::new(0.0, 2.0, 0.0);
    let spot = |half_angle_rad| Emission::Spot { half_angle_rad };
    let dark = [
        light(-above, DVec3::Y, Emission::Omni),
        light(above, DVec3::Y, Emission::Oriented),
        light(above, DVec3::X, spot(FRAC_PI_4)),
        light(above, DVec3::Y, spot(FRAC_PI_2)),
        light(above, DVec3::Y, Emission::Directional),
        light(DVec3::ZERO, DVec3::Y, Emission::Omni),
        light(DVec3::ZERO, DVec3::Y, spot(PI)),
    ];
    for light in dark {
        assert_eq!(radiance(&point(), &light, CLAMP_M), DVec3::ZERO, "{light:?}");
        let node = Case::new(vec![light], point()).packed();
        assert_eq!(packed::estimate(&node, &point(), 0.01), Vec3::ZERO, "{light:?}");
    }
    // On the edge of the hemisphere of light that is bounded by it, only rounding is left.
    for light in &dark[..5] {
        for form in FORMS {
            let case = Case::new(vec![*light], point());
            let bound = bound::point(form, &case.node, &case.point, CLAMP_M);
            assert!(bound < 2e-5, "{light:?}: {bound}");
        }
    }
}

/// A sphere of equal lights around a point: the mean of max(cos, 0) over a sphere is 1/4.
#[test]
fn a_sphere_of_lights_gives_a_quarter() {
    let count = 20_000;
    let golden = PI * (3.0 - 5f64.sqrt());
    let sum: DVec3 = (0..count)
        .map(|i| {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
            let (sin, cos) = (golden * f64::from(i)).sin_cos();
            let across = (1.0 - z * z).sqrt();
            let position = 5.0 * DVec3::new(across * cos, across * sin, z);
            radiance(&point(), &light(position, DVec3::X, Emission::Omni), CLAMP_M)
        })
        .sum();
    let expected = f64::from(count) * 2.0 * FRAC_1_PI / (4.0 * 25.0);
    assert!((sum / expected - 1.0).abs().max_element() < 1e-4, "{sum} {expected}");
}

/// A disk of patches of radiance 1 that faces a white point gives sin² of its angle.
#[test]
fn a_disk_of_patches_gives_the_sine_squared() {
    let (side, cell) = (400, 0.05);
    let white = Point { albedo: Vec3::ONE, ..point() };
    let mut sum = DVec3::ZERO;
    for i in 0..side * side {
        let at = |k: i32| (f64::from(k) - 0.5 * f64::from(side - 1)) * cell;
        let position = DVec3::new(at(i % side), 3.0, at(i / side));
        if position.x.hypot(position.z) <= 9.0 {
            let patch = light(position, -DVec3::Y, Emission::Oriented);
            sum +=
                radiance(&white, &Light { intensity: DVec3::splat(cell * cell), ..patch }, CLAMP_M);
        }
    }
    assert!((sum - 0.9).abs().max_element() < 1e-3, "{sum}");
}

fn world(lights: Vec<Light>, point: Point) -> World {
    let eye = Eye {
        position: DVec3::ZERO,
        forward: DVec3::X,
        right: DVec3::Z,
        up: DVec3::Y,
        perspective: true,
    };
    World {
        origin: DVec3::ZERO,
        lights,
        frames: vec![Frame { width: 1, height: 1, eye, points: vec![point] }],
        clamp_m: CLAMP_M,
        occluders: None,
    }
}

#[test]
fn what_is_no_light_and_no_point_is_refused_by_name() {
    let good = light(DVec3::Y, DVec3::Y, Emission::Omni);
    assert!(world(vec![good, good], point()).check().is_ok());
    let bad = |light: Light, expected: &str| {
        let error = world(vec![good, light], point()).check().unwrap_err().to_string();
        assert!(error.contains("light 1") && error.contains(expected), "{error}");
    };
    for number in [f64::NAN, f64::INFINITY] {
        bad(Light { position: DVec3::new(0.0, number, 0.0), ..good }, "finite");
        bad(Light { axis: DVec3::new(0.0, number, 0.0), ..good }, "finite");
        bad(Light { intensity: DVec3::new(0.0, number, 0.0), ..good }, "finite");
        bad(Light { emission: Emission::Spot { half_angle_rad: number }, ..good }, "half angle");
    }
    bad(Light { position: DVec3::splat(1e10), ..good }, "coordinate");
    bad(Light { intensity: DVec3::splat(1e30), ..good }, "above");
    bad(Light { intensity: DVec3::new(0.0, -1.0, 0.0), ..good }, "negative");
    bad(Light { axis: 2.0 * DVec3::Y, emission: Emission::Oriented, ..good }, "unit");
    bad(Light { emission: Emission::Spot { half_angle_rad: 0.0 }, ..good }, "half angle");
    let bad = |point: Point, expected: &str| {
        let error = world(vec![good], point).check().unwrap_err().to_string();
        assert!(error.contains("pixel 0") && error.contains(expected), "{error}");
    };
    bad(Point { position: Vec3::splat(f32::NAN), ..point() }, "finite");
    bad(Point { position: Vec3::splat(1e20), ..point() }, "coordinate");
    bad(Point { normal: Vec3::splat(f32::NAN), ..point() }, "finite");
    bad(Point { normal: 1.0001 * Vec3::Y, ..point() }, "unit");
    bad(Point { albedo: Vec3::splat(1.5), ..point() }, "albedo");
    bad(Point { albedo: Vec3::splat(f32::NAN), ..point() }, "albedo");
    for clamp_m in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-7] {
        let error =
            World { clamp_m, ..world(vec![good], point()) }.check().unwrap_err().to_string();
        assert!(error.contains("clamp"), "{error}");
    }
}
