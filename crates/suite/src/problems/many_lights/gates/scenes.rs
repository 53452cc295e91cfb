//! Rules and sums on whole images: a facade's disks, a city's streets, shadows, cost.

use super::{ALL, input};
use crate::{
    SuiteError,
    case::Case,
    knob,
    problem::{Form, Setting},
    problems::many_lights::{LightsCase, SPEC},
    verify::{About, Gate, GateContext, Tally, gate},
};
use dapple_many_lights::{
    LightTree, Lighting, Shaded, World,
    cut::{Cpu, Given},
    tree::{Build, Representative},
    worlds::{self, Cloud, Facade, cloud},
};
use glam::DVec3;
use serde_json::{Value, json};
use std::sync::Arc;

/// The thesis's threshold of Table 5.IV.
const THRESHOLD: f64 = 1.0 / 25_500.0;

/// The error of Figure 5.5.
const MOST_ERROR: f64 = 2.0 / 255.0;

pub fn gates() -> Vec<Gate> {
    let about = |technique, name, statement, fault| About { technique, name, statement, fault };
    vec![
        gate(
            about(
                ALL,
                "row 39 truth",
                "what a case calls the truth is the sum over all its lights, by a formula written \
                 apart, with shadows where they are asked for",
                "distances are clamped at 10 m",
            ),
            truth,
        ),
        gate(
            about(
                "brute-force",
                "row 39 shadows",
                "with shadow rays no channel gets more than without, and some less",
                "shadows fall where there are none",
            ),
            shadows,
        ),
        gate(
            about(
                "brute-force",
                "row 45 linear",
                "evaluations of lights are linear in the lights",
                "no more than 256 lights are looked at",
            ),
            linear,
        ),
        gate(
            about(
                "relative-cut",
                "row 42 disks",
                "on the facade the greatest error of the relative rule is more than five times that \
                 of the absolute one at no smaller cuts",
                "the absolute rule in its place",
            ),
            disks,
        ),
        gate(
            about(
                "absolute-cut",
                "row 43 error",
                "at a threshold of 1/25500 no channel of a pixel is off by more than 2/255, in a \
                 city's points of view, by either tree",
                "a threshold of 1/25",
            ),
            error,
        ),
    ]
}

/// A case of a scene, small.
fn case(
    context: &GateContext<'_>,
    scene: &str,
    view: &str,
    given: &[(&str, Value)],
) -> Result<LightsCase<'static>, SuiteError> {
    let small = [("width", json!(48)), ("frames", json!(1)), ("truth_pixels", json!(100))];
    let given = small.iter().chain(given);
    let given = given.map(|(name, value)| ((*name).to_string(), value.clone())).collect();
    let case = Case {
        problem: SPEC.id.into(),
        scene: scene.into(),
        view: view.into(),
        seed: context.seed,
        parameters: knob::complete("parameter", SPEC.parameters, &given)?,
    };
    LightsCase::prepare(&case, None)
}

/// What a point gets, written apart from the library; without lights that parallel rays bring.
fn by_definition(world: &World, point: &dapple_many_lights::Point, clamp_m: f64) -> DVec3 {
    use dapple_many_lights::Emission;
    let (at, normal) = (point.position.as_dvec3(), point.normal.as_dvec3());
    let gives = |light: &dapple_many_lights::Light| {
        let to_light = light.position - at;
        let distance = to_light.length();
        let cosine = normal.dot(to_light) / distance;
        let turned = (light.axis.dot(-to_light) / distance).clamp(-1.0, 1.0);
        let falloff = match light.emission {
            Emission::Omni => 1.0,
            Emission::Oriented => turned.max(0.0),
            Emission::Spot { half_angle_rad } => (1.0 - turned.acos() / half_angle_rad).max(0.0),
            Emission::Directional => return DVec3::NAN,
        };
        if cosine <= 0.0 || falloff <= 0.0 || !world.sees(point, light) {
            return DVec3::ZERO;
        }
        let over = distance.max(clamp_m).powi(2) * std::f64::consts::PI;
        point.albedo.as_dvec3() * light.intensity * cosine * falloff / over
    };
    world.lights.iter().map(gives).sum()
}

fn truth(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for (scene, visibility) in [
        ("light_cloud", "off"),
        ("light_cloud", "on"),
        ("light_facade", "off"),
        ("city_small", "on"),
    ] {
        let lights = if scene == "light_cloud" { 200 } else { 0 };
        let given = [("visibility", json!(visibility)), ("lights", json!(lights))];
        let case = case(context, scene, "", &given)?;
        let clamp_m = if faulty { 10.0 } else { case.world().clamp_m };
        for (pixel, sum) in case.truth().frame(0) {
            let point = &case.world().frames[0].points[pixel as usize];
            let expected = by_definition(case.world(), point, clamp_m);
            let off = (sum - expected).abs().max_element();
            // An arc cosine near 1 keeps but half of its digits.
            tally.check(off <= 1e-6 * expected.max_element() + 1e-12, || {
                format!("{scene}, shadows {visibility}, pixel {pixel}: {sum}, not {expected}")
            });
        }
    }
    Ok(tally)
}

