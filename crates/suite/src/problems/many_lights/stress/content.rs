//! Extremes of what there is at all.

use super::{lights, made, made::LIGHTS, of_input};
use crate::{
    problems::many_lights::input::Input,
    stress::{
        Axis, Values, edit,
        settings::{position, words},
    },
};
use dapple_many_lights::{Emission, worlds};
use glam::DVec3;

/// A word, and what there is.
type Content = (&'static str, fn(u64) -> Input);

const CONTENTS: &[Content] = &[
    ("as-it-is", |seed| made::cloud(LIGHTS, seed)),
    ("no-light", |seed| made::cloud(0, seed)),
    ("one-light", |seed| made::cloud(1, seed)),
    ("two-lights", |seed| made::cloud(2, seed)),
    ("all-dark", |seed| made::with_each(seed, |_, light| light.intensity = DVec3::ZERO)),
    ("one-place", |seed| made::with_each(seed, |_, light| light.position = DVec3::Y)),
    ("back-to-back-in-one-place", |seed| {
        let mut input = lights::opposed(1.0, seed);
        for light in &mut input.lights {
            light.position = DVec3::new(0.0, 3.0, 1.0);
        }
        input
    }),
    ("one-line", |seed| {
        made::with_each(seed, |_, light| light.position = DVec3::new(light.position.x, 3.0, 0.0))
    }),
    ("sun-and-lamps", |seed| {
        made::with_each(seed, |index, light| {
            if index == 0 {
                light.emission = Emission::Directional;
                light.axis = DVec3::new(0.0, -0.8, -0.6);
                light.intensity = DVec3::ONE;
            }
        })
    }),
    ("one-square", |seed| {
        made::input(worlds::plane(made::cloud(LIGHTS, seed).lights, 10.0, [8, 8]))
    }),
    ("empty-view", |seed| {
        let mut input = made::cloud(LIGHTS, seed);
        input.scene = edit::seen_from_behind(input.scene);
        input
    }),
    ("nothing", |seed| {
        let mut input = made::cloud(LIGHTS, seed);
        input.scene = edit::without_triangles(input.scene);
        input
    }),
];

/// The first of [`CONTENTS`] that must be refused.
const EMPTY_VIEW: usize = CONTENTS.len() - 2;

const CONTENT_WORDS: [&str; CONTENTS.len()] = words(CONTENTS);

/// The axis.
pub fn content() -> Axis {
    Axis {
        must_refuse: |value| position(value) >= EMPTY_VIEW,
        ..of_input(
            "content",
            "random lights between walls; none, one or two of them; all dark, in one place, back to \
             back there, on a line; a sun among lamps; one square of ground; a camera that sees \
             nothing, and nothing at all, which must be refused",
            Values::Words(&CONTENT_WORDS),
            0.0,
            super::made(|value, case| {
                let (_, make) = CONTENTS.get(position(value)).unwrap_or(&CONTENTS[0]);
                make(case.seed)
            }),
        )
    }
}
