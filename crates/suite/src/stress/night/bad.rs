//! Input that must be refused, each kind with a good one beside it.

use super::{
    Posed,
    made::{WALK, street},
};
use crate::stress::{
    Axis, Values,
    bad::{bad, bad_vertices as vertices, vertices_and},
    settings::{Changes, position, typed, words},
    world::{Kind, changed},
};
use dapple_scene::city::City;
use glam::{DAffine3, DVec3, Vec3};

/// The axes, each pushed alone.
pub fn axes(posed: Posed) -> Vec<Axis> {
    vec![bad_vertices(posed), bad_city(posed), bad_parameters(posed)]
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

fn bad_vertices(posed: Posed) -> Axis {
    let help = "one coordinate of a vertex; an index past the last vertex; a placement; a mesh that \
                is not there; a reflectance that is no number: each must be refused by name";
    Axis {
        prepare: posed.pushed(|mut loaded, value, case| {
            loaded.scene = changed(&DAMAGES, loaded.scene, value, case.seed);
            Ok(loaded)
        }),
        ..vertices(posed.usual, help, &DAMAGE_WORDS)
    }
}

/// What happens to a city.
type BadCity = (&'static str, fn(&mut City));

const CITIES: &[BadCity] = &[
    ("good", |_| {}),
    ("wall-nan", |city| city.buildings[1].facades[0].from.x = f64::NAN),
    ("wall-1e30", |city| city.buildings[1].facades[0].from.x = -1e30),
    ("base-nan", |city| city.buildings[1].base_m = f64::NAN),
    ("eaves-inf", |city| city.buildings[1].eaves_m = f64::INFINITY),
    ("roof-nan", |city| city.buildings[1].roof[0][0].y = f64::NAN),
    ("ground-nan", |city| city.grounds[0].triangles[0][0].x = f64::NAN),
    ("light-nan", |city| city.lights[3].position.y = f64::NAN),
    ("light-1e10", |city| city.lights[3].position.z = -1e10),
    ("light-axis-0", |city| city.lights[3].direction = DVec3::ZERO),
    ("light-axis-nan", |city| city.lights[3].direction.x = f64::NAN),
    ("light-cone-0", |city| city.lights[3].half_angle_rad = 0.0),
    ("light-cone-nan", |city| city.lights[3].half_angle_rad = f64::NAN),
    ("light-negative", |city| city.lights[3].intensity.x = -1e-9),
    ("light-inf", |city| city.lights[3].intensity.x = f32::INFINITY),
    ("camera-nan", |city| city.paths[0].keys[1].position.x = f64::NAN),
    ("camera-no-direction", |city| {
        let key = &mut city.paths[0].keys[1];
        key.target = key.position;
    }),
];
const CITY_WORDS: [&str; CITIES.len()] = words(CITIES);

fn bad_city(posed: Posed) -> Axis {
    Axis {
        must_refuse: bad,
        ..posed.axis(
            "bad-city",
            "one wall, height, roof, ground, light or camera of a city that is none: each must be \
             refused by name",
            Values::Words(&CITY_WORDS),
            0.0,
            posed.made(|value, case| {
                let mut city = street(&WALK).city(case.seed)?;
                let (_, damage) = CITIES.get(position(value)).unwrap_or(&CITIES[0]);
                damage(&mut city);
                Ok(city)
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

fn bad_parameters(posed: Posed) -> Axis {
    Axis {
        must_refuse: bad,
        ..posed.axis(
            "bad-parameters",
            "a case that there cannot be: distances that count as none, no frame, no pixel",
            Values::Words(&PARAMETER_WORDS),
            0.0,
            Box::new(move |case, value, gpu| {
                let mut case = super::first_view(case);
                let (_, changes) = PARAMETERS.get(position(value)).unwrap_or(&PARAMETERS[0]);
                for (name, text) in *changes {
                    case.parameters.insert((*name).into(), typed(text));
                }
                let city = street(&WALK).city(case.seed)?;
                posed.ask(super::loaded(city)?, &case, gpu)
            }),
        )
    }
}
