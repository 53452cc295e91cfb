//! What holds for every technique that the problem declares.

use super::{
    ALL,
    play::{self, Shown},
};
use crate::{
    SuiteError,
    problem::{Form, Technique},
    problems::camera_visibility::{SPEC, port},
    verify::{About, Gate, GateContext, Tally, gate},
};
use dapple_gpu::Gpu;
use dapple_occlusion::camera::{Image, software};
use std::collections::BTreeMap;

/// Worlds of a gate.
const CASES: u32 = 12;

/// Forms that run without a device.
const SOFTWARE: [Form; 2] = [Form::Reference, Form::Cpu];

/// What is looked at in each frame.
type Look = fn(&Shown<'_, '_>, bool, &mut Tally) -> Result<(), SuiteError>;

/// A statement, its fault and how to tell.
struct Shared {
    name: &'static str,
    on_device: &'static str,
    statement: &'static str,
    fault: &'static str,
    look: Look,
}

const SHARED: &[Shared] = &[
    Shared {
        name: "P20 image",
        on_device: "P20 gpu image",
        statement: "whatever the knobs, the path and the world, nothing is nearer than when \
                    everything is drawn, and in exact modes nothing deeper",
        fault: "what owns most pixels is left out",
        look: image,
    },
    Shared {
        name: "P21 truth",
        on_device: "P21 gpu truth",
        statement: "in exact modes, what owns a pixel by rays beyond rounding is drawn",
        fault: "what owns most pixels is left out",
        look: truth,
    },
    Shared {
        name: "drawn once",
        on_device: "gpu drawn once",
        statement: "no object is drawn twice in a frame",
        fault: "the first object is drawn again at the end",
        look: once,
    },
];

const INSIDE: Shared = Shared {
    name: "inside the frustum",
    on_device: "gpu inside the frustum",
    statement: "nothing is drawn that lies outside the frustum",
    fault: "the camera looks the other way",
    look: inside,
};

pub fn gates() -> Vec<Gate> {
    let mut gates = Vec::new();
    for (index, technique) in SPEC.techniques.iter().enumerate() {
        // The baseline draws everything.
        let inside = (index > 0).then_some(&INSIDE);
        for shared in SHARED.iter().chain(inside) {
            let Shared { name, statement, fault, look, .. } = *shared;
            gates.push(gate(
                About { technique: technique.id, name, statement, fault },
                move |context, faulty| {
                    let forms = SOFTWARE.into_iter().filter(|f| technique.forms.contains(f));
                    run(technique, &forms.collect::<Vec<_>>(), context, None, faulty, look)
                },
            ));
        }
    }
    gates.push(gate(
        About {
            technique: ALL,
            name: "exactness",
            statement: "every technique is exact in its default variant, but what is told the truth",
            fault: "the settings of answers that count from the next frame on",
        },
        exactness,
    ));
    gates
}

/// The same on a device, all at once.
pub fn device_gates() -> Vec<Gate> {
    let has = |t: &&Technique| t.forms.contains(&Form::Gpu);
    let gates = SPEC.techniques.iter().filter(has).flat_map(|technique| {
        SHARED.iter().take(2).map(move |shared| {
            let Shared { on_device, statement, fault, look, .. } = *shared;
            let about = About { technique: technique.id, name: on_device, statement, fault };
            let check = move |context: &GateContext<'_>, faulty| {
                let look: Look = look;
                run(technique, &[Form::Gpu], context, context.gpu, faulty, look)
            };
            Gate { needs_gpu: true, ..gate(about, check) }
        })
    });
    gates.collect()
}

fn run(
    technique: &Technique,
    forms: &[Form],
    context: &GateContext<'_>,
    gpu: Option<&Gpu>,
    faulty: bool,
    look: Look,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    // A batch of questions to a device is a submission.
    let most = if gpu.is_some() { 2 } else { CASES };
    let cases = play::cases(context, most, faulty);
    play::along(technique, forms, context, cases, gpu, |shown| look(shown, faulty, &mut tally))?;
    Ok(tally)
}

