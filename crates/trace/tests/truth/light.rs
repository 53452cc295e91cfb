//! Light visibility against half planes, discs and cones.

use crate::shapes::{level_patch, mesh, placed, scene};
use dapple_scene::Light;
use dapple_trace::{Ray, Tracer, light_visibility, light_visibility_all, surface_light_visibility};
use glam::{DAffine3, DVec3, Vec3};
use std::f64::consts::{PI, TAU};

fn area(height: f64) -> Light {
    Light::Area { centre: DVec3::Y * height, half_u: DVec3::X, half_v: DVec3::Z }
}

#[test]
fn a_half_plane_casts_a_linear_penumbra() {
    // Occluder at half height over x < 0.1: from (px, 0, 0) the light beyond x = 0.2 - px is seen.
    let scene = placed(level_patch([-50.0, 0.1], 5.0, [-50.0, 50.0], 2));
    let tracer = Tracer::build(&scene).unwrap();
    let mut partial = 0;
    for i in -20..=20 {
        let px = 0.1 * f64::from(i);
        let expected = (0.5 * (1.0 - (0.2 - px))).clamp(0.0, 1.0);
        let point = DVec3::new(px, 0.0, 0.0);
        let got = light_visibility(&tracer, point, DVec3::Y, &area(10.0), 1024, 4);
        // 32 samples straddle the edge, each worth 1/1024: 4 sigma is 4 * sqrt(32 / 4) / 1024.
        assert!((got - expected).abs() < 0.0111, "{px}: {got} {expected}");
        if expected == 0.0 || expected == 1.0 {
            assert_eq!(got, expected, "{px}");
        } else {
            partial += 1;
        }
    }
    assert!(partial >= 18, "{partial}");
}

#[test]
fn a_disc_hides_its_projected_area() {
    let sides = 200_u32;
    let radius = 0.4;
    let mut positions = vec![Vec3::new(0.0, 5.0, 0.0)];
    positions.extend((0..sides).map(|i| {
        let (s, c) = (TAU * f64::from(i) / f64::from(sides)).sin_cos();
        Vec3::new((radius * c) as f32, 5.0, (radius * s) as f32)
    }));
    let fan = (0..sides).map(|i| [0, 1 + i, 1 + (i + 1) % sides]).collect();
    let tracer = Tracer::build(&placed(mesh(positions, fan))).unwrap();
    // Seen from below it covers a disc of twice the radius of the light's 2 × 2.
    let expected = 1.0 - PI * (2.0 * radius) * (2.0 * radius) / 4.0;
    let got = light_visibility(&tracer, DVec3::ZERO, DVec3::Y, &area(10.0), 4096, 1);
    assert!((got - expected).abs() < 0.005, "{got} {expected}");
    let other = light_visibility(&tracer, DVec3::ZERO, DVec3::Y, &area(10.0), 4096, 2);
    assert!(got != other, "the seed matters");
    assert_eq!(got, light_visibility(&tracer, DVec3::ZERO, DVec3::Y, &area(10.0), 4096, 1));
}

#[test]
fn what_faces_away_is_dark() {
    let tracer = Tracer::build(&scene(vec![])).unwrap();
    let lights = [
        Light::Directional { direction: DVec3::new(0.1, -1.0, 0.0) },
        Light::Spot { position: DVec3::Y, direction: DVec3::NEG_Y, half_angle_rad: 0.3 },
        area(3.0),
    ];
    for light in lights {
        let at = |normal| light_visibility(&tracer, DVec3::ZERO, normal, &light, 16, 0);
        assert_eq!((at(DVec3::Y), at(DVec3::NEG_Y)), (1.0, 0.0), "{light:?}");
        assert_eq!(at(DVec3::NAN), 0.0);
    }
    let sun = Light::Directional { direction: DVec3::NEG_Y };
    assert_eq!(light_visibility(&tracer, DVec3::ZERO, DVec3::X, &sun, 1, 0), 0.0, "grazing");
    let none = Light::Directional { direction: DVec3::ZERO };
    assert_eq!(light_visibility(&tracer, DVec3::ZERO, DVec3::Y, &none, 1, 0), 0.0);
}

