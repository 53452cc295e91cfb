//! Extremes of the scene, of the image and of the camera's steps.

use super::{CITY, LightsCase, SAME, STEPS, USUAL, known, made, made::LIGHTS, of_cloud, of_input};
use crate::{
    knob::Get,
    problems::many_lights::input::{self, Hierarchy, Input, burning},
    stress::{Axis, Prepare, Push, Values, edit, motion, world},
};
use dapple_many_lights::{
    Emission,
    tree::city::{Levels, keys},
};

/// The axes, each pushed alone.
pub fn axes() -> Vec<Axis> {
    vec![scale(), offset(), degenerate(), blocks(), lit(), columns(), frames(), speed(), turn()]
}

fn scale() -> Axis {
    let help = "all lengths of the scene times this, the clamp too, and intensities its square: the \
                same light";
    let axis =
        world::scale(SAME, help, in_other_units(|input, scale| (scaled(input, scale), scale)));
    Axis { parameters: CITY, ..axis }
}

/// The case in other units: what becomes of its lights and surfaces, and how long a metre is there.
fn in_other_units(push: fn(Input, f64) -> (Input, f64)) -> Prepare {
    Box::new(move |case, value, gpu| {
        let (input, scale) = push(input::load(case)?, value);
        input.scene.validate()?;
        let mut case = case.clone();
        let clamp = scale * case.parameters.float("clamp")?;
        case.parameters.insert("clamp".into(), clamp.into());
        Ok(Box::new(LightsCase::of(known(input), &case, gpu)?))
    })
}

fn offset() -> Axis {
    let help = "distance of the scene, made 1 m in radius, from the origin in its own radii, by \
                placements in f64: the same light";
    let axis = world::offset(
        SAME,
        help,
        in_other_units(|input, radii| {
            let scale = 1.0 / input.scene.bounds().radius();
            (moved(scaled(input, scale), radii), scale)
        }),
    );
    Axis { parameters: CITY, ..axis }
}

/// All lengths times `scale`; what falls with the square of distances grows with it.
pub(super) fn scaled(input: Input, scale: f64) -> Input {
    let mut input = with_paths(input);
    for light in &mut input.lights {
        light.position *= scale;
        if light.emission != Emission::Directional {
            light.intensity *= scale * scale;
        }
    }
    Input { scene: edit::scaled(input.scene, scale), origin: input.origin * scale, ..input }
}

/// Moved by so many radii.
pub(super) fn moved(input: Input, radii: f64) -> Input {
    let input = with_paths(input);
    let away = edit::away(&input.scene, radii);
    Input { scene: edit::moved_by(input.scene, away), origin: input.origin + away, ..input }
}

/// A city's hierarchy as paths, which do not depend on where the city lies.
fn with_paths(input: Input) -> Input {
    let hierarchy = match input.hierarchy {
        Hierarchy::City(city, burns) => {
            let paths = keys(&city, input.origin, Levels::default()).1;
            Hierarchy::Paths(burning(paths, &burns))
        }
        other => other,
    };
    Input { hierarchy, ..input }
}

fn degenerate() -> Axis {
    let help = "triangles without area added to the ground or a wall: a corner three times, a corner \
                twice, corners on a line; no pixel shows them";
    let added = super::made(|value, case| {
        let input = made::cloud(LIGHTS, case.seed);
        let scene = edit::with_degenerate_triangles(input.scene, value as u32, case.seed);
        Input { scene, ..input }
    });
    world::degenerate(SAME, help, added)
}

fn blocks() -> Axis {
    Axis {
        parameters: CITY,
        ..USUAL.of_parameter(
            "blocks",
            "blocks",
            "blocks a side of a generated city: lights grow with its square",
            Values::Whole { least: 1, greatest: 4, per_decade: 4 },
            2.0,
        )
    }
}

fn lit() -> Axis {
    Axis {
        parameters: CITY,
        ..USUAL.of_parameter(
            "lit",
            "lit",
            "which of a city's lights burn; generated ones have no lamps",
            Values::Words(&["all", "windows", "lamps"]),
            0.0,
        )
    }
}

fn columns() -> Axis {
    Axis {
        unit: "px",
        prepare: of_cloud(|case, value| {
            case.parameters.insert("width".into(), (value as u32).into());
        }),
        ..USUAL.axis(
            "columns",
            "columns of the image, from a single pixel; rows are 9/16 of it, and few are multiples \
             of 8",
            Values::Whole { least: 1, greatest: 100, per_decade: 3 },
            24.0,
        )
    }
}

fn frames() -> Axis {
    Axis {
        unit: "frames",
        setting: with_state(),
        parameters: &[("width", "12"), ("truth_pixels", "16")],
        prepare: of_cloud(|case, value| {
            case.parameters.insert("frames".into(), (value as u32).into());
        }),
        ..USUAL.axis(
            "frames",
            "frames of the path, for what remembers those before",
            Values::Whole { least: 1, greatest: 100, per_decade: 2 },
            4.0,
        )
    }
}

fn speed() -> Axis {
    let values = Values::FromZero { least: 1e-3, greatest: 1e4, per_decade: 1 };
    let help = "the camera's way along the scene's path in a frame, from standing still to jumping \
                about: what is remembered belongs to other surfaces";
    let prepare = super::made(|value, case| {
        let input = made::cloud(LIGHTS, case.seed);
        let scene = motion::along(input.scene, case, |scene, i| motion::walk(scene, value, i));
        Input { scene, ..input }
    });
    let axis = of_input("speed", help, values, 0.1, prepare);
    Axis { unit: "m a frame", parameters: STEPS, setting: with_state(), ..axis }
}

fn turn() -> Axis {
    let values = Values::FromZero { least: 1e-3, greatest: 180.0, per_decade: 1 };
    let help = "the camera's turn about its up in a frame, on one spot: what is remembered leaves \
                the image, and comes back";
    let prepare = super::made(|value, case| {
        let input = made::cloud(LIGHTS, case.seed);
        let scene = motion::along(input.scene, case, |scene, i| motion::spin(scene, value, i));
        Input { scene, ..input }
    });
    let axis = of_input("turn", help, values, 0.1, prepare);
    Axis { unit: "degrees a frame", parameters: STEPS, setting: with_state(), ..axis }
}

/// Techniques that remember nothing are the same whatever came before.
fn with_state() -> Push {
    Box::new(|setting, _| setting.knobs.contains_key("history").then(|| setting.clone()))
}
