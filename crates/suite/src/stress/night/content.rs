//! Extremes of what there is at all, and of where it is seen from.

use super::{
    Posed,
    made::{Made, WALK, street},
};
use crate::{
    SuiteError,
    stress::{
        Axis, Values,
        settings::{position, words},
    },
};
use dapple_scene::city::City;
use glam::{DVec3, Vec3};

/// The axes, each pushed alone.
pub fn axes(posed: Posed) -> Vec<Axis> {
    vec![content(posed), camera(posed)]
}

/// A word, and what there is.
type Content = (&'static str, fn(u64) -> Result<City, SuiteError>);

/// Those that give no light come before those that every problem must refuse.
const CONTENTS: &[Content] = &[
    ("as-it-is", |seed| street(&WALK).city(seed)),
    ("one-building", |seed| {
        let mut made = Made::seen("one", &WALK).ground(60.0);
        made.row(DVec3::new(-5.0, 0.0, -10.0), [10.0, 10.0, 0.0], &[[9.0, 0.0]]);
        made.lamp(DVec3::new(-5.0, 5.0, 10.0), Vec3::splat(200.0));
        made.city(seed)
    }),
    ("no-building", |seed| {
        let mut made = Made::seen("land", &WALK).ground(60.0);
        made.lamp(DVec3::new(-5.0, 5.0, 10.0), Vec3::splat(200.0));
        made.lamp(DVec3::new(5.0, 5.0, 10.0), Vec3::splat(200.0));
        made.city(seed)
    }),
    ("no-ground", |seed| {
        let mut city = street(&WALK).city(seed)?;
        city.grounds.clear();
        Ok(city)
    }),
    ("one-light", |seed| {
        let mut city = street(&WALK).city(seed)?;
        city.lights.clear();
        city.lamps = lamps(1);
        Ok(city)
    }),
    ("two-lights", |seed| {
        let mut city = street(&WALK).city(seed)?;
        city.lights.clear();
        city.lamps = lamps(2);
        Ok(city)
    }),
    ("one-place", |seed| {
        let mut city = street(&WALK).city(seed)?;
        city.lights.iter_mut().for_each(|light| light.position = DVec3::new(0.0, 4.0, 6.0));
        Ok(city)
    }),
    ("one-line", |seed| {
        let mut city = street(&WALK).city(seed)?;
        for light in &mut city.lights {
            light.position = DVec3::new(light.position.x, 4.0, 6.0);
        }
        Ok(city)
    }),
    ("twice", |seed| {
        let mut made = street(&WALK);
        // A second row in the very place of the first.
        made.row(DVec3::new(-20.0, 0.0, -10.0), super::made::LOT, &super::made::HOUSES);
        made.city(seed)
    }),
    ("all-dark", |seed| {
        let mut city = street(&WALK).city(seed)?;
        city.lights.iter_mut().for_each(|light| light.intensity = Vec3::ZERO);
        Ok(city)
    }),
    ("no-light", |seed| {
        let mut city = street(&WALK).city(seed)?;
        city.lights.clear();
        Ok(city)
    }),
    ("empty-view", |seed| {
        let up = [DVec3::new(0.0, 30.0, 0.0), DVec3::new(1.0, 60.0, 0.0)];
        street(&[up; 2]).city(seed)
    }),
    ("nothing", |seed| Made::seen("nothing", &WALK).city(seed)),
];
const CONTENT_WORDS: [&str; CONTENTS.len()] = words(CONTENTS);

fn lamps(count: u32) -> Vec<dapple_scene::city::StreetLamp> {
    let lamp = |i: u32| dapple_scene::city::StreetLamp {
        position: DVec3::new(-8.0 + 6.0 * f64::from(i), 5.0, 6.0),
        intensity: Vec3::splat(300.0),
    };
    (0..count).map(lamp).collect()
}

fn content(posed: Posed) -> Axis {
    Axis {
        must_refuse: match posed.refuses_dark {
            true => |value| position(value) >= CONTENTS.len() - 4,
            false => |value| position(value) >= CONTENTS.len() - 3,
        },
        ..posed.axis(
            "content",
            "four rows of houses; one house; none, on land under lamps; no land; one light, two; all in \
             one place, on a line; a row twice in one place; all dark; no light, a camera that sees \
             nothing, and nothing at all, which must be refused",
            Values::Words(&CONTENT_WORDS),
            0.0,
            posed.made(|value, case| {
                let (_, make) = CONTENTS.get(position(value)).unwrap_or(&CONTENTS[0]);
                make(case.seed)
            }),
        )
    }
}

/// A word, the eye's place and what it looks at.
type Place = (&'static str, [DVec3; 2]);

const PLACES: &[Place] = &[
    ("street", WALK[0]),
    ("above", [DVec3::new(0.5, 60.0, 5.0), DVec3::new(0.0, 0.0, 0.0)]),
    ("at-roof-height", [DVec3::new(-30.0, 9.0, 6.0), DVec3::new(0.0, 9.0, 0.0)]),
    ("on-the-ground", [DVec3::new(-12.0, 0.0, 6.0), DVec3::new(4.0, 4.0, 0.0)]),
    ("close-to-a-wall", [DVec3::new(-2.0, 3.0, 0.01), DVec3::new(6.0, 3.0, 0.0)]),
    ("in-a-wall", [DVec3::new(-2.0, 3.0, 0.0), DVec3::new(6.0, 3.0, 6.0)]),
    ("in-a-house", [DVec3::new(-5.0, 3.0, -5.0), DVec3::new(6.0, 3.0, 5.0)]),
    ("below-ground", [DVec3::new(-12.0, -5.0, 6.0), DVec3::new(4.0, 4.0, 0.0)]),
    ("far-away", [DVec3::new(-2e4, 2e3, 2e4), DVec3::ZERO]),
];
const PLACE_WORDS: [&str; PLACES.len()] = words(PLACES);

fn camera(posed: Posed) -> Axis {
    posed.axis(
        "camera",
        "where the camera is: in the street, above, at the height of roofs, close to a wall or in it, in \
         a house, below the ground, far away; what shows nothing that could be asked about is refused",
        Values::Words(&PLACE_WORDS),
        0.0,
        posed.made(|value, case| {
            let (_, place) = PLACES.get(position(value)).unwrap_or(&PLACES[0]);
            street(&[*place; 2]).city(case.seed)
        }),
    )
}
