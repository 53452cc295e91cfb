//! Techniques that draw lights by chance: bias, variance, and what may be drawn.

use super::{
    input::{self, EMISSIONS},
    shared::without_strongest,
};
use crate::{
    SuiteError,
    problem::{Form, Setting, Technique},
    problems::many_lights::{SPEC, settings},
    verify::{About, Gate, GateContext, Tally, gate},
};
use dapple_many_lights::{
    self as lights, Emission, Light, World,
    sample::{expected, statistics::Moments},
    worlds::{Cloud, Rectangle, cloud, made},
};
use dapple_scene::{Camera, Projection};
use glam::{DVec3, Vec3};
use serde_json::{Value, json};
use std::sync::Arc;

/// Images whose mean is judged.
const RUNS: u32 = 250;

/// Chance that an unbiased technique fails.
const ALPHA: f64 = 1e-6;

/// Share of the truth that sums in f32 may be off by.
const ROUNDING: f64 = 2e-5;

/// Share by which the measured variance of an image may miss the enumerated one: with 250 images of
/// 144 pixels, many of its standard errors.
const VARIANCE: f64 = 0.25;

pub fn gates() -> Vec<Gate> {
    let mut gates = Vec::new();
    let drawn = SPEC.techniques.iter().filter(|technique| is_random(technique));
    for technique in drawn {
        let about =
            |name, statement, fault| About { technique: technique.id, name, statement, fault };
        gates.push(gate(
            about(
                "unbiased",
                "the mean of many images is the truth, within what their variance allows",
                "the light that gives most is never drawn",
            ),
            |context, faulty| unbiased(technique, context, faulty),
        ));
        if enumerated(technique) {
            gates.push(gate(
                about(
                    "chances",
                    "over all that may be drawn the mean is the truth, pixel by pixel: no light \
                     that gives anything starves",
                    "the light that gives most is never drawn",
                ),
                |context, faulty| chances(technique, context, faulty),
            ));
            gates.push(gate(
                about(
                    "variance",
                    "images scatter as the chances of what is drawn say",
                    "many more lights are drawn",
                ),
                |context, faulty| variance(technique, context, faulty),
            ));
        }
    }
    gates.push(gate(
        About {
            technique: "reservoirs",
            name: "unbiased reuse",
            statement: "where neighbours see other lights, reuse over space and time keeps the mean",
            fault: "all candidates are counted (the biased variant)",
        },
        reuse,
    ));
    gates
}

/// A technique's settings by default.
fn default_of(technique: &Technique) -> Result<lights::Technique, SuiteError> {
    settings::technique(&input::default_setting(technique, Form::Cpu, &[])?)
}

fn is_random(technique: &Technique) -> bool {
    // A technique whose defaults are refused gets all gates, and they say so.
    default_of(technique).map_or(true, |settings| settings::is_random(&settings))
}

/// Whether all that a technique may draw can be enumerated.
fn enumerated(technique: &Technique) -> bool {
    default_of(technique)
        .is_ok_and(|settings| !matches!(settings, lights::Technique::Reservoirs(_)))
}

/// A small world of all kinds of light, in shadow if asked.
fn small(seed: u64, number: u32) -> Result<World, SuiteError> {
    let made = cloud(&Cloud {
        lights: 24,
        emissions: EMISSIONS.to_vec(),
        seed: lights::sample::hash(seed as u32) ^ number,
        size: [16, 9],
        frames: 2,
        origin: DVec3::ZERO,
    });
    Ok(if number % 2 == 1 { made.with_shadows()? } else { made.world })
}

/// Few of everything: the variance is then large, and found with few images.
fn few(technique: &Technique, variant: &str) -> Result<Setting, SuiteError> {
    let wanted: [(&str, Value); 5] = [
        ("samples", json!(2)),
        ("cut", json!(8)),
        ("candidates", json!(6)),
        ("neighbours", json!(3)),
        ("radius", json!(4.0)),
    ];
    let there = |name: &str| technique.knobs.iter().any(|knob| knob.name == name);
    let given: Vec<_> = wanted.into_iter().filter(|(name, _)| there(name)).collect();
    let setting = input::default_setting(technique, Form::Cpu, &given)?;
    Ok(Setting { variant: variant.into(), ..setting })
}

