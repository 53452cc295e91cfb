//! Two-pass culling by hierarchical depth: the pyramid, and what it hides.

use super::{input, play};
use crate::{
    SuiteError,
    problem::Form,
    verify::{About, Gate, GateContext, Tally, gate},
};
use dapple_occlusion::camera::{
    Frame, Image, Readiness,
    hierarchical_depth::{Fault, Settings, Traversal, cpu, reference},
    software::Fast,
};
use rand::RngExt;
use std::sync::Arc;

/// Worlds of a gate.
const CASES: u32 = 8;

const ID: &str = "hierarchical-depth";

pub fn gates() -> Vec<Gate> {
    let about = |name, statement| About {
        technique: ID,
        name,
        statement,
        fault: "the pyramid takes the nearest depth",
    };
    vec![
        gate(
            about("pyramid", "every texel of every level is the farthest of its pixels"),
            |context, faulty| along(context, faulty, pyramid),
        ),
        gate(
            about("P20 farthest", "what lies behind the farthest depth of its rectangle is hidden"),
            |context, faulty| along(context, faulty, image),
        ),
        gate(
            about(
                "pyramid hides less",
                "what shows at a pixel of its rectangle, each of them looked at, is not hidden by \
                 the pyramid",
            ),
            |context, faulty| along(context, faulty, hides_less),
        ),
    ]
}

/// A frame, drawn by the pyramid and by looking at every pixel.
struct Both<'a> {
    depth: &'a [f32],
    state: &'a cpu::State,
    every_pixel: &'a reference::State,
    full: &'a Image,
}

fn along(
    context: &GateContext<'_>,
    faulty: bool,
    look: fn(&Both<'_>, &str, &mut Tally),
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..play::cases(context, CASES, faulty) {
        let case = input::case(context.seed, number, None)?;
        let mut rng = input::rng(context.seed, ID, number);
        let traversals = [Traversal::Flat, Traversal::Tree];
        let settings = Settings {
            traversal: traversals[rng.random_range(0..2_usize)],
            across: rng.random_range(1..9),
        };
        let (objects, tree) = (case.objects(), case.tree("auto")?);
        let mut state = match faulty {
            true => cpu::State::with_fault(objects, &tree, Fault::Nearest),
            false => cpu::State::new(objects, &tree),
        };
        let mut every_pixel = reference::State::new(objects);
        let renderer = || Fast::new(Arc::clone(case.shared_objects()), Readiness::Modelled(0));
        let (mut ours, mut theirs) = (renderer()?, renderer()?);
        let mut out = Frame::default();
        let full = case.everything(Form::Cpu)?;
        for (index, view) in case.views().iter().enumerate() {
            reference::frame(objects, view, &mut every_pixel, &mut theirs, &mut out)?;
            cpu::frame(&settings, objects, &tree, view, &mut state, &mut ours, &mut out)?;
            let both = Both {
                depth: &ours.image().depth,
                state: &state,
                every_pixel: &every_pixel,
                full: &full[index],
            };
            look(&both, &format!("world {number}, frame {index}, {settings:?}"), &mut tally);
        }
    }
    Ok(tally)
}

fn pyramid(both: &Both<'_>, what: &str, tally: &mut Tally) {
    let pyramid = both.state.pyramid();
    let Some(image) = pyramid.levels().first().copied() else {
        tally.check(false, || format!("{what}: no levels"));
        return;
    };
    for (k, level) in pyramid.levels().iter().enumerate() {
        let mut farthest = vec![f32::INFINITY; (level.width * level.height) as usize];
        for (pixel, depth) in (0..).zip(both.depth) {
            let (x, y): (u32, u32) = (pixel % image.width, pixel / image.width);
            let texel = &mut farthest[((y >> k) * level.width + (x >> k)) as usize];
            *texel = texel.min(*depth);
        }
        let stored = &pyramid.texels()[level.start as usize..][..farthest.len()];
        tally.check(stored == farthest, || format!("{what}: level {k}"));
    }
}

fn image(both: &Both<'_>, what: &str, tally: &mut Tally) {
    let wrong = both.depth.iter().zip(&both.full.depth).filter(|(a, b)| a != b).count();
    tally.within(wrong as f64, 0.0, || what.to_string());
}

fn hides_less(both: &Both<'_>, what: &str, tally: &mut Tally) {
    let shown = both.every_pixel.visible().iter().zip(both.state.visible());
    for (object, (by_pixel, by_pyramid)) in shown.enumerate() {
        tally.check(*by_pyramid || !by_pixel, || format!("{what}: object {object}"));
    }
}
