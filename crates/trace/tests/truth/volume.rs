//! The march through voxels against exact chords.

use crate::shapes::{rng, unit_vector};
use dapple_trace::{Ball, Profile, Ray, TraceError, Voxels, optical_depth};
use glam::DVec3;
use rand::RngExt;

const BALL: Ball = Ball {
    centre: DVec3::new(3.0, -1.0, 2.0),
    radius: 1.5,
    extinction: 0.8,
    profile: Profile::Homogeneous,
};

fn rays_through(ball: &Ball, widest: f64, count: usize) -> Vec<Ray> {
    let mut rng = rng(6);
    let ray = |_| {
        let direction = unit_vector(&mut rng);
        let beside = direction.any_orthonormal_vector();
        let turned = beside * rng.random_range(0.0..widest) * ball.radius;
        Ray::new(ball.centre + turned - direction * 10.0, direction)
    };
    (0..count).map(ray).collect()
}

/// Root of the mean squared error over rays, relative to the depth through the middle.
fn march_error(balls: &[Ball], rays: &[Ray], along: u32) -> f64 {
    let grid = Voxels::of(balls, along).unwrap();
    let through = 2.0 * balls[0].radius * balls[0].extinction;
    let squares: f64 = rays
        .iter()
        .map(|ray| ((grid.optical_depth(ray) - optical_depth(balls, ray)) / through).powi(2))
        .sum();
    (squares / rays.len() as f64).sqrt()
}

#[test]
fn a_homogeneous_sphere_matches_its_chords_to_a_percent() {
    let rays = rays_through(&BALL, 0.9, 300);
    let grid = Voxels::of(&[BALL], 128).unwrap();
    for ray in &rays {
        let (got, expected) = (grid.optical_depth(ray), BALL.optical_depth(ray));
        assert!(expected > 0.5);
        assert!((got / expected - 1.0).abs() < 0.01, "{got} {expected}");
        // Light that reaches the middle of the chord.
        let (enter, leave) = BALL.chord(ray).unwrap();
        let middle = ray.at(0.5 * (enter + leave));
        let got = grid.transmittance(&[middle], ray.direction)[0];
        let expected = (-0.5 * expected).exp();
        assert!((got / expected - 1.0).abs() < 0.01, "{got} {expected}");
    }
    // The comparison can fail: an extinction wrong by three percent does.
    let wrong = Voxels::of(&[Ball { extinction: 0.8 * 1.03, ..BALL }], 128).unwrap();
    assert!(rays.iter().all(|r| wrong.optical_depth(r) / BALL.optical_depth(r) > 1.01));
}

#[test]
fn smaller_voxels_converge_at_first_order_and_soft_balls_at_second() {
    let order = |ball: Ball| {
        let rays = rays_through(&ball, 0.9, 400);
        let errors = [16, 32, 64, 128].map(|along| march_error(&[ball], &rays, along));
        assert!(errors.is_sorted_by(|a, b| a > b), "{errors:?}");
        ((errors[0] / errors[3]).log2() / 3.0, errors)
    };
    let (hard, errors) = order(BALL);
    assert!((1.0..2.1).contains(&hard), "order {hard}: {errors:?}");
    let (soft, errors) = order(Ball { profile: Profile::Soft, ..BALL });
    assert!((1.9..2.2).contains(&soft), "order {soft}: {errors:?}");
}

#[test]
fn a_cloud_of_overlapping_balls_is_marched_as_its_chords_say() {
    let mut rng = rng(8);
    let cloud: Vec<Ball> = (0..30)
        .map(|i| Ball {
            centre: unit_vector(&mut rng) * rng.random::<f64>(),
            radius: rng.random_range(0.2..0.5),
            extinction: rng.random_range(0.2..1.0),
            profile: if i % 2 == 0 { Profile::Soft } else { Profile::Homogeneous },
        })
        .collect();
    let grid = Voxels::of(&cloud, 128).unwrap();
    let (mut most, mut squares, mut deepest) = (0.0_f64, 0.0, 0.0_f64);
    for _ in 0..500 {
        let point = unit_vector(&mut rng) * rng.random::<f64>();
        let direction = unit_vector(&mut rng);
        let got = grid.transmittance(&[point], direction)[0];
        let expected = (-optical_depth(&cloud, &Ray::new(point, -direction))).exp();
        let error = (got - expected).abs();
        (most, squares) = (most.max(error), squares + error * error);
        deepest = deepest.max(1.0 - expected);
    }
    // Largest where a ray grazes a border.
    let root = (squares / 500.0_f64).sqrt();
    assert!(root < 0.004 && most < 0.03 && deepest > 0.5, "{root}, {most}, {deepest}");
}

#[test]
fn scale_does_not_matter() {
    let base = march_error(&[BALL], &rays_through(&BALL, 0.9, 100), 32);
    for scale in [1e-6, 1e6] {
        let ball = Ball {
            centre: BALL.centre * scale,
            radius: BALL.radius * scale,
            extinction: BALL.extinction / scale,
            ..BALL
        };
        let rays: Vec<Ray> = rays_through(&BALL, 0.9, 100)
            .into_iter()
            .map(|r| Ray::new(r.origin * scale, r.direction))
            .collect();
        let error = march_error(&[ball], &rays, 32);
        assert!((error / base - 1.0).abs() < 1e-3, "{scale}: {error} {base}");
    }
}

#[test]
fn grids_without_content_and_without_end() {
    let nothing = Voxels::of(&[], 8).unwrap();
    assert!(nothing.extinction.is_empty());
    let ray = Ray::new(DVec3::ZERO, DVec3::X);
    assert_eq!(nothing.optical_depth(&ray), 0.0);
    for along in [0, 100_000, u32::MAX] {
        let error = Voxels::of(&[BALL], along).unwrap_err();
        assert!(matches!(error, TraceError::Voxels { .. }), "{error}");
    }
    let bad = Ball { radius: f64::NAN, ..BALL };
    assert!(matches!(Voxels::of(&[BALL, bad], 8), Err(TraceError::Ball { ball: 1, .. })));
    let grid = Voxels::of(&[BALL], 8).unwrap();
    for direction in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
        assert_eq!(grid.transmittance(&[BALL.centre], direction), [1.0]);
        assert_eq!(optical_depth(&[BALL], &Ray::new(BALL.centre, direction)), 0.0);
    }
    assert_eq!(grid.transmittance(&[DVec3::NAN], DVec3::X), [1.0]);
}