#[test]
fn a_spot_lights_its_cone_alone() {
    let tracer = Tracer::build(&scene(vec![])).unwrap();
    let spot = Light::Spot {
        position: DVec3::Y * 2.0,
        direction: DVec3::NEG_Y * 3.0,
        half_angle_rad: 0.5_f64.atan(),
    };
    for (x, lit) in [(0.0, 1.0), (0.999, 1.0), (1.001, 0.0), (-0.999, 1.0), (-1.001, 0.0)] {
        let point = DVec3::new(x, 0.0, 0.0);
        assert_eq!(light_visibility(&tracer, point, DVec3::Y, &spot, 1, 0), lit, "{x}");
    }
}

#[test]
fn an_occluder_beyond_the_light_does_not_count() {
    let tracer = Tracer::build(&placed(level_patch([-1.0, 1.0], 2.5, [-1.0, 1.0], 1))).unwrap();
    let at = |y: f64| Light::Spot {
        position: DVec3::new(0.1, y, 0.0),
        direction: DVec3::NEG_Y,
        half_angle_rad: 1.0,
    };
    let lit = |y| light_visibility(&tracer, DVec3::ZERO, DVec3::Y, &at(y), 1, 0);
    assert_eq!((lit(2.4), lit(2.6)), (1.0, 0.0));
}

#[test]
fn a_surface_does_not_shadow_itself_at_any_scale_or_offset() {
    let mut tried = 0;
    for scale in [1e-6, 1.0, 1e6] {
        for offset in [0.0, 1e7] {
            let transform = DAffine3::from_scale_rotation_translation(
                DVec3::splat(scale),
                glam::DQuat::from_rotation_z(0.6),
                DVec3::splat(offset),
            );
            let plane = level_patch([-1.0, 1.0], 0.0, [-1.0, 1.0], 10);
            let tracer = Tracer::build(&scene(vec![(plane, transform)])).unwrap();
            let normal = transform.transform_vector3(DVec3::Y).normalize();
            let sun =
                Light::Directional { direction: -(normal + transform.x_axis.normalize() * 3.0) };
            let mut receivers = Vec::new();
            for i in 0..400 {
                let (x, z) = (f64::from(i % 20) * 0.09 - 0.87, f64::from(i / 20) * 0.09 - 0.87);
                let target = transform.transform_point3(DVec3::new(x, 0.0, z));
                let ray = Ray::new(target + normal * scale, -normal);
                let Some(hit) = tracer.closest(&ray) else { continue };
                receivers.push(Some(tracer.surface(&ray, &hit)));
            }
            // At an offset of 1e7 the small plane is rounded to a staircase of 2e-9 m, no plane.
            let flat = offset == 0.0 || scale > 1e-3;
            if flat {
                let values = light_visibility_all(&tracer, &receivers, &sun, 1, 0);
                assert_eq!(values, vec![1.0; receivers.len()], "{scale:e} {offset:e}");
                tried += values.len();
            }
        }
    }
    assert!(tried >= 5 * 400, "{tried}");
}

#[test]
fn the_own_triangle_is_skipped_and_others_are_not() {
    let plane = level_patch([-1.0, 1.0], 0.0, [-1.0, 1.0], 1);
    let roof = level_patch([-1.0, 1.0], 1.0, [-1.0, 1.0], 1);
    let id = DAffine3::IDENTITY;
    let tracer = Tracer::build(&scene(vec![(plane, id), (roof, id)])).unwrap();
    let ray = Ray::new(DVec3::new(0.3, 0.5, 0.1), DVec3::NEG_Y);
    let hit = tracer.closest(&ray).unwrap();
    let surface = tracer.surface(&ray, &hit);
    let sun = Light::Directional { direction: DVec3::NEG_Y };
    assert_eq!(surface_light_visibility(&tracer, &surface, &sun, 1, 0), 0.0);
    assert!(tracer.any_except(&ray, None) && !tracer.any_except(&ray, Some(hit.triangle)));
}
