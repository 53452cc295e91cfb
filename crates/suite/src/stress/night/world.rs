//! Extremes of a city as a whole, and of the image.

use super::{Loaded, Posed, edit};
use crate::{
    knob::Get,
    problem::Setting,
    stress::{Axis, Prepare, Push, Values, edit::away, settings::with, world},
};
use dapple_scene::city::City;

/// The axes, each pushed alone.
pub fn axes(posed: Posed) -> Vec<Axis> {
    vec![
        scale(posed),
        offset(posed),
        turn(posed),
        blocks(posed),
        street(posed),
        empty(posed),
        heights(posed),
        layout(posed),
        columns(posed),
        frames(posed),
        clamp(posed),
    ]
}

fn scale(posed: Posed) -> Axis {
    let help = "all lengths of the city times this, the clamp and distances of planes too, and \
                intensities its square: the same light";
    let scaled: Prepare = in_other_units(posed, |city, scale| (edit::scaled(city, scale), scale));
    Axis {
        criterion: posed.unchanged,
        // Smaller ones have a clamp below the least.
        values: Values::Log { least: 1e-4, greatest: 1e6, per_decade: 1 },
        setting: scaled_steps(|value| value),
        ..world::scale(posed.usual, help, scaled)
    }
}

fn offset(posed: Posed) -> Axis {
    let help = "distance of the city, made 100 m in radius, from the origin in its own radii: the same \
                light. Its walls are no longer exactly along the axes";
    let moved = in_other_units(posed, |city, radii| {
        let scene = city.scene().scene;
        let scale = 100.0 / scene.bounds().radius();
        let city = edit::scaled(city, scale);
        let away = away(&city.scene().scene, radii);
        (edit::moved(city, away), scale)
    });
    Axis { criterion: posed.unchanged, ..world::offset(posed.usual, help, moved) }
}

/// The case in other units: what becomes of its city, and how long a metre is there.
fn in_other_units(posed: Posed, push: fn(City, f64) -> (City, f64)) -> Prepare {
    Box::new(move |case, value, gpu| {
        let loaded = crate::city::load(&case.scene, case.seed, &case.parameters)?;
        let mut metre = 1.0;
        let changed = edit::of_city(loaded, |city| {
            let (city, scale) = push(city, value);
            metre = scale;
            city
        })?;
        let mut case = case.clone();
        let clamp = metre * case.parameters.float("clamp")?;
        case.parameters.insert("clamp".into(), clamp.into());
        posed.ask(changed, &case, gpu)
    })
}

/// The greatest distance that a knob can have.
const MOST_M: f64 = 1e4;

/// Settings whose distances grow with the city.
fn scaled_steps(scale: fn(f64) -> f64) -> Push {
    Box::new(move |setting: &Setting, value| {
        let Ok(step) = setting.knobs.float("least_step") else { return Some(setting.clone()) };
        with(setting, "least_step", (step * scale(value)).min(MOST_M))
    })
}

fn turn(posed: Posed) -> Axis {
    Axis {
        unit: "degrees",
        ..posed.axis(
            "turn-of-city",
            "turn of the whole city about the vertical: cells' frames follow its facades",
            Values::Linear { least: 0.0, greatest: 90.0, steps: 9 },
            0.0,
            posed.pushed(|loaded: Loaded, value, _| {
                edit::of_city(loaded, |city| edit::turned(city, value))
            }),
        )
    }
}

fn blocks(posed: Posed) -> Axis {
    posed.usual.of_parameter(
        "blocks",
        "blocks",
        "blocks a side of a generated city: lights grow with its square",
        Values::Whole { least: 1, greatest: 4, per_decade: 4 },
        2.0,
    )
}

fn street(posed: Posed) -> Axis {
    Axis {
        unit: "m",
        ..posed.usual.of_parameter(
            "street",
            "street",
            "width of a generated city's streets",
            Values::Linear { least: 6.0, greatest: 30.0, steps: 3 },
            12.0,
        )
    }
}

fn empty(posed: Posed) -> Axis {
    posed.usual.of_parameter(
        "empty",
        "empty-lots",
        "share of a generated city's lots that are empty",
        Values::Linear { least: 0.0, greatest: 0.5, steps: 2 },
        0.0,
    )
}

fn heights(posed: Posed) -> Axis {
    posed.usual.of_parameter(
        "heights",
        "heights",
        "heights of a generated city's buildings: all alike, roofs hide nothing behind them that is \
         higher",
        Values::Words(&["scene", "varied", "independent", "seven"]),
        0.0,
    )
}

fn layout(posed: Posed) -> Axis {
    posed.usual.of_parameter(
        "layout",
        "layout",
        "whether streets of a generated city run through, or end at facades",
        Values::Words(&["scene", "brick", "grid"]),
        0.0,
    )
}

fn columns(posed: Posed) -> Axis {
    Axis {
        unit: "px",
        ..posed.usual.of_parameter(
            "width",
            "columns",
            "columns of the image, from a single one; rows are 3/4 of it",
            Values::Whole { least: 1, greatest: 200, per_decade: 2 },
            24.0,
        )
    }
}

fn frames(posed: Posed) -> Axis {
    Axis {
        unit: "frames",
        ..posed.usual.of_parameter(
            "frames",
            "frames",
            "frames of the path",
            Values::Whole { least: 1, greatest: 30, per_decade: 2 },
            2.0,
        )
    }
}

fn clamp(posed: Posed) -> Axis {
    Axis {
        unit: "m",
        ..posed.usual.of_parameter(
            "clamp",
            "clamp",
            "distances to lights below this count as this: from never to always",
            Values::Log { least: 1e-6, greatest: 1e3, per_decade: 1 },
            0.1,
        )
    }
}
