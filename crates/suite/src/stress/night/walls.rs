//! Extremes of what stands where: occluders that touch a cell, overlap it, hold it, or have no size.

use super::{
    Posed,
    made::{HOUSES, LOT, Made, WALK, others, street},
};
use crate::{
    SuiteError,
    case::Case,
    stress::{Axis, Values},
};
use dapple_scene::city::City;
use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// The axes, each pushed alone.
pub fn axes(posed: Posed) -> Vec<Axis> {
    let size = |id, help, make| {
        let from_zero = Values::FromZero { least: 1e-6, greatest: 30.0, per_decade: 1 };
        Axis { unit: "m", ..posed.axis(id, help, from_zero, 3.0, posed.made(make)) }
    };
    vec![
        wall_gap(posed),
        size(
            "wall-width",
            "width along the street of a wall in front of a row of houses, from none",
            |value, case| with_wall(DVec3::new(value, 7.0, 2.0), 1.0, case),
        ),
        size(
            "wall-height",
            "height of a wall in front of a row of houses, from none",
            |value, case| with_wall(DVec3::new(8.0, value, 2.0), 1.0, case),
        ),
        size(
            "wall-depth",
            "depth of a wall in front of a row of houses, from none",
            |value, case| with_wall(DVec3::new(8.0, 7.0, value), 1.0, case),
        ),
        cell_size(posed),
        roof_step(posed),
        facade_step(posed),
        slit(posed),
        foot(posed),
        buildings(posed),
    ]
}

/// The street with a dark box before the row that is looked at, so far from it.
pub fn with_wall(size: DVec3, gap_m: f64, case: &Case) -> Result<City, SuiteError> {
    let mut made = street(&WALK);
    let min = DVec3::new(-6.0, 0.0, gap_m);
    made.wall(min, min + size);
    made.city(case.seed)
}

fn wall_gap(posed: Posed) -> Axis {
    Axis {
        unit: "m",
        ..posed.axis(
            "wall-gap",
            "distance of a wall from the houses behind it: it touches them at 0, stands partly in them \
             below, and behind their facades in the end",
            Values::Linear { least: -12.0, greatest: 4.0, steps: 8 },
            2.0,
            posed.made(|value, case| with_wall(DVec3::new(8.0, 7.0, 2.0), value, case)),
        )
    }
}

fn cell_size(posed: Posed) -> Axis {
    Axis {
        unit: "m",
        ..posed.axis(
            "house-size",
            "all sides of houses in the row that is looked at times this over 10 m: cells without size \
             in the end",
            Values::FromZero { least: 1e-3, greatest: 10.0, per_decade: 1 },
            10.0,
            posed.made(|value, case| {
                let mut made = others(&WALK);
                let size = 0.1 * value;
                let [width, depth, gap] = LOT;
                let lot = [width * size, depth * size, gap + width * (1.0 - size)];
                let houses = HOUSES.map(|[height, _]| [height * size, depth * (size - 1.0)]);
                made.row(DVec3::new(-20.0, 0.0, -10.0), lot, &houses);
                made.city(case.seed)
            }),
        )
    }
}

fn roof_step(posed: Posed) -> Axis {
    Axis {
        unit: "m",
        ..posed.axis(
            "roof-step",
            "by how much every second house of all rows is higher than the others: at 0 all roofs are in \
             one plane, as high as cells, lights and the camera that looks along them",
            Values::FromZero { least: 1e-9, greatest: 10.0, per_decade: 1 },
            3.0,
            posed.made(|value, case| {
                let eye = DVec3::new(-30.0, 9.0, 6.0);
                let mut made =
                    Made::seen("roofs", &[[eye, DVec3::new(5.0, 9.0, 0.0)]; 2]).ground(60.0);
                let step = |i: u32| [9.0 + if i % 2 == 1 { value } else { 0.0 }, 0.0];
                for z in [-32.0, -10.0, 12.0, 34.0] {
                    made.row(DVec3::new(-20.0, 0.0, z), LOT, &[0, 1, 2, 3].map(step));
                }
                made.city(case.seed)
            }),
        )
    }
}

fn facade_step(posed: Posed) -> Axis {
    Axis {
        unit: "m",
        ..posed.axis(
            "facade-step",
            "by how much every second house of a row stands behind the others: coplanar facades and far \
             faces at 0",
            Values::FromZero { least: 1e-9, greatest: 10.0, per_decade: 1 },
            1.0,
            posed.made(|value, case| {
                let mut made = Made::seen("steps", &WALK).ground(60.0);
                let behind =
                    |i: usize| [HOUSES[i][0], if i % 2 == 1 { value } else { 0.0 }];
                for z in [-32.0, -10.0, 12.0, 34.0] {
                    let houses = [0, 1, 2, 3].map(behind);
                    made.row(DVec3::new(-20.0, 0.0, z), LOT, &houses);
                }
                made.city(case.seed)
            }),
        )
    }
}

fn slit(posed: Posed) -> Axis {
    Axis {
        unit: "m",
        ..posed.axis(
            "slit",
            "width of the gaps between the houses of all rows: at 0 they share walls, and their shadows \
             join",
            Values::FromZero { least: 1e-9, greatest: 10.0, per_decade: 1 },
            1.0,
            posed.made(|value, case| {
                let mut made = Made::seen("slits", &WALK).ground(80.0);
                let [width, depth, _] = LOT;
                for z in [-32.0, -10.0, 12.0, 34.0] {
                    made.row(DVec3::new(-20.0, 0.0, z), [width, depth, value], &HOUSES);
                }
                made.city(case.seed)
            }),
        )
    }
}

fn foot(posed: Posed) -> Axis {
    Axis {
        unit: "m",
        ..posed.axis(
            "foot",
            "height of the foot of a wall before a row of houses over the ground: light passes below",
            Values::FromZero { least: 1e-6, greatest: 30.0, per_decade: 1 },
            3.0,
            posed.made(|value, case| {
                let mut made = street(&WALK);
                let min = DVec3::new(-6.0, value, 1.0);
                made.wall(min, min + DVec3::new(8.0, 5.0, 2.0));
                made.city(case.seed)
            }),
        )
    }
}

fn buildings(posed: Posed) -> Axis {
    posed.axis(
        "buildings",
        "boxes strewn over the land, each as large as their number leaves room for, in each other too",
        Values::Whole { least: 1, greatest: 300, per_decade: 1 },
        16.0,
        posed.made(|value, case| {
            let high = DVec3::new(0.0, 40.0, 60.0);
            let mut made = Made::seen("boxes", &[[high, DVec3::ZERO]; 2]).ground(60.0);
            let mut rng = Pcg64::seed_from_u64(case.seed);
            let size = 60.0 / value.sqrt();
            for _ in 0..value as u32 {
                let min = DVec3::new(
                    rng.random_range(-40.0..40.0 - size),
                    0.0,
                    rng.random_range(-40.0..40.0 - size),
                );
                let mut side = || size * rng.random_range(0.3..1.0);
                let max = min + DVec3::new(side(), side().max(2.5), side());
                made.building(min, max, [false; 4]);
            }
            made.city(case.seed)
        }),
    )
}