/// Variants whose mean has to be the truth.
fn variants(technique: &'static Technique) -> Result<Vec<Setting>, SuiteError> {
    let mut all = Vec::new();
    for variant in technique.variants {
        let setting = few(technique, variant.id)?;
        if settings::is_unbiased(&settings::technique(&setting)?) {
            all.push(setting);
        }
    }
    Ok(all)
}

/// The last frames of many runs, as means over rows of the image: single pixels scatter too far from
/// what is normal.
fn rows_of_runs(
    given: &input::Given<'_>,
    setting: &Setting,
    seed: u64,
) -> Result<(Moments, Moments), SuiteError> {
    let (mut rows, mut pixels) = (Moments::default(), Moments::default());
    let mut lighting = given.lighting(setting)?;
    let frames = given.world.frames.len();
    for run in 0..RUNS {
        let seed = lights::sample::hash(seed as u32).wrapping_add(run);
        let all = input::frames(&mut *lighting, 0..frames, seed, false)?;
        let Some(last) = all.last() else { continue };
        let frame = &given.world.frames[frames - 1];
        rows.push(&of_rows(&last.radiance, frame.width, |v| v.as_dvec3()));
        pixels.push(&last.radiance);
    }
    Ok((rows, pixels))
}

fn of_rows<T: Copy>(pixels: &[T], width: u32, value: impl Fn(T) -> DVec3) -> Vec<Vec3> {
    let row = |row: &[T]| row.iter().map(|v| value(*v)).sum::<DVec3>() / f64::from(width);
    pixels.chunks(width as usize).map(|pixels| row(pixels).as_vec3()).collect()
}

/// Means of rows, exactly.
fn known(pixels: &[DVec3], width: u32) -> Vec<DVec3> {
    let mean = |row: &[DVec3]| row.iter().sum::<DVec3>() / f64::from(width);
    pixels.chunks(width as usize).map(mean).collect()
}

fn unbiased(
    technique: &'static Technique,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..input::cases(context, 2, faulty) {
        let world = small(context.seed, number)?;
        let (last, width) = (world.frames.len() - 1, world.frames[0].width);
        let truth = known(&input::truth(&world, last), width);
        let world = if faulty { without_strongest(world) } else { world };
        let given = input::Given::new(world, context.seed, None)?;
        for setting in variants(technique)? {
            let (rows, _) = rows_of_runs(&given, &setting, context.seed)?;
            // Where all chances are known, so is the variance; pixels draw apart.
            let variance = match enumerated(technique) {
                true => {
                    let drawn = settings::technique(&setting)?;
                    let tree = given.tree(&setting)?;
                    let found = expected(lights::Form::Cpu, &drawn, &given.world, &tree, last)?;
                    let of_rows = known(&found.variance, width);
                    of_rows.iter().map(|row| *row / f64::from(width)).collect()
                }
                false => rows.variance(),
            };
            let test = rows.z_test(&truth, &variance, ALPHA, ROUNDING);
            tally.check(test.tests > 0, || format!("{setting}: nothing is tested"));
            tally.within(test.worst, test.limit, || format!("{setting}, world {number}: z"));
            tally.check(test.failures == 0, || format!("{setting}: {} failures", test.failures));
        }
    }
    Ok(tally)
}

fn chances(
    technique: &'static Technique,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..input::cases(context, 4, faulty) {
        let world = small(context.seed, number)?;
        let truth = input::truth(&world, 0);
        let world = if faulty { without_strongest(world) } else { world };
        let given = input::Given::new(world, context.seed, None)?;
        for setting in variants(technique)? {
            let (drawn, tree) = (settings::technique(&setting)?, given.tree(&setting)?);
            for (form, rounding) in
                [(lights::Form::Reference, 1e-12), (lights::Form::Cpu, ROUNDING)]
            {
                let found = expected(form, &drawn, &given.world, &tree, 0)?;
                for (pixel, (mean, exact)) in found.mean.iter().zip(&truth).enumerate() {
                    let off = (*mean - *exact).abs().max_element();
                    tally.check(off <= rounding * exact.max_element(), || {
                        format!("{setting}, {form:?}: pixel {pixel}: {mean} rather than {exact}")
                    });
                }
            }
        }
    }
    Ok(tally)
}

