//! What draws, by every triangle at every pixel; and what it answers.

use super::{ALL, input, judge, play};
use crate::{
    SuiteError,
    problem::Form,
    problems::camera_visibility::{case::VisibilityCase, drawer::Drawer},
    verify::{About, Gate, GateContext, Tally, gate},
};
use dapple_occlusion::camera::{Bounds, Image, Query, Readiness};

/// Worlds of a gate.
const CASES: u32 = 6;

pub fn gates() -> Vec<Gate> {
    let about = |name, statement, fault| About { technique: ALL, name, statement, fault };
    vec![
        gate(
            about(
                "row 12 ids",
                "every pixel's id is that of a triangle that covers it at that depth, and nothing \
                 that must cover it lies nearer, in both forms without a device",
                "ids and depths are moved by a pixel",
            ),
            |context, faulty| ids(&[Form::Reference, Form::Cpu], context, None, CASES, faulty),
        ),
        gate(
            about(
                "cpu port",
                "answers of the fast renderer differ from the reference's by 3 % of the boxes' \
                 samples at most: those beside a border",
                "samples pass that are farther than what is drawn",
            ),
            answers,
        ),
        gate(
            about(
                "boxes cover",
                "a box asked before its object is drawn shows at least the pixels that the object \
                 then owns",
                "the box is half as large",
            ),
            boxes,
        ),
    ]
}

/// The images of everything, by some forms.
///
/// # Errors
/// The device's.
pub fn ids(
    forms: &[Form],
    context: &GateContext<'_>,
    gpu: Option<&dapple_gpu::Gpu>,
    most: u32,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..play::cases(context, most, faulty) {
        let case = input::case(context.seed, number, gpu)?;
        for form in forms {
            let full = case.everything(*form)?;
            for (view, image) in case.views().iter().zip(full.iter()).step_by(3) {
                let mut image: Image = image.clone();
                if faulty {
                    image.ids.rotate_right(1);
                    image.depth.rotate_right(1);
                }
                let (faults, covered) = judge::faults(view, case.objects(), &image);
                tally.checked += covered;
                tally.check(faults.is_empty(), || {
                    format!("world {number}, {form}: {} pixels, {}", faults.len(), faults[0])
                });
            }
        }
    }
    Ok(tally)
}

/// Draws every third object and asks about the boxes of all.
fn ask(
    case: &VisibilityCase<'_>,
    form: Form,
    index: usize,
    drawn: &[u32],
    boxes: &[Bounds],
) -> Result<Vec<u32>, SuiteError> {
    let mut drawer = Drawer::software(case, form, Readiness::Modelled(0))?;
    let renderer = drawer.renderer()?;
    renderer.begin(&case.views()[index])?;
    renderer.draw(drawn)?;
    let one = |i: u32| Query { boxes: i..i + 1 };
    let queries: Vec<Query> = (0..boxes.len() as u32).map(one).collect();
    renderer.ask(boxes, &queries)?;
    let mut counts = Vec::new();
    renderer.collect(&mut counts)?;
    renderer.end()?;
    Ok(counts)
}

/// Boxes of objects that may be asked about.
fn askable(case: &VisibilityCase<'_>, index: usize) -> Vec<(u32, Bounds)> {
    let view = &case.views()[index];
    let objects = (0..).zip(&case.objects().objects).map(|(i, o)| (i, o.bounds));
    objects.filter(|(_, b)| view.sees(b) && !view.touches(b)).collect()
}

fn answers(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..play::cases(context, CASES, faulty) {
        let case = input::case(context.seed, number, None)?;
        for index in (0..case.views().len()).step_by(3) {
            let boxes: Vec<Bounds> = askable(&case, index).into_iter().map(|b| b.1).collect();
            let every_third: Vec<u32> =
                (0..case.objects().objects.len() as u32).step_by(3).collect();
            // Against nothing, all samples of a box pass.
            let drawn = if faulty { &[][..] } else { &every_third };
            let theirs = ask(&case, Form::Reference, index, &every_third, &boxes)?;
            let ours = ask(&case, Form::Cpu, index, drawn, &boxes)?;
            let samples = ask(&case, Form::Reference, index, &[], &boxes)?;
            // Borders of boxes and of what is drawn pass within a step of a few centres.
            let sum = |counts: &[u32]| counts.iter().map(|c| f64::from(*c)).sum::<f64>();
            let apart: Vec<u32> = ours.iter().zip(&theirs).map(|(a, b)| a.abs_diff(*b)).collect();
            tally.within(sum(&apart), 16.0 + 0.03 * sum(&samples), || {
                format!("world {number}, frame {index}: {ours:?}, reference {theirs:?}")
            });
        }
    }
    Ok(tally)
}

fn boxes(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..play::cases(context, CASES, faulty) {
        let case = input::case(context.seed, number, None)?;
        for form in [Form::Reference, Form::Cpu] {
            let full = case.everything(form)?;
            for index in (0..case.views().len()).step_by(3) {
                let objects = case.objects().objects.len();
                let owned = dapple_occlusion::camera::software::owners(&full[index], objects);
                let seen = askable(&case, index);
                let seen: Vec<_> = seen.iter().filter(|(o, _)| owned[*o as usize] > 0).collect();
                let boxes: Vec<Bounds> = seen
                    .iter()
                    .map(|(_, b)| {
                        let middle = b.centre();
                        let half = |p| middle + 0.5 * (p - middle);
                        if faulty { Bounds { min: half(b.min), max: half(b.max) } } else { *b }
                    })
                    .collect();
                // Against all others: what an object owns of the image shows of its box.
                let counts = seen.iter().zip(&boxes).map(|((object, _), asked)| {
                    let others: Vec<u32> = (0..objects as u32).filter(|o| o != object).collect();
                    ask(&case, form, index, &others, std::slice::from_ref(asked))
                });
                for ((object, _), count) in seen.iter().zip(counts) {
                    let (count, owned) = (count?[0], owned[*object as usize]);
                    tally.check(count >= owned, || {
                        format!(
                            "world {number}, {form}: object {object} owns {owned}, {count} show"
                        )
                    });
                }
            }
        }
    }
    Ok(tally)
}
