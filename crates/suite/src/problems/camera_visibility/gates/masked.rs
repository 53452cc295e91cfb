//! Masked culling: the buffer never hides what shows, whatever it is fed with.

use super::{input, play};
use crate::{
    SuiteError,
    problem::Form,
    problems::camera_visibility::case::VisibilityCase,
    verify::{About, Gate, GateContext, Tally, gate},
};
use dapple_occlusion::camera::{
    Frame, Readiness,
    masked::{self, Culler, Occluders},
    software::Fast,
};
use std::sync::Arc;

/// Cities of a gate.
const CASES: u32 = 8;

const ID: &str = "masked";

/// The right ways to feed it.
const SOUND: [Occluders; 2] = [Occluders::InnerBoxes, Occluders::Meshes];

pub fn gates() -> Vec<Gate> {
    let outer = "the boxes around objects are the occluders";
    let about = |name, statement, fault| About { technique: ID, name, statement, fault };
    vec![
        gate(
            about(
                "buffer conservative",
                "at every pixel the buffer shows what is as near as what everything drawn shows",
                outer,
            ),
            conservative,
        ),
        gate(
            about(
                "P20 occluders",
                "in cities that are turned, boxes within buildings and the buildings themselves \
                 hide nothing that shows, in buffers of any size",
                outer,
            ),
            images,
        ),
        gate(
            about(
                "cpu port",
                "the fast buffer answers as the reference does at every pixel and depth",
                "the fast buffer is drawn with half the occluders",
            ),
            port,
        ),
    ]
}

/// Draws a frame; gives the culler and whether its image is that of everything.
fn frame(
    case: &VisibilityCase<'_>,
    settings: masked::Settings,
    index: usize,
) -> Result<(Culler, bool), SuiteError> {
    let (objects, tree) = (case.objects(), case.tree("auto")?);
    let mut culler = Culler::new(settings, objects, case.inner().unwrap_or_default())?;
    let mut renderer = Fast::new(Arc::clone(case.shared_objects()), Readiness::Modelled(0))?;
    let view = &case.views()[index];
    culler.frame(objects, &tree, view, &mut renderer, &mut Frame::default())?;
    let full = case.everything(Form::Cpu)?;
    Ok((culler, renderer.image().depth == full[index].depth))
}

fn settings(occluders: Occluders, columns: Option<u32>) -> masked::Settings {
    masked::Settings { form: masked::Form::Fast, occluders, columns, most_triangles: u64::MAX }
}

fn occluders(faulty: bool) -> &'static [Occluders] {
    if faulty { &[Occluders::OuterBoxesUnsound] } else { &SOUND }
}

fn conservative(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..play::cases(context, CASES, faulty) {
        let case = input::city_case(context.seed, number, None)?;
        // The reference snaps nothing: what it shows may lie on the other side of an edge.
        for form in [Form::Cpu, Form::Reference] {
            let full = case.everything(form)?;
            for index in (0..case.views().len()).step_by(2) {
                for occluders in occluders(faulty) {
                    let (culler, _) = frame(&case, settings(*occluders, None), index)?;
                    for (pixel, depth) in (0..).zip(&full[index].depth) {
                        let (x, y): (u32, u32) = (pixel % input::WIDTH, pixel / input::WIDTH);
                        let shows = culler.buffer().shows([x, x + 1], [y, y + 1], *depth);
                        tally.check(shows, || {
                            format!("city {number}, frame {index}, {occluders:?}: pixel {x}, {y}")
                        });
                    }
                }
            }
        }
    }
    Ok(tally)
}

fn images(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..play::cases(context, CASES, faulty) {
        let case = input::city_case(context.seed, 2 * number + 1, None)?;
        for index in 0..case.views().len() {
            for (occluders, columns) in occluders(faulty).iter().zip([None, Some(37)]) {
                let (_, same) = frame(&case, settings(*occluders, columns), index)?;
                tally.check(same, || {
                    format!("city {number}, frame {index}, {occluders:?}, {columns:?} columns")
                });
            }
        }
    }
    Ok(tally)
}

fn port(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..play::cases(context, CASES, faulty) {
        let case = input::city_case(context.seed, number, None)?;
        for index in (0..case.views().len()).step_by(2) {
            for occluders in SOUND {
                let slow =
                    masked::Settings { form: masked::Form::Reference, ..settings(occluders, None) };
                let (slow, _) = frame(&case, slow, index)?;
                let most = if faulty { slow.occluder_triangles() / 2 } else { u64::MAX };
                let fast = masked::Settings { most_triangles: most, ..settings(occluders, None) };
                let (fast, _) = frame(&case, fast, index)?;
                let full = case.everything(Form::Cpu)?;
                for (pixel, depth) in (0..).zip(&full[index].depth) {
                    let (x, y): (u32, u32) = (pixel % input::WIDTH, pixel / input::WIDTH);
                    for depth in [0.0, 0.5 * depth, 0.9 * depth, 0.99 * depth, 0.999 * depth] {
                        let shows = |c: &Culler| c.buffer().shows([x, x + 1], [y, y + 1], depth);
                        tally.check(shows(&fast) == shows(&slow), || {
                            format!("city {number}, frame {index}, {occluders:?}: pixel {x}, {y}")
                        });
                    }
                }
            }
        }
    }
    Ok(tally)
}
