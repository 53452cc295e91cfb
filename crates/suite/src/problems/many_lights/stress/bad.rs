//! Input that must be refused, each kind with a good one beside it.

use super::{USUAL, made, made::LIGHTS, of_cloud, of_input};
use crate::stress::{
    Axis, Values,
    bad::{self, BadSetting, bad, vertices_and},
    settings::{Changes, position, typed, words},
    world::{Kind, changed},
};
use dapple_many_lights::{Emission, Light};
use glam::{DAffine3, DVec3, Vec3};

/// The axes, each pushed alone.
pub fn axes() -> Vec<Axis> {
    vec![bad_vertices(), bad_lights(), bad_parameters(), bad_settings()]
}

const DAMAGES: [Kind; 9] = vertices_and([
    ("placement", |mut scene, _| {
        scene.instances[0].transform = DAffine3::from_scale(DVec3::NAN);
        scene
    }),
    ("mesh", |mut scene, _| {
        scene.instances[0].mesh = 77;
        scene
    }),
    ("albedo", |mut scene, _| {
        scene.materials[0].albedo = Vec3::NAN;
        scene
    }),
]);
const DAMAGE_WORDS: [&str; DAMAGES.len()] = words(&DAMAGES);

fn bad_vertices() -> Axis {
    let help = "one coordinate of a vertex; an index past the last vertex; a placement; a mesh that \
                is not there; a reflectance that is no number: each must be refused by name";
    Axis {
        prepare: super::made(|value, case| {
            let mut input = made::cloud(LIGHTS, case.seed);
            input.scene = changed(&DAMAGES, input.scene, value, case.seed);
            input
        }),
        ..bad::bad_vertices(USUAL, help, &DAMAGE_WORDS)
    }
}

/// What happens to light 3.
type BadLight = (&'static str, fn(&mut Light));

const BAD_LIGHTS: &[BadLight] = &[
    ("good", |_| {}),
    ("place-nan", |light| light.position.y = f64::NAN),
    ("place-inf", |light| light.position.x = f64::INFINITY),
    ("place-1e10", |light| light.position.z = -1e10),
    ("intensity-nan", |light| light.intensity.x = f64::NAN),
    ("intensity-inf", |light| light.intensity.y = f64::INFINITY),
    ("intensity-negative", |light| light.intensity.z = -1e-9),
    ("intensity-1e16", |light| light.intensity.x = 1e16),
    ("axis-nan", |light| light.axis.x = f64::NAN),
    ("axis-zero", |light| {
        light.emission = Emission::Oriented;
        light.axis = DVec3::ZERO;
    }),
    ("axis-long", |light| {
        light.emission = Emission::Directional;
        light.axis = DVec3::splat(1.0);
    }),
    ("half-angle-0", |light| light.emission = Emission::Spot { half_angle_rad: 0.0 }),
    ("half-angle-4", |light| light.emission = Emission::Spot { half_angle_rad: 4.0 }),
    ("half-angle-negative", |light| light.emission = Emission::Spot { half_angle_rad: -0.5 }),
    ("half-angle-nan", |light| light.emission = Emission::Spot { half_angle_rad: f64::NAN }),
];
const BAD_LIGHT_WORDS: [&str; BAD_LIGHTS.len()] = words(BAD_LIGHTS);

/// Which of the lights is bad.
pub(super) const AT: u32 = 3;

fn bad_lights() -> Axis {
    Axis {
        must_refuse: bad,
        ..of_input(
            "bad-lights",
            "one light whose place, intensity, axis or cone is none: each must be refused by the \
             light's number",
            Values::Words(&BAD_LIGHT_WORDS),
            0.0,
            super::made(|value, case| {
                let (_, damage) = BAD_LIGHTS.get(position(value)).unwrap_or(&BAD_LIGHTS[0]);
                made::with_each(case.seed, |index, light| {
                    if index == AT {
                        damage(light);
                    }
                })
            }),
        )
    }
}

/// A word and the parameters that it sets to what no case can have.
type BadParameter = (&'static str, Changes);

const PARAMETERS: &[BadParameter] = &[
    ("good", &[]),
    ("clamp-0", &[("clamp", "0.0")]),
    ("clamp-minus-1", &[("clamp", "-1.0")]),
    ("clamp-1e9", &[("clamp", "1e9")]),
    ("frames-0", &[("frames", "0")]),
    ("width-0", &[("width", "0")]),
];
const PARAMETER_WORDS: [&str; PARAMETERS.len()] = words(PARAMETERS);

fn bad_parameters() -> Axis {
    Axis {
        must_refuse: bad,
        ..of_input(
            "bad-parameters",
            "a case that there cannot be: distances that count as none, no frame, no pixel",
            Values::Words(&PARAMETER_WORDS),
            0.0,
            of_cloud(|case, value| {
                let (_, changes) = PARAMETERS.get(position(value)).unwrap_or(&PARAMETERS[0]);
                for (name, text) in *changes {
                    case.parameters.insert((*name).into(), typed(text));
                }
            }),
        )
    }
}

const SETTINGS: &[BadSetting] = &[
    ("good", &[]),
    ("threshold-minus-1", &[("threshold", "-1.0")]),
    ("threshold-1e10", &[("threshold", "1e10")]),
    ("own-epsilon-minus-1", &[("own_epsilon", "-1.0")]),
    ("epsilon-minus-1", &[("epsilon", "-1.0")]),
    ("epsilon-101", &[("epsilon", "101.0")]),
    ("most-0", &[("most", "0")]),
    ("most-2^32+1", &[("most", "4294967297")]),
    ("samples-0", &[("samples", "0")]),
    ("samples-2^32+1", &[("samples", "4294967297")]),
    ("cut-0", &[("cut", "0")]),
    ("cut-1025", &[("cut", "1025")]),
    ("candidates-0", &[("candidates", "0")]),
    ("candidates-2^32+1", &[("candidates", "4294967297")]),
    ("history-0", &[("history", "0")]),
    ("neighbours-65", &[("neighbours", "65")]),
    ("neighbours-minus-1", &[("neighbours", "-1")]),
    ("radius-0", &[("radius", "0.0")]),
    ("cutoff-0", &[("cutoff", "0.0")]),
    ("cutoff-2", &[("cutoff", "2.0")]),
    ("tile-0", &[("tile", "0")]),
    ("tile-2^32+32", &[("tile", "4294967328")]),
    ("slices-0", &[("slices", "0")]),
    ("slices-1025", &[("slices", "1025")]),
    ("fanout-minus-1", &[("fanout", "-1")]),
    ("spread-101", &[("spread", "101.0")]),
    ("tree-oak", &[("tree", "oak")]),
    ("bound-guessed", &[("bound", "guessed")]),
    ("representative-loudest", &[("representative", "loudest")]),
    ("levels-none", &[("levels", "none")]),
    ("temporal-maybe", &[("temporal", "maybe")]),
];
const SETTING_WORDS: [&str; SETTINGS.len()] = words(SETTINGS);

fn bad_settings() -> Axis {
    let axis = bad::bad_settings(USUAL, SETTINGS, &SETTING_WORDS);
    Axis { prepare: of_cloud(|_, _| ()), ..axis }
}
