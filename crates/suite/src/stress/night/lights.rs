//! Extremes of what shines from where.

use super::{
    Posed,
    made::{WALK, street},
};
use crate::{
    SuiteError,
    case::Case,
    stress::{Axis, Values},
};
use dapple_scene::city::{City, windows::OUTSIDE_M};
use glam::{DVec3, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// The axes, each pushed alone.
pub fn axes(posed: Posed) -> Vec<Axis> {
    vec![lamps(posed), outside(posed), inside(posed), below(posed), dark(posed), range(posed)]
}

const SHARES: Values = Values::Linear { least: 0.0, greatest: 1.0, steps: 4 };

fn lamps(posed: Posed) -> Axis {
    Axis {
        unit: "lamps",
        ..posed.axis(
            "lamps",
            "street lamps strewn over the city, in buildings too, whose intensities have one sum",
            Values::Whole { least: 0, greatest: 10_000, per_decade: 1 },
            100.0,
            posed.made(|value, case| {
                let mut made = street(&WALK);
                let mut rng = Pcg64::seed_from_u64(case.seed);
                let intensity = Vec3::splat((2000.0 / value.max(1.0)) as f32);
                for _ in 0..value as u32 {
                    let mut within = |low: f64, high: f64| rng.random_range(low..high);
                    let place =
                        DVec3::new(within(-40.0, 40.0), within(0.1, 12.0), within(-40.0, 50.0));
                    made.lamp(place, intensity);
                }
                made.city(case.seed)
            }),
        )
    }
}

/// The street with its lights changed; what is random takes the seed.
fn changed(
    case: &Case,
    mut change: impl FnMut(&mut dapple_scene::city::WindowLight, f64),
) -> Result<City, SuiteError> {
    let mut city = street(&WALK).city(case.seed)?;
    let mut rng = Pcg64::seed_from_u64(case.seed ^ 0x6c69_6768_7473);
    for light in &mut city.lights {
        change(light, rng.random());
    }
    Ok(city)
}

fn outside(posed: Posed) -> Axis {
    Axis {
        unit: "m",
        ..posed.axis(
            "outside",
            "distance of windows' lights from their walls, from on them to far in the street",
            Values::FromZero { least: 1e-9, greatest: 10.0, per_decade: 1 },
            OUTSIDE_M,
            posed.made(|value, case| {
                changed(case, |light, _| {
                    light.position += light.direction * (value - OUTSIDE_M);
                })
            }),
        )
    }
}

fn inside(posed: Posed) -> Axis {
    posed.axis(
        "inside",
        "share of lights that shine inside their buildings, at most 5 m deep: none of them is seen",
        SHARES,
        0.0,
        posed.made(|value, case| {
            changed(case, |light, draw| {
                if draw < value {
                    light.position -= light.direction * (0.1 + 5.0 * draw);
                }
            })
        }),
    )
}

fn below(posed: Posed) -> Axis {
    posed.axis(
        "below-ground",
        "share of lights that are below the ground, as deep as they were high",
        Values::Linear { least: 0.0, greatest: 0.8, steps: 4 },
        0.0,
        posed.made(|value, case| {
            changed(case, |light, draw| {
                if draw < value {
                    light.position.y = -light.position.y;
                }
            })
        }),
    )
}

fn dark(posed: Posed) -> Axis {
    posed.axis(
        "dark-lights",
        "share of lights whose intensity is 0",
        Values::Linear { least: 0.0, greatest: 0.9, steps: 3 },
        0.0,
        posed.made(|value, case| {
            changed(case, |light, draw| {
                if draw < value {
                    light.intensity = Vec3::ZERO;
                }
            })
        }),
    )
}

fn range(posed: Posed) -> Axis {
    posed.axis(
        "brightness-range",
        "the strongest light over the weakest, evenly spread in the logarithm",
        Values::Log { least: 1.0, greatest: 1e12, per_decade: 1 },
        10.0,
        posed.made(|value, case| {
            changed(case, |light, draw| light.intensity *= value.powf(0.5 - draw) as f32)
        }),
    )
}
