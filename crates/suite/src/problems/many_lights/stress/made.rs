//! Worlds that axes start from: random lights between walls, and what is done to them.

use super::super::input::{Hierarchy, Input};
use dapple_many_lights::{
    Emission, Light,
    sample::Random,
    worlds::{self, Cloud, Made, WINDOW},
};
use glam::DVec3;

/// Lights where their number is not pushed.
pub const LIGHTS: u32 = 200;

/// Lights and surfaces as axes push them; without a hierarchy, and not yet completed.
pub fn input(made: Made) -> Input {
    let Made { world, mut scene } = made;
    // Adds cameras and a path; a scene that is none is refused where it is validated.
    if scene.validate().is_ok() {
        let _ = scene.add_defaults();
    }
    Input {
        scene,
        lights: world.lights,
        origin: world.origin,
        hierarchy: Hierarchy::None,
        hash: String::new(),
        notes: Vec::new(),
    }
}

/// So many random lights of all kinds but directional ones; their intensities have the same sum,
/// however many they are.
pub fn cloud(lights: u32, seed: u64) -> Input {
    let emissions = vec![Emission::Omni, Emission::Oriented, WINDOW];
    input(worlds::cloud(&Cloud { lights, emissions, seed: seed as u32, ..Cloud::default() }))
}

/// [`LIGHTS`] lights with a share of them changed, chosen by chance: the same ones and more for a
/// larger share.
pub fn with_share(share: f64, seed: u64, change: impl Fn(&mut Light)) -> Input {
    let mut input = cloud(LIGHTS, seed);
    for (index, light) in (0..).zip(&mut input.lights) {
        // A draw is less than 1.
        if f64::from(Random::new(seed as u32, 1, index).unit()) < share {
            change(light);
        }
    }
    input
}

/// [`LIGHTS`] lights, each changed.
pub fn with_each(seed: u64, mut change: impl FnMut(u32, &mut Light)) -> Input {
    let mut input = cloud(LIGHTS, seed);
    for (index, light) in (0..).zip(&mut input.lights) {
        change(index, light);
    }
    input
}

/// A direction within `spread_rad` of straight down, of even density on the sphere.
pub fn downwards(spread_rad: f64, random: &mut Random) -> DVec3 {
    // 1 - cos, without the cancellation that would make small spreads none.
    let deep = 2.0 * (0.5 * spread_rad).sin().powi(2) * f64::from(random.unit());
    let turn = std::f64::consts::TAU * f64::from(random.unit());
    let wide = (deep * (2.0 - deep)).max(0.0).sqrt();
    DVec3::new(wide * turn.cos(), deep - 1.0, wide * turn.sin()).normalize_or(DVec3::NEG_Y)
}