/// What owns most pixels of an image.
fn largest(image: &Image, objects: usize) -> Option<u32> {
    let pixels = software::owners(image, objects);
    (0..objects as u32).filter(|o| pixels[*o as usize] > 0).max_by_key(|o| pixels[*o as usize])
}

fn without_largest(shown: &Shown<'_, '_>) -> Vec<u32> {
    let largest = largest(shown.image, shown.case.objects().objects.len());
    shown.drawn.iter().copied().filter(|o| Some(*o) != largest).collect()
}

fn image(shown: &Shown<'_, '_>, faulty: bool, tally: &mut Tally) -> Result<(), SuiteError> {
    let all = shown.case.everything(shown.setting.form)?;
    let full = &all[shown.index];
    let found = match faulty {
        true => port::differences(&play::draw(shown, &without_largest(shown))?, full),
        false => port::differences(shown.image, full),
    };
    let what = |kind| format!("pixels that are {kind}, {}", shown.name());
    tally.within(found.nearer as f64, 0.0, || what("nearer"));
    if shown.exact {
        tally.within(found.deeper as f64, 0.0, || what("deeper"));
    } else if shown.setting.technique == "oracle" {
        // Rays and rasteriser agree where rounding cannot tell them apart.
        let truth = &shown.case.truth().frames[shown.index];
        let sure: u64 = truth.iter().map(|o| u64::from(o.sure)).sum();
        let covered = full.ids.iter().filter(|id| id[0] > 0).count() as u64;
        let unsure = covered.saturating_sub(sure);
        tally.within(found.deeper as f64, unsure as f64, || what("deeper"));
    }
    Ok(())
}

fn truth(shown: &Shown<'_, '_>, faulty: bool, tally: &mut Tally) -> Result<(), SuiteError> {
    if !shown.exact && shown.setting.technique != "oracle" {
        return Ok(());
    }
    let drawn = if faulty { without_largest(shown) } else { shown.drawn.to_vec() };
    for owned in shown.case.truth().frames[shown.index].iter().filter(|o| o.sure > 0) {
        tally.check(drawn.contains(&owned.object), || {
            format!("object {} owns {} pixels, {}", owned.object, owned.sure, shown.name())
        });
    }
    Ok(())
}

fn once(shown: &Shown<'_, '_>, faulty: bool, tally: &mut Tally) -> Result<(), SuiteError> {
    let again = shown.drawn.first().filter(|_| faulty);
    let drawn: Vec<u32> = shown.drawn.iter().chain(again).copied().collect();
    let twice = port::twice(&drawn);
    tally.check(twice.is_none(), || format!("object {twice:?}, {}", shown.name()));
    Ok(())
}

fn inside(shown: &Shown<'_, '_>, faulty: bool, tally: &mut Tally) -> Result<(), SuiteError> {
    let mut view = shown.view().clone();
    if faulty {
        view.planes = view.planes.map(|plane| -plane);
    }
    for object in shown.drawn {
        let bounds = &shown.case.objects().objects[*object as usize].bounds;
        tally.check(view.sees(bounds), || format!("object {object}, {}", shown.name()));
    }
    Ok(())
}

fn exactness(_: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    use super::input;
    let mut tally = Tally::default();
    let case = input::case(0, 1, None)?;
    let mut exact = BTreeMap::new();
    for technique in SPEC.techniques {
        let mut setting = input::default_setting(technique, Form::Cpu, &[])?;
        if faulty && technique.variants.len() > 1 {
            setting.variant = technique.variants[1].id.into();
        }
        let method = super::super::method::Method::of(&case, &setting)?;
        exact.insert(technique.id, method.is_exact() || method.is_told());
    }
    for (id, exact) in exact {
        tally.check(exact, || format!("{id} is approximate"));
    }
    Ok(tally)
}
