//! Worlds at the ends of what is allowed.

use super::input::EMISSIONS;
use dapple_many_lights::{
    Emission, Light, Point, World,
    worlds::{Cloud, WINDOW, cloud, plane},
};
use glam::{DVec3, Vec3};
use rand::RngExt;
use rand_pcg::Pcg64;

fn light(position: DVec3, intensity: f64, emission: Emission) -> Light {
    Light { position, axis: DVec3::NEG_Y, intensity: DVec3::splat(intensity), emission }
}

fn over(lights: Vec<Light>) -> World {
    plane(lights, 4.0, [9, 9]).world
}

/// Each with its name.
pub fn extremes(rng: &mut Pcg64) -> Vec<(&'static str, World)> {
    let emission = EMISSIONS[rng.random_range(0..EMISSIONS.len())];
    let above = DVec3::new(rng.random_range(-3.0..3.0), 2.0, rng.random_range(-3.0..3.0));
    let one = |at: DVec3| light(at, 1.0, emission);
    let mut worlds = vec![
        ("no light", over(vec![])),
        ("one light", over(vec![one(above)])),
        ("two lights", over(vec![one(above), one(above + DVec3::X)])),
        ("in one place", over(vec![light(above, 0.01, emission); 100])),
        ("without intensity", over(vec![light(above, 0.0, emission); 3])),
        ("behind", over(vec![one(-above)])),
        ("very bright", over(vec![light(above, 1e12, emission), one(above)])),
        ("very dim", over(vec![light(above, 1e-20, emission), light(above, 1e-30, emission)])),
    ];
    let at = over(vec![]).frames[0].points[rng.random_range(0..81)].position.as_dvec3();
    for (name, distance, clamp_m) in [
        ("at a point", 0.0, 0.1),
        ("at a point, clamped at 1e-6 m", 0.0, 1e-6),
        ("a micrometre away", 1e-6, 0.1),
        ("a micrometre away, clamped at 1e-6 m", 1e-6, 1e-6),
        ("clamped at 1 km", 1.0, 1e3),
    ] {
        let lights = EMISSIONS.map(|emission| light(at + DVec3::Y * distance, 1.0, emission));
        worlds.push((name, World { clamp_m, ..over(lights.to_vec()) }));
    }
    for half_angle_rad in [1e-3, std::f64::consts::FRAC_PI_4, std::f64::consts::PI] {
        let mut lights = vec![light(above, 1.0, Emission::Spot { half_angle_rad }); 4];
        lights[1].axis = DVec3::Y;
        lights[2].axis = DVec3::X;
        lights[3].axis = DVec3::NEG_X;
        worlds.push(("opposite axes", over(lights)));
    }
    for (name, scale) in [("1e-4 m", 1e-4), ("1e6 m", 1e6)] {
        let at = [above, above + DVec3::X, DVec3::new(-3.0, 1.0, 2.0)];
        let lights = at.map(|at| light(at * scale, scale * scale, emission)).to_vec();
        let clamp_m = (0.1 * scale).clamp(1e-6, 1e6);
        worlds.push((name, World { clamp_m, ..plane(lights, 4.0 * scale, [9, 9]).world }));
    }
    for (name, size) in [("one pixel", [1, 1]), ("a row", [33, 1]), ("no pixel", [0, 0])] {
        let emissions = EMISSIONS.to_vec();
        worlds
            .push((name, cloud(&Cloud { lights: 20, size, emissions, ..Cloud::default() }).world));
    }
    let mut nothing = over(vec![light(above, 1.0, WINDOW)]);
    nothing.frames[0].points.fill(Point::nothing());
    let mut black = over(vec![one(above)]);
    black.frames[0].points.iter_mut().for_each(|point| point.albedo = Vec3::ZERO);
    worlds.extend([("nothing shows", nothing), ("black surfaces", black)]);
    worlds
}