fn shadows(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let brute = SPEC.technique("brute-force")?;
    for number in 0..input::cases(context, 3, faulty) {
        let with = input::world_in_shadow(context.seed, 2 * number + 1)?;
        let without = World { occluders: None, ..with.clone() };
        for form in [Form::Reference, Form::Cpu] {
            let setting = input::default_setting(brute, form, &[])?;
            let lit = |world: &World| {
                input::Given::new(world.clone(), context.seed, None)?.frames(&setting, 0)
            };
            let (mut dark, mut open) = (lit(&with)?, lit(&without)?);
            if faulty {
                std::mem::swap(&mut dark, &mut open);
            }
            let mut darker = 0;
            for (dark, open) in dark.iter().zip(&open) {
                for (dark, open) in dark.radiance.iter().zip(&open.radiance) {
                    let above = (*dark - *open).max_element();
                    tally.check(above <= 1e-5 * open.max_element(), || {
                        format!("{form}: {dark} in shadow, {open} without")
                    });
                    darker += usize::from(dark.max_element() < 0.99 * open.max_element());
                }
            }
            tally.check(darker > 0, || format!("world {number}, {form}: no shadow falls"));
        }
    }
    Ok(tally)
}

fn linear(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let (mut counts, mut evaluations) = (Vec::new(), Vec::new());
    for lights in [10, 100, 300, 1000, 3000] {
        let size = [16, 9];
        let world = cloud(&Cloud { lights, size, seed: context.seed as u32, ..Cloud::default() });
        let given = input::Given::new(world.world, context.seed, None)?;
        let setting = match faulty {
            true => input::default_setting(SPEC.technique("capped")?, Form::Cpu, &[])?,
            false => input::default_setting(SPEC.technique("brute-force")?, Form::Cpu, &[])?,
        };
        let frames = given.frames(&setting, 0)?;
        counts.push(f64::from(lights));
        evaluations.push(frames.iter().map(|frame| frame.work.lights).sum::<u64>() as f64);
    }
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
    let (x, y) = (mean(&counts), mean(&evaluations));
    let sum = |a: &[f64], b: &[f64]| -> f64 {
        let (of_a, of_b) = (mean(a), mean(b));
        a.iter().zip(b).map(|(a, b)| (a - of_a) * (b - of_b)).sum()
    };
    let both = sum(&counts, &evaluations);
    let share = both * both / (sum(&counts, &counts) * sum(&evaluations, &evaluations));
    tally.within(1.0 - share, 0.01, || "what a line leaves unexplained".into());
    // And through the origin: no light, no cost.
    let rest = (y - both / sum(&counts, &counts) * x).abs() / y;
    tally.within(rest, 1e-9, || "evaluations without a light".into());
    Ok(tally)
}

/// The greatest error of any channel of any pixel.
fn most_off(shaded: &Shaded, truth: &[DVec3]) -> f64 {
    let off = shaded.radiance.iter().zip(truth);
    off.map(|(found, exact)| (found.as_dvec3() - *exact).abs().max_element()).fold(0.0, f64::max)
}

fn disks(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for (number, storeys) in (0..input::cases(context, 2, faulty)).zip([8, 12]) {
        let (made, keys) = worlds::facade(&Facade { storeys, size: [48, 24], ..Facade::default() });
        let tree =
            LightTree::build(&made.world.lights, Build::Keys(&keys), Representative::Weighted)?;
        let (world, tree) = (Arc::new(made.world), Arc::new(tree));
        let truth = input::truth(&world, 0);
        let lit = |technique: &str, knob: &str, value: f64| -> Result<Shaded, SuiteError> {
            let knobs = [(knob, json!(value)), ("bound", json!("walter"))];
            let setting = input::default_setting(SPEC.technique(technique)?, Form::Cpu, &knobs)?;
            let technique = crate::problems::many_lights::settings::technique(&setting)?;
            let mut cpu = Cpu::new(Given::new(&technique, &world, &tree)?);
            let mut shaded = Shaded::default();
            cpu.shade(0, true)?;
            cpu.read(&mut shaded)?;
            Ok(shaded)
        };
        let relative = match faulty {
            true => lit("absolute-cut", "threshold", 0.01)?,
            false => lit("relative-cut", "own_epsilon", 0.02)?,
        };
        // The smallest threshold by quarters whose cuts are no larger.
        let mut threshold = 1e-6;
        let mut absolute = lit("absolute-cut", "threshold", threshold)?;
        while absolute.work.cut > relative.work.cut && threshold < 1e3 {
            threshold *= 1.25;
            absolute = lit("absolute-cut", "threshold", threshold)?;
        }
        let (ours, theirs) = (most_off(&relative, &truth), most_off(&absolute, &truth));
        tally.check(absolute.work.cut <= relative.work.cut, || "no threshold is as large".into());
        tally.check(ours > 5.0 * theirs, || {
            format!("facade {number}: {ours} off, the absolute rule {theirs}")
        });
        tally.check(ours > MOST_ERROR, || format!("facade {number}: {ours} shows no disk"));
    }
    Ok(tally)
}

fn error(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let technique = SPEC.technique("absolute-cut")?;
    let threshold = if faulty { 1000.0 * THRESHOLD } else { THRESHOLD };
    for view in ["facade", "close_ended", "street"] {
        let case = case(context, "city_small", view, &[])?;
        for (variant, tree) in [("pixel", "city"), ("tile", "city"), ("pixel", "median")] {
            let knobs = [("threshold", json!(threshold)), ("tree", json!(tree))];
            let setting = input::default_setting(technique, Form::Cpu, &knobs)?;
            let setting = Setting { variant: variant.into(), ..setting };
            let mut lighting = case.lighting(&setting)?;
            let frames = input::frames(&mut *lighting, 0..1, 0, true)?;
            let mut most = 0.0_f64;
            for (pixel, exact) in case.truth().frame(0) {
                let found = frames[0].radiance[pixel as usize].as_dvec3();
                most = most.max((found - exact).abs().max_element());
            }
            tally.within(most, MOST_ERROR, || format!("{view}, {setting}, tree {tree}: error"));
        }
    }
    Ok(tally)
}
