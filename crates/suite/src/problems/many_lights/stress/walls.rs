//! Extremes of what hides lights by a hair: shadow rays start and end close to surfaces.

use super::{USUAL, made, of_input};
use crate::{
    problems::many_lights::input::Input,
    stress::{Axis, Prepare, Values, settings::Usual},
};
use dapple_many_lights::{Emission, sample::Random};
use glam::DVec3;

/// The axes, each pushed alone.
pub fn axes() -> Vec<Axis> {
    vec![behind_a_wall(), before_a_wall(), shadows()]
}

/// With shadow rays.
const SHADOWS: Usual = Usual {
    parameters: &[("width", "24"), ("frames", "2"), ("truth_pixels", "512"), ("visibility", "on")],
    ..USUAL
};

/// Shadow rays end 5e-6 m before a light 20 m from the middle of the scene, for the rounding of points
/// to single precision: nearer lights leak, in the truth too.
const GAPS: Values = Values::Log { least: 1e-5, greatest: 1.0, per_decade: 1 };

/// Where the wall at the back of the cloud stands, metres along z; it has no thickness.
const WALL_Z_M: f64 = -20.0;

/// Lights at that distance from the wall: before it, or behind it for less than 0.
pub(super) fn at_the_wall(distance_m: f64, seed: u64) -> Input {
    made::with_each(seed, |index, light| {
        let mut random = Random::new(seed as u32, 5, index);
        let mut within = |from: f64, to: f64| from + (to - from) * f64::from(random.unit());
        light.position = DVec3::new(within(-15.0, 15.0), within(1.0, 5.0), WALL_Z_M + distance_m);
        light.emission = Emission::Omni;
    })
}

fn wall(id: &'static str, help: &'static str, prepare: Prepare) -> Axis {
    let prepared = of_input(id, help, GAPS, 0.1, prepare);
    Axis { unit: "m", parameters: SHADOWS.parameters, ..prepared }
}

fn behind_a_wall() -> Axis {
    wall(
        "behind-a-wall",
        "distance of all lights behind a wall of no thickness that hides them from all that shows: \
         any light is a leak",
        super::made(|value, case| at_the_wall(-value, case.seed)),
    )
}

fn before_a_wall() -> Axis {
    wall(
        "before-a-wall",
        "distance of all lights before a wall of no thickness, which must not hide them, as windows \
         stand before facades",
        super::made(|value, case| at_the_wall(value, case.seed)),
    )
}

fn shadows() -> Axis {
    Axis {
        parameters: SHADOWS.parameters,
        ..SHADOWS.of_parameter(
            "visibility",
            "visibility",
            "whether the scene casts shadows: what clusters give is then known by one ray each",
            Values::Words(&["off", "on"]),
            0.0,
        )
    }
}
