//! What holds of every technique that the problem declares.

use super::{extremes::extremes, input, limits::limit, on_device};
use crate::{
    SuiteError,
    problem::{Form, Technique},
    problems::many_lights::{SPEC, port, settings},
    verify::{About, Gate, GateContext, Tally, gate},
};
use dapple_many_lights::{Shaded, World};
use glam::DVec3;

/// Worlds of a gate.
const WORLDS: u32 = 5;

/// The same on a device, which takes its time to make programs ready.
const ON_DEVICE: u32 = 2;

/// Share of the radiance by which the reference may miss it: its image is f32.
const ROUNDED: f64 = 1e-6;

/// Seed of a technique's own random numbers.
const SEED: u32 = 7;

pub fn gates() -> Vec<Gate> {
    let mut gates = Vec::new();
    for technique in SPEC.techniques {
        let about =
            |name, statement, fault| About { technique: technique.id, name, statement, fault };
        let of_port = |name| {
            about(
                name,
                "pixels are the reference's, but for rounding and for the few at which it makes a \
                 cut, a list or a draw fall the other way",
                "every pixel is the one beside it",
            )
        };
        let of_limit = |name| {
            about(
                name,
                "where its settings leave nothing out, it is the sum over all lights in f64",
                "its settings are loose, or a light is missing from what it is given",
            )
        };
        gates.push(gate(of_port("cpu port"), |context, faulty| {
            ported(technique, Form::Cpu, context, faulty)
        }));
        gates.push(on_device(of_port("gpu port"), |context, faulty| {
            ported(technique, Form::Gpu, context, faulty)
        }));
        gates.push(gate(of_limit("limit"), |context, faulty| {
            limited(technique, &[Form::Reference, Form::Cpu], context, faulty)
        }));
        gates.push(on_device(of_limit("gpu limit"), |context, faulty| {
            limited(technique, &[Form::Gpu], context, faulty)
        }));
        gates.push(gate(
            about(
                "finite",
                "at the ends of what is allowed, every radiance is finite and at least 0, and \
                 nothing is lit where nothing shows",
                "surfaces reflect less than nothing of the red",
            ),
            |context, faulty| finite(technique, context, faulty),
        ));
        gates.push(gate(
            about(
                "repeats",
                "a seed gives the same bits again, whatever was lit before, on any number of \
                 threads, counted or not; without chance any seed does",
                "another frame is lit",
            ),
            |context, faulty| repeats(technique, context, faulty),
        ));
    }
    gates
}

/// Frames with every pixel's radiance moved to the next.
fn moved(mut frames: Vec<Shaded>) -> Vec<Shaded> {
    frames.iter_mut().for_each(|frame| frame.radiance.rotate_right(1));
    frames
}

fn ported(
    technique: &Technique,
    form: Form,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let gpu = context.gpu.filter(|_| form == Form::Gpu);
    let worlds = if form == Form::Gpu { ON_DEVICE } else { WORLDS };
    for variant in technique.variants.iter().filter(|v| technique.has(v.id, form)) {
        let (mut pixels, mut differ, mut most) = (0, 0, 0.0_f64);
        for number in 0..input::cases(context, worlds, faulty) {
            let world = match form {
                Form::Gpu => input::world(context.seed, number),
                _ => input::world_in_shadow(context.seed, number)?,
            };
            let given = input::Given::new(world, context.seed, gpu)?;
            let mut rng = input::rng(context.seed, technique.id, number);
            let setting = input::setting(&mut rng, technique, variant.id, form);
            let reference = crate::problem::Setting { form: Form::Reference, ..setting.clone() };
            let mut ours = given.frames(&setting, SEED)?;
            let theirs = given.frames(&reference, SEED)?;
            if faulty {
                ours = moved(ours);
            }
            most = port::allowed(&settings::technique(&setting)?);
            for (a, b) in ours.iter().zip(&theirs) {
                tally.check(a.work.pixels == b.work.pixels, || {
                    format!("{setting}: {} pixels, reference: {}", a.work.pixels, b.work.pixels)
                });
                let pairs = a.radiance.iter().zip(&b.radiance);
                differ += pairs.filter(|(a, b)| !port::alike(**a, **b)).count();
                pixels += b.radiance.len();
            }
        }
        let share = differ as f64 / f64::from(pixels.max(1) as u32);
        tally.within(share, most, || {
            format!("{}, {form}: {differ} of {pixels} pixels differ", variant.id)
        });
    }
    Ok(tally)
}

