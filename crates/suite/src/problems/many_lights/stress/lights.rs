//! Extremes of what lights are: how many, how strong, how they emit.

use super::{LightsCase, USUAL, made, made::LIGHTS, of_input};
use crate::{
    problems::many_lights::input::Input,
    stress::{Axis, Criterion, Prepare, Values, settings::position},
};
use dapple_many_lights::{Emission, sample::Random};
use glam::DVec3;
use std::f64::consts::PI;

/// The axes, each pushed alone.
pub fn axes() -> Vec<Axis> {
    vec![
        lights(),
        a_million(),
        dark(),
        brightness(),
        half_angle(),
        axis_spread(),
        opposite(),
        emission(),
        colours(),
    ]
}

const SHARES: Values = Values::Linear { least: 0.0, greatest: 1.0, steps: 4 };

fn lights() -> Axis {
    Axis {
        unit: "lights",
        ..of_input(
            "lights",
            "random lights whose intensities have one sum, from none to thousands: a fixed most number \
             and what reaches nowhere alone leave out more and more",
            Values::Whole { least: 0, greatest: 10_000, per_decade: 1 },
            f64::from(LIGHTS),
            super::made(|value, case| made::cloud(value as u32, case.seed)),
        )
    }
}

/// A million lights are added up at few places.
const FEW_PLACES: &[(&str, &str)] = &[("width", "12"), ("frames", "1"), ("truth_pixels", "32")];

/// Not refined: a point takes seconds.
const COUNTS: [&str; 4] = ["1000", "10000", "100000", "1000000"];

fn a_million() -> Axis {
    Axis {
        unit: "lights",
        parameters: FEW_PLACES,
        // The worst of few pixels: next to one of a million lights there may be any of them.
        criterion: Criterion { metric: "rmse", times: 6.0, plus: 2.0 / 255.0 },
        ..of_input(
            "a-million",
            "random lights whose intensities have one sum, up to a million",
            Values::Words(&COUNTS),
            0.0,
            super::made(|value, case| {
                made::cloud(10_u32.pow(3 + position(value) as u32), case.seed)
            }),
        )
    }
}

fn dark() -> Axis {
    of_input(
        "dark-lights",
        "share of lights whose intensity is 0: they add nothing, and bounds, trees and draws must not \
         stumble over them",
        SHARES,
        0.0,
        super::made(|value, case| {
            made::with_share(value, case.seed, |light| light.intensity = DVec3::ZERO)
        }),
    )
}

fn brightness() -> Axis {
    of_input(
        "brightness-range",
        "the strongest light over the weakest, evenly spread in the logarithm; their sum stays",
        Values::Log { least: 1.0, greatest: 1e12, per_decade: 1 },
        100.0,
        super::made(|value, case| ranged(value, case.seed)),
    )
}

/// Lights whose strength spans that range.
pub(super) fn ranged(range: f64, seed: u64) -> Input {
    let mut sum = 0.0;
    let mut input = made::with_each(seed, |index, light| {
        sum += light.luminance();
        let share = f64::from(Random::new(seed as u32, 2, index).unit());
        light.intensity *= range.powf(-share) / light.luminance();
    });
    let now: f64 = input.lights.iter().map(|light| light.luminance()).sum();
    for light in &mut input.lights {
        light.intensity *= sum / now;
    }
    input
}

fn half_angle() -> Axis {
    Axis {
        unit: "degrees",
        ..of_input(
            "half-angle",
            "half angle of the cones of spot lights that hang over the ground, from needles to all \
             directions; no pixel may be lit by the narrowest",
            Values::Log { least: 1e-4, greatest: 180.0, per_decade: 1 },
            45.0,
            super::made(|value, case| {
                let half_angle_rad = value.to_radians().min(PI);
                made::with_each(case.seed, |index, light| {
                    light.emission = Emission::Spot { half_angle_rad };
                    let mut random = Random::new(case.seed as u32, 3, index);
                    light.axis = made::downwards(0.5, &mut random);
                })
            }),
        )
    }
}

fn axis_spread() -> Axis {
    Axis {
        unit: "degrees",
        ..of_input(
            "axis-spread",
            "by how much axes of patches of light deviate from straight down, from all alike to any \
             direction: clusters' cones of axes",
            Values::Linear { least: 0.0, greatest: 180.0, steps: 8 },
            45.0,
            super::made(|value, case| {
                made::with_each(case.seed, |index, light| {
                    light.emission = Emission::Oriented;
                    let mut random = Random::new(case.seed as u32, 4, index);
                    light.axis = made::downwards(value.to_radians(), &mut random);
                })
            }),
        )
    }
}

fn opposite() -> Axis {
    of_input(
        "opposite-axes",
        "share of lights that stand in one place with another that shines the other way: axes of a \
         cluster cancel",
        SHARES,
        0.0,
        super::made(|value, case| opposed(value, case.seed)),
    )
}

/// That share of the lights in pairs, back to back.
pub(super) fn opposed(share: f64, seed: u64) -> Input {
    let mut input = made::cloud(LIGHTS, seed);
    let paired = (share * f64::from(LIGHTS)) as usize;
    let (pairs, _) = input.lights[..paired].as_chunks_mut::<2>();
    for [one, other] in pairs {
        *other = *one;
        other.axis = -one.axis;
    }
    input
}

fn emission() -> Axis {
    const KINDS: [&str; 5] = ["scene", "omni", "oriented", "spot", "directional"];
    let prepare: Prepare = Box::new(|case, value, gpu| {
        let mut case = super::first_view(case);
        let kind = KINDS.get(position(value)).unwrap_or(&KINDS[0]);
        case.scene = "light_cloud".into();
        case.parameters.insert("emission".into(), (*kind).into());
        case.parameters.insert("lights".into(), LIGHTS.into());
        Ok(Box::new(LightsCase::prepare(&case, gpu)?))
    });
    Axis {
        // What is drawn by chance is as hard as the kind: parallel light has no near lights.
        criterion: Criterion { times: 5.0, ..USUAL.criterion },
        ..of_input(
            "emission",
            "how lights emit: three kinds side by side, or all alike",
            Values::Words(&KINDS),
            0.0,
            prepare,
        )
    }
}

fn colours() -> Axis {
    of_input(
        "one-colour",
        "share of lights of which the strongest channel alone is left: what luminance says little of \
         counts as much",
        SHARES,
        0.0,
        super::made(|value, case| {
            made::with_share(value, case.seed, |light| {
                let (at, most) = (light.intensity.max_position(), light.intensity.max_element());
                light.intensity = DVec3::ZERO;
                light.intensity[at] = most;
            })
        }),
    )
}
