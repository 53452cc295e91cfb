//! What tests of light lists share.
#![allow(dead_code, reason = "each test uses its part")]
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use dapple_many_lights::{
    Emission, Form, Light, LightTree, Point, Shaded, Technique, Work, World, make,
    worlds::{Cloud, WINDOW, cloud, plane},
};
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// A frame in a form without a device.
pub fn shaded(
    form: Form,
    technique: &Technique,
    world: &World,
    frame: usize,
    count: bool,
) -> Shaded {
    let tree = LightTree::median(&world.lights).unwrap();
    let mut lighting =
        make(form, technique, &Arc::new(world.clone()), &Arc::new(tree), None).unwrap();
    lighting.reset(1).unwrap();
    lighting.shade(frame, count).unwrap();
    let mut shaded = Shaded::default();
    lighting.read(&mut shaded).unwrap();
    assert!(lighting.shade(world.frames.len(), count).is_err());
    shaded
}

pub fn image(form: Form, technique: &Technique, world: &World, frame: usize) -> Vec<Vec3> {
    let quiet = shaded(form, technique, world, frame, false);
    assert_eq!(quiet.work, Work::default());
    assert_eq!(quiet.radiance.len(), world.frames[frame].points.len());
    quiet.radiance
}

pub fn work(form: Form, technique: &Technique, world: &World, frame: usize) -> Work {
    shaded(form, technique, world, frame, true).work
}

/// A sum of one's own at every pixel of a frame.
pub fn sums(world: &World, frame: usize, sum: impl Fn(&Point) -> DVec3) -> Vec<Vec3> {
    let one = |point: &Point| if point.is_there() { sum(point).as_vec3() } else { Vec3::ZERO };
    world.frames[frame].points.iter().map(one).collect()
}

/// Pixels that differ by more than a share of what is expected, and more than `least`.
pub fn close(
    found: &[Vec3],
    expected: &[Vec3],
    share: f32,
    least: f64,
) -> Vec<(usize, Vec3, Vec3)> {
    assert_eq!(found.len(), expected.len());
    let pairs = found.iter().zip(expected).enumerate();
    let away = |a: Vec3, b: Vec3| {
        let allowed = f64::from(share * b.max_element()) + least;
        // What is no number is away, too.
        !f64::from((a - b).abs().max_element()).le(&allowed)
    };
    pairs.filter(|(_, (a, b))| away(**a, **b)).map(|(i, (a, b))| (i, *a, *b)).collect()
}

fn omni(position: DVec3, intensity: f64) -> Light {
    let emission = Emission::Omni;
    Light { position, axis: DVec3::Y, intensity: DVec3::splat(intensity), emission }
}

/// Worlds at the ends of what is allowed, by name.
pub fn extremes() -> Vec<(&'static str, World)> {
    let over = |lights: Vec<Light>| plane(lights, 4.0, [9, 9]).world;
    let above = DVec3::Y * 2.0;
    let mut worlds = vec![
        ("no light", over(vec![])),
        ("one light", over(vec![omni(above, 1.0)])),
        ("two lights", over(vec![omni(above, 1.0), omni(above + DVec3::X, 2.0)])),
        ("in one place", over(vec![omni(above, 0.01); 200])),
        ("without intensity", over(vec![omni(above, 0.0); 3])),
        ("at a point", over(vec![omni(DVec3::ZERO, 1.0)])),
        ("behind", over(vec![omni(-above, 1.0)])),
        (
            "opposite axes",
            over(vec![
                Light { emission: WINDOW, axis: DVec3::NEG_Y, ..omni(above, 1.0) },
                Light { emission: WINDOW, ..omni(above, 1.0) },
            ]),
        ),
        (
            "directional alone",
            over(vec![Light {
                emission: Emission::Directional,
                axis: DVec3::NEG_Y,
                ..omni(above, 1.0)
            }]),
        ),
    ];
    for (name, scale) in [("small", 1e-4), ("large", 1e6)] {
        let lights = [above, above + DVec3::X, DVec3::new(-3.0, 1.0, 2.0)];
        let lights = lights.map(|p| omni(p * scale, scale * scale)).to_vec();
        let world = plane(lights, 4.0 * scale, [9, 9]).world;
        worlds.push((name, World { clamp_m: 0.1 * scale, ..world }));
    }
    let lone = |size| cloud(&Cloud { lights: 20, size, ..Cloud::default() }).world;
    worlds.extend([("one pixel", lone([1, 1])), ("a row", lone([33, 1])), ("none", lone([0, 0]))]);
    let mut nothing = lone([9, 7]);
    nothing.frames[0].points.fill(Point::nothing());
    worlds.push(("nothing shows", nothing));
    worlds
}