fn variance(
    technique: &'static Technique,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let given = input::Given::new(small(context.seed, 0)?, context.seed, None)?;
    let last = given.world.frames.len() - 1;
    for mut setting in variants(technique)? {
        let (drawn, tree) = (settings::technique(&setting)?, given.tree(&setting)?);
        let found = expected(lights::Form::Cpu, &drawn, &given.world, &tree, last)?;
        if faulty {
            for (name, value) in [("samples", 40), ("cut", 1024)] {
                if let Some(knob) = setting.knobs.get_mut(name) {
                    *knob = value.into();
                }
            }
        }
        let (_, pixels) = rows_of_runs(&given, &setting, context.seed)?;
        // Where a pixel scatters by rare bright lights its variance is found late: the root gives
        // those less weight.
        let sum = |all: &[DVec3]| all.iter().map(|v| v.element_sum().sqrt()).sum::<f64>();
        let (measured, exact) = (sum(&pixels.variance()), sum(&found.variance));
        tally.within((measured / exact - 1.0).abs(), VARIANCE, || {
            format!("{setting}: scatters by {measured}, enumerated {exact}")
        });
    }
    Ok(tally)
}

/// A roof bent by 20 degrees, whose halves count as alike; half of the lights stand behind one half
/// or the other. An eye above it stands still for two frames.
fn bent() -> World {
    let slope = 10.0_f64.to_radians();
    let half = |side: f64| Rectangle {
        corner: DVec3::new(0.0, 0.0, 4.0 * side),
        along: DVec3::new(side * slope.cos(), -slope.sin(), 0.0) * 5.0,
        up: DVec3::NEG_Z * (8.0 * side),
        albedo: Vec3::splat(0.8),
    };
    let light = |index: u32| {
        let side = if index.is_multiple_of(2) { 1.0 } else { -1.0 };
        Light {
            position: DVec3::new(side * 12.0, 0.5, f64::from(index / 2) - 2.0),
            axis: DVec3::Z,
            intensity: DVec3::new(30.0, 25.0, 15.0),
            emission: Emission::Omni,
        }
    };
    let camera = Camera {
        name: "above".into(),
        position: DVec3::Y * 20.0,
        target: DVec3::ZERO,
        up: DVec3::NEG_Z,
        projection: Projection::Orthographic { height_m: 8.0 },
    };
    let lights = (0..10).map(light).collect();
    made(lights, &[half(1.0), half(-1.0)], &[camera.clone(), camera], [12, 10], DVec3::ZERO).world
}

fn reuse(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let technique = SPEC.technique("reservoirs")?;
    let world = Arc::new(bent());
    let given = input::Given { world: Arc::clone(&world), seed: context.seed, scene: None };
    let truth = input::truth(&world, 1);
    let variant = technique.variants[usize::from(faulty)].id;
    for temporal in ["off", "on"] {
        let mut setting = few(technique, variant)?;
        setting.knobs.insert("temporal".into(), temporal.into());
        // Columns are along the ridge: those beside it lose light where counting is biased.
        let mut columns = Moments::default();
        let mut lighting = given.lighting(&setting)?;
        let size = [world.frames[1].width, world.frames[1].height];
        for run in 0..2 * RUNS {
            let seed = lights::sample::hash(context.seed as u32).wrapping_add(run);
            let frames = input::frames(&mut *lighting, 0..2, seed, false)?;
            let Some(last) = frames.last() else { continue };
            let turned = turned(&last.radiance, size);
            columns.push(&of_rows(&turned, size[1], |v| v.as_dvec3()));
        }
        let truth = known(&turned(&truth, size), size[1]);
        let test = columns.z_test(&truth, &columns.variance(), ALPHA, ROUNDING);
        tally.within(test.worst, test.limit, || format!("{setting}, temporal {temporal}: z"));
        tally.check(test.passes(), || format!("{setting}: {test:?}"));
    }
    Ok(tally)
}

/// Columns as rows.
fn turned<T: Copy>(pixels: &[T], [width, height]: [u32; 2]) -> Vec<T> {
    let (width, height) = (width as usize, height as usize);
    (0..width).flat_map(|x| (0..height).map(move |y| pixels[y * width + x])).collect()
}
