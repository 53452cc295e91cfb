//! Techniques that ask, and answers that lead them astray.

use super::{
    asked::{Asked, Fault},
    input, play,
};
use crate::{
    SuiteError,
    problem::Form,
    problems::camera_visibility::{SPEC, case::VisibilityCase, settings},
    verify::{About, Gate, GateContext, Tally, gate},
};
use dapple_occlusion::camera::{
    Bounds, Frame, Query, Readiness, Renderer, Results, Settings, State, Technique, TightBounds,
    View, techniques,
};
use rand::RngExt;
use rand_pcg::Pcg64;

/// Worlds of a gate.
const CASES: u32 = 8;

/// Techniques that ask.
pub const ASKS: [Technique; 3] = [Technique::StopAndWait, Technique::Chc, Technique::ChcPlusPlus];

pub fn gates() -> Vec<Gate> {
    let about = |technique: Technique, name, statement, fault| About {
        technique: technique.name(),
        name,
        statement,
        fault,
    };
    let reversed = ASKS.map(|technique| {
        gate(
            about(
                technique,
                "P20 depth test",
                "an answer counts what is at least as near as what is drawn, so nothing that shows \
                 is missing",
                "samples pass behind what is drawn",
            ),
            move |context, faulty| {
                let fault = faulty.then_some(Fault::Reversed);
                images(technique, context, faulty, fault, Results::SameFrame)
            },
        )
    });
    let late = [Technique::Chc, Technique::ChcPlusPlus].map(|technique| {
        gate(
            about(
                technique,
                "P20 same frame",
                "what an answer shows is drawn in the frame that asked",
                "answers count from the next frame on",
            ),
            move |context, faulty| {
                let results = if faulty { Results::NextFrame } else { Results::SameFrame };
                images(technique, context, faulty, None, results)
            },
        )
    });
    let groups = gate(
        about(
            Technique::ChcPlusPlus,
            "P22 groups",
            "of nodes that are asked together and show nothing, none shows anything by itself",
            "of several boxes, the first alone is looked at",
        ),
        groups,
    );
    reversed.into_iter().chain(late).chain([groups]).collect()
}

/// Exact settings of a technique and a latency.
pub fn random(
    rng: &mut Pcg64,
    technique: Technique,
    case: &VisibilityCase<'_>,
) -> Result<(Settings, u32), SuiteError> {
    let declared = SPEC.technique(technique.name())?;
    let setting = input::setting(rng, declared, Form::Reference, case, true);
    let latency = match settings::readiness(&setting)? {
        Readiness::Modelled(latency) => latency,
        Readiness::Polled => 0,
    };
    Ok((settings::asks(&setting, technique, rng.random())?, latency))
}

/// Draws the frames of a path, given by index, one after the other.
///
/// # Errors
/// The renderer's, or those of `look`.
pub fn along(
    case: &VisibilityCase<'_>,
    settings: &Settings,
    renderer: &mut Asked,
    frames: impl IntoIterator<Item = usize>,
    mut look: impl FnMut(usize, &Asked, &Frame, &State) -> Result<(), SuiteError>,
) -> Result<(), SuiteError> {
    let tree = case.tree("auto")?;
    let (mut state, mut out) = (State::new(&tree), Frame::default());
    for index in frames {
        let view = &case.views()[index];
        techniques::frame(settings, case.objects(), &tree, view, &mut state, renderer, &mut out)?;
        look(index, renderer, &out, &state)?;
    }
    Ok(())
}

/// Pixels in which the last frame is deeper or nearer than when everything is drawn.
///
/// # Errors
/// None for objects that were drawn before.
pub fn wrong(
    case: &VisibilityCase<'_>,
    index: usize,
    renderer: &Asked,
) -> Result<usize, SuiteError> {
    let full = case.everything(Form::Reference)?;
    let differ = |(a, b): &(&f32, &f32)| a.to_bits() != b.to_bits();
    Ok(renderer.image().depth.iter().zip(&full[index].depth).filter(differ).count())
}

fn images(
    technique: Technique,
    context: &GateContext<'_>,
    faulty: bool,
    fault: Option<Fault>,
    results: Results,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..play::cases(context, CASES, faulty) {
        let case = input::case(context.seed, number, None)?;
        let mut rng = input::rng(context.seed, technique.name(), number);
        let (settings, latency) = random(&mut rng, technique, &case)?;
        let settings = Settings { results, ..settings };
        let mut renderer = Asked::new(case.shared_objects(), latency, fault)?;
        along(&case, &settings, &mut renderer, 0..case.views().len(), |index, renderer, _, _| {
            let wrong = wrong(&case, index, renderer)? as f64;
            tally.within(wrong, 0.0, || format!("world {number}, frame {index}, {settings:?}"));
            Ok(())
        })?;
    }
    Ok(tally)
}

fn groups(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..play::cases(context, CASES, faulty) {
        let case = input::case(context.seed, number, None)?;
        let mut rng = input::rng(context.seed, "groups", number);
        let (settings, latency) = random(&mut rng, Technique::ChcPlusPlus, &case)?;
        let settings = Settings {
            multiqueries: true,
            batch: settings.batch.max(20),
            tight_bounds: TightBounds::OFF,
            ..settings
        };
        let fault = faulty.then_some(Fault::FirstBoxOnly);
        let mut renderer = Asked::new(case.shared_objects(), latency, fault)?;
        along(&case, &settings, &mut renderer, 0..case.views().len(), |_, _, _, _| Ok(()))?;
        let mut threes = Asked::new(case.shared_objects(), latency, fault)?;
        for view in case.views() {
            ask_threes(&case, view, &mut threes)?;
        }
        tally.checked += (renderer.hidden_groups + threes.hidden_groups).saturating_sub(1);
        let wrong = renderer.wrong_groups + threes.wrong_groups;
        tally.within(wrong as f64, 0.0, || format!("groups of world {number}, {settings:?}"));
    }
    Ok(tally)
}

/// Draws every other object and asks about the boxes of three at a time: such groups hold what
/// shows beside what does not more often than those of a technique.
fn ask_threes(
    case: &VisibilityCase<'_>,
    view: &View,
    renderer: &mut Asked,
) -> Result<(), SuiteError> {
    let objects = &case.objects().objects;
    let drawn: Vec<u32> = (0..objects.len() as u32).step_by(2).collect();
    let may_be_asked = |b: &Bounds| view.sees(b) && !view.touches(b);
    let boxes: Vec<Bounds> = objects.iter().map(|o| o.bounds).filter(may_be_asked).collect();
    let threes = 0..boxes.len() as u32 / 3;
    let queries: Vec<Query> = threes.map(|i| Query { boxes: 3 * i..3 * i + 3 }).collect();
    renderer.begin(view)?;
    renderer.draw(&drawn)?;
    if !queries.is_empty() {
        renderer.ask(&boxes, &queries)?;
        renderer.collect(&mut Vec::new())?;
    }
    Ok(renderer.end()?)
}
