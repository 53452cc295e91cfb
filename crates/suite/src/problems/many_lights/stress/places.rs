//! Extremes of where lights are: in one place, on a surface, behind all, far away.

use super::{LightsCase, USUAL, made, made::LIGHTS, of_cloud, of_input};
use crate::{
    case::Case,
    city,
    knob::Get,
    problems::many_lights::{case::frame, input::Input},
    stress::{Axis, Values},
};
use dapple_many_lights::Light;
use dapple_trace::Tracer;
use glam::DVec3;

/// The axes, each pushed alone.
pub fn axes() -> Vec<Axis> {
    vec![coincident(), behind(), far(), above_points(), clamp()]
}

const SHARES: Values = Values::Linear { least: 0.0, greatest: 1.0, steps: 4 };

fn coincident() -> Axis {
    of_input(
        "coincident",
        "share of lights that are all in one place: no tree tells them apart by distance",
        SHARES,
        0.0,
        super::made(|value, case| {
            let one = made::cloud(LIGHTS, case.seed).lights[0].position;
            made::with_share(value, case.seed, |light| light.position = one)
        }),
    )
}

fn behind() -> Axis {
    of_input(
        "behind",
        "share of lights below the ground, where they light nothing that shows; at last all",
        SHARES,
        0.0,
        super::made(|value, case| {
            made::with_share(value, case.seed, |light| light.position.y = -light.position.y)
        }),
    )
}

fn far() -> Axis {
    of_input(
        "far",
        "distances of all lights from the middle times this, their intensities its square: parallel \
         light in the end",
        Values::Log { least: 1.0, greatest: 1e6, per_decade: 1 },
        1.0,
        super::made(|value, case| {
            made::with_each(case.seed, |_, light| {
                light.position *= value;
                light.intensity *= value * value;
            })
        }),
    )
}

fn above_points() -> Axis {
    Axis {
        unit: "m",
        ..of_input(
            "above-surface",
            "distance of all lights from points that pixels show, down to lights on the very points, \
             which they do not light",
            Values::FromZero { least: 1e-6, greatest: 10.0, per_decade: 1 },
            1.0,
            Box::new(|case, value, gpu| {
                let case = super::first_view(case);
                let input = super::known(lifted(value, &case)?);
                Ok(Box::new(LightsCase::of(input, &case, gpu)?))
            }),
        )
    }
}

/// Lights above points that the case's first frame shows, along their normals.
pub(super) fn lifted(distance_m: f64, case: &Case) -> Result<Input, crate::SuiteError> {
    let mut input = made::cloud(LIGHTS, case.seed);
    let width = case.parameters.int("width")? as u32;
    let height = (width * 9 / 16).max(1);
    let (_, cameras) = city::cameras(&input.scene, &case.view, 1)?;
    let tracer = Tracer::build(&input.scene)?;
    let frame = frame(&input.scene, &tracer, &cameras[0], [width, height], input.origin);
    let shown: Vec<_> = frame.points.iter().filter(|point| point.is_there()).collect();
    if shown.is_empty() {
        return Ok(input);
    }
    let every = (shown.len() / LIGHTS as usize).max(1);
    let places = shown.iter().step_by(every).cycle();
    for (light, point) in input.lights.iter_mut().zip(places) {
        let normal = point.normal.as_dvec3();
        let position = point.position.as_dvec3() + normal * distance_m;
        // Near a point only the clamp limits what a light gives it.
        let intensity = 0.01 * light.intensity;
        *light =
            Light { position, axis: (-normal).normalize_or(DVec3::NEG_Y), intensity, ..*light };
    }
    Ok(input)
}

fn clamp() -> Axis {
    Axis {
        unit: "m",
        prepare: of_cloud(|case, value| {
            case.parameters.insert("clamp".into(), value.into());
        }),
        ..USUAL.axis(
            "clamp",
            "distances to lights below this count as this: from never to always",
            Values::Log { least: 1e-6, greatest: 1e3, per_decade: 1 },
            0.1,
        )
    }
}
