//! The renderer on a device: ids, ways of drawing and of counting.

use super::{ALL, input, play, questions::ASKS, renderers};
use crate::{
    SuiteError,
    problem::Form,
    problems::camera_visibility::{case::VisibilityCase, settings},
    verify::{About, Gate, GateContext, Tally, gate},
};
use dapple_gpu::Gpu;
use dapple_occlusion::camera::{
    Bounds, Frame, Image, Query, Readiness, Renderer, State,
    gpu::{self, Counting, Drawing, Fault, Settings},
    techniques,
};
use dapple_scene::city::{self, Knobs};

pub fn gates() -> Vec<Gate> {
    let about = |name, statement, fault| About { technique: ALL, name, statement, fault };
    let mut gates = vec![
        on_device(
            about(
                "row 12 gpu ids",
                "every pixel's id is that of a triangle that covers it at that depth, and nothing \
                 that must cover it lies nearer",
                "ids and depths are moved by a pixel",
            ),
            |gpu, context, faulty| renderers::ids(&[Form::Gpu], context, Some(gpu), 4, faulty),
        ),
        on_device(
            about(
                "row 13 instances",
                "one call a template draws what one call an object and one call a quad draw, in a \
                 tenth of the calls",
                "instances are drawn one by one",
            ),
            instances,
        ),
        on_device(
            about(
                "gpu counting",
                "all ways of counting that the device has agree: atomics with queries, and what \
                 tells none from some with both",
                "samples pass behind what is drawn",
            ),
            counting,
        ),
    ];
    for technique in ASKS {
        let id = technique.name();
        gates.push(on_device(about_technique(id), move |gpu, context, faulty| {
            depth_test(id, gpu, context, faulty)
        }));
    }
    gates
}

fn about_technique(technique: &'static str) -> About {
    About {
        technique,
        name: "P20 gpu depth test",
        statement: "the device's answers count what is at least as near as what is drawn, so \
                    nothing that shows is missing",
        fault: "samples pass behind what is drawn",
    }
}

/// A gate that is given the device.
fn on_device(
    about: About,
    check: impl Fn(&Gpu, &GateContext<'_>, bool) -> Result<Tally, SuiteError>
    + Copy
    + Send
    + Sync
    + 'static,
) -> Gate {
    let gated = gate(about, move |context, faulty| match context.gpu {
        Some(gpu) => check(gpu, context, faulty),
        None => Ok(Tally::default()),
    });
    Gate { needs_gpu: true, ..gated }
}

const NOW: Readiness = Readiness::Modelled(0);

/// A frame of everything, and the calls that it took.
fn everything(
    gpu: &Gpu,
    case: &VisibilityCase<'_>,
    drawing: Drawing,
) -> Result<(Image, u64), SuiteError> {
    let scene = gpu::Scene::new(gpu, case.objects())?;
    let settings = Settings { drawing, counting: Counting::Auto, readiness: NOW };
    let mut renderer = gpu::Renderer::new(gpu, &scene, settings)?;
    let all: Vec<u32> = (0..case.objects().objects.len() as u32).collect();
    renderer.begin(&case.views()[0])?;
    renderer.draw(&all)?;
    renderer.end()?;
    Ok((renderer.image()?, renderer.counters().draw_calls))
}

fn instances(gpu: &Gpu, context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let knobs = Knobs { blocks_x: 2, blocks_z: 1, ..Knobs::default() };
    let city = city::generate(&knobs, context.seed)?;
    let made = city.scene();
    let case = input::of(made.scene, Some((city, made.parts)), 0, &[("frames", 1)], None)?;
    let drawing = if faulty { Drawing::PerObject } else { Drawing::Instanced };
    let (instanced, few) = everything(gpu, &case, drawing)?;
    for drawing in [Drawing::PerObject, Drawing::PerQuad] {
        let (plain, many) = everything(gpu, &case, drawing)?;
        let wrong = plain.depth.iter().zip(&instanced.depth).filter(|(a, b)| a != b).count();
        tally.within(wrong as f64, 0.0, || format!("pixels differ from {drawing:?}"));
        tally.check(10 * few <= many, || format!("{few} calls, {drawing:?}: {many}"));
    }
    Ok(tally)
}

fn counting(gpu: &Gpu, context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let ways = [Counting::Atomic, Counting::Query, Counting::Boolean];
    let there = |counting: &Counting| counting.on(&gpu.abilities).is_ok();
    for number in 0..play::cases(context, 3, faulty) {
        let case = input::case(context.seed, number, None)?;
        let scene = gpu::Scene::new(gpu, case.objects())?;
        let view = &case.views()[0];
        let boxes: Vec<Bounds> = case.objects().objects.iter().map(|o| o.bounds).collect();
        let boxes: Vec<Bounds> =
            boxes.into_iter().filter(|b| view.sees(b) && !view.touches(b)).collect();
        let queries: Vec<Query> =
            (0..boxes.len() as u32).map(|i| Query { boxes: i..i + 1 }).collect();
        let some: Vec<u32> = (0..case.objects().objects.len() as u32).step_by(3).collect();
        let mut counted: Vec<(Counting, Vec<u32>)> = Vec::new();
        for (index, counting) in ways.into_iter().filter(there).enumerate() {
            let settings = Settings { drawing: Drawing::Instanced, counting, readiness: NOW };
            let mut renderer = match faulty && index == 0 {
                true => gpu::Renderer::with_fault(gpu, &scene, settings, Fault::ReversedQuery)?,
                false => gpu::Renderer::new(gpu, &scene, settings)?,
            };
            renderer.begin(view)?;
            renderer.draw(&some)?;
            renderer.ask(&boxes, &queries)?;
            let mut counts = Vec::new();
            renderer.collect(&mut counts)?;
            renderer.end()?;
            counted.push((counting, counts));
        }
        let Some(((first, exact), others)) = counted.split_first() else { continue };
        for (way, counts) in others {
            for (i, (count, exact)) in counts.iter().zip(exact).enumerate() {
                let exact = if *way == Counting::Boolean { (*exact).min(1) } else { *exact };
                tally.check(*count == exact, || {
                    format!("world {number}, box {i}: {way:?} {count}, {first:?} {exact}")
                });
            }
        }
    }
    Ok(tally)
}

fn depth_test(
    id: &'static str,
    gpu: &Gpu,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..play::cases(context, 1, faulty) {
        let case = input::case(context.seed, number, Some(gpu))?;
        let technique = crate::problems::camera_visibility::SPEC.technique(id)?;
        let setting = input::default_setting(technique, Form::Gpu, &[])?;
        let Some(asks) = dapple_occlusion::camera::Technique::by_name(id) else { continue };
        let asks = settings::asks(&setting, asks, context.seed)?;
        let scene = gpu::Scene::new(gpu, case.objects())?;
        let settings = settings::device(&setting)?;
        let mut renderer = match faulty {
            true => gpu::Renderer::with_fault(gpu, &scene, settings, Fault::ReversedQuery)?,
            false => gpu::Renderer::new(gpu, &scene, settings)?,
        };
        let tree = case.tree("auto")?;
        let (mut state, mut out) = (State::new(&tree), Frame::default());
        let full = case.everything(Form::Gpu)?;
        for (index, view) in case.views().iter().enumerate() {
            let objects = case.objects();
            techniques::frame(&asks, objects, &tree, view, &mut state, &mut renderer, &mut out)?;
            let image = renderer.image()?;
            let wrong = image.depth.iter().zip(&full[index].depth).filter(|(a, b)| a != b).count();
            tally.within(wrong as f64, 0.0, || format!("world {number}, frame {index}"));
        }
    }
    Ok(tally)
}