fn limited(
    technique: &Technique,
    forms: &[Form],
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let on_device = forms.contains(&Form::Gpu);
    let worlds = if on_device { ON_DEVICE } else { WORLDS };
    for (variant, number) in technique.variants.iter().flat_map(|variant| {
        (0..input::cases(context, worlds, faulty)).map(move |number| (variant.id, number))
    }) {
        let limit = limit(technique.id, variant)?;
        let mut world = match on_device {
            true => input::world(context.seed, number),
            false => input::world_in_shadow(context.seed, number)?,
        };
        if limit.lone && !faulty {
            world.lights.truncate(1);
        }
        let expected: Vec<Vec<DVec3>> =
            (0..world.frames.len()).map(|frame| input::truth(&world, frame)).collect();
        if faulty && limit.loose.is_empty() {
            world = without_strongest(world);
        }
        let given = input::Given::new(world, context.seed, context.gpu.filter(|_| on_device))?;
        let mut rng = input::rng(context.seed, technique.id, number);
        for form in forms.iter().copied().filter(|form| technique.has(variant, *form)) {
            let knobs = if faulty { &limit.loose } else { &limit.exact };
            let setting = input::setting_with(&mut rng, technique, variant, form, knobs)?;
            for (shaded, expected) in given.frames(&setting, SEED)?.iter().zip(&expected) {
                for (pixel, (found, exact)) in shaded.radiance.iter().zip(expected).enumerate() {
                    let near = match form {
                        Form::Reference => {
                            let off = (found.as_dvec3() - *exact).abs().max_element();
                            off <= ROUNDED * exact.max_element()
                        }
                        _ => port::alike(*found, exact.as_vec3()),
                    };
                    tally.check(near, || {
                        format!("{setting} {:?}: pixel {pixel}: {found} for {exact}", setting.knobs)
                    });
                }
            }
        }
    }
    Ok(tally)
}

/// A world without the light that gives most of what shows.
pub fn without_strongest(mut world: World) -> World {
    let gives = |index: usize| {
        let points = world.frames[0].points.iter().filter(|point| point.is_there());
        let lit = points.map(|point| {
            let light = &world.lights[index];
            let radiance = dapple_many_lights::radiance(point, light, world.clamp_m);
            if world.sees(point, light) { radiance.element_sum() } else { 0.0 }
        });
        lit.sum::<f64>()
    };
    let strongest = (0..world.lights.len()).max_by(|a, b| gives(*a).total_cmp(&gives(*b)));
    if let Some(strongest) = strongest {
        world.lights.remove(strongest);
    }
    world
}

fn finite(
    technique: &Technique,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let mut rng = input::rng(context.seed, technique.id, 0);
    for (name, mut world) in extremes(&mut rng) {
        if faulty {
            let points = world.frames.iter_mut().flat_map(|frame| &mut frame.points);
            points.for_each(|point| point.albedo.x = -0.1);
        }
        let given = input::Given::new(world, context.seed, None)?;
        for (variant, form) in
            technique.variants.iter().flat_map(|v| [Form::Reference, Form::Cpu].map(|f| (v, f)))
        {
            if !technique.has(variant.id, form) {
                continue;
            }
            let setting = input::setting(&mut rng, technique, variant.id, form);
            for (shaded, frame) in given.frames(&setting, SEED)?.iter().zip(&given.world.frames) {
                let fits = shaded.radiance.len() == frame.points.len();
                tally.check(fits, || format!("{name}: {} pixels", shaded.radiance.len()));
                for (radiance, point) in shaded.radiance.iter().zip(&frame.points) {
                    let sound = radiance.is_finite() && radiance.min_element() >= 0.0;
                    let dark = point.is_there() || *radiance == glam::Vec3::ZERO;
                    tally.check(sound && dark, || {
                        format!("{name}, {setting} {:?}: {radiance}", setting.knobs)
                    });
                }
            }
        }
    }
    Ok(tally)
}

fn repeats(
    technique: &Technique,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let alone = alone.map_err(|error| SuiteError::Internal(error.to_string()))?;
    for number in 0..input::cases(context, WORLDS, faulty) {
        let world = input::world_in_shadow(context.seed, number)?;
        let given = input::Given::new(world, context.seed, None)?;
        let mut rng = input::rng(context.seed, technique.id, number);
        for (variant, form) in
            technique.variants.iter().flat_map(|v| [Form::Reference, Form::Cpu].map(|f| (v, f)))
        {
            if !technique.has(variant.id, form) {
                continue;
            }
            let setting = input::setting(&mut rng, technique, variant.id, form);
            let random = settings::is_random(&settings::technique(&setting)?);
            let mut lighting = given.lighting(&setting)?;
            let first = input::frames(&mut *lighting, 0..1, SEED, true)?;
            input::frames(&mut *lighting, 0..2, SEED + 1, true)?;
            let seed = if random { SEED } else { SEED + 1 };
            let again = if faulty { 1..2 } else { 0..1 };
            let second = input::frames(&mut *lighting, again.clone(), seed, false)?;
            let third = alone.install(|| -> Result<_, SuiteError> {
                input::frames(&mut *given.lighting(&setting)?, again, seed, true)
            })?;
            for (((first, second), third), frame) in
                first.iter().zip(&second).zip(&third).zip(&given.world.frames)
            {
                tally.check(first.radiance == second.radiance, || format!("{setting}: again"));
                tally.check(first.radiance == third.radiance, || format!("{setting}: alone"));
                tally.check(first.work == third.work, || {
                    format!("{setting}: {:?} and {:?}", first.work, third.work)
                });
                tally.check(second.work == dapple_many_lights::Work::default(), || {
                    format!("{setting}: counts {:?} unasked", second.work)
                });
                let there = frame.points.iter().filter(|p| p.is_there()).count() as u64;
                tally.check(first.work.pixels == there, || {
                    format!("{setting}: {} of {there} pixels", first.work.pixels)
                });
            }
        }
    }
    Ok(tally)
}
