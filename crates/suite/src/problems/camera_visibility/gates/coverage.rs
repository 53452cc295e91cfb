//! Stored coverage, and the view cells that it leads to.

use super::{
    ALL,
    asked::{Asked, Fault},
    input, play, questions,
};
use crate::{
    SuiteError,
    problems::camera_visibility::case::VisibilityCase,
    verify::{About, Gate, GateContext, Tally, gate},
};
use dapple_occlusion::camera::{
    CellLimits, Coverage, Image, Settings, Technique, Tree, exact_coverage, software, view_cells,
};

/// Worlds of a gate.
const CASES: u32 = 6;

pub fn gates() -> Vec<Gate> {
    let about = |technique: &'static str, name, statement, fault| About {
        technique,
        name,
        statement,
        fault,
    };
    let leaves = questions::ASKS.map(|technique| {
        gate(
            about(
                technique.name(),
                "P23 leaves",
                "what was asked in this frame, or of a view that rests, covers at least the pixels \
                 that it owns",
                "answers tell none from some",
            ),
            move |context, faulty| leaves(technique, context, faulty),
        )
    });
    let rest = [
        gate(
            about(
                Technique::Chc.name(),
                "P23 sums",
                "what an inner node in sight covers is the sum of its children, and no less than it \
                 owns",
                "the largest child instead of the sum",
            ),
            sums,
        ),
        gate(
            about(
                ALL,
                "row 11 histogram",
                "exact coverage is the number of pixels that each node's objects own",
                "objects are counted as the ones behind them in the list",
            ),
            histogram,
        ),
        gate(
            about(
                ALL,
                "row 14 cells",
                "every visible object falls into exactly one view cell, that of a node that holds it",
                "the first object of each cell is given to the next",
            ),
            cells,
        ),
        gate(
            about(
                ALL,
                "row 14 threshold",
                "the number of view cells falls as their threshold rises, down to one",
                "nodes that cover more than the threshold are not divided, as the text has it",
            ),
            threshold,
        ),
    ];
    leaves.into_iter().chain(rest).collect()
}

/// Pixels that each node owns of an image.
fn owned(case: &VisibilityCase<'_>, tree: &Tree, image: &Image) -> Vec<u32> {
    let pixels = software::owners(image, case.objects().objects.len());
    let of = |node: u32| tree.objects_of(node).iter().map(|o| pixels[*o as usize]).sum();
    (0..tree.nodes.len() as u32).map(of).collect()
}

/// Frames to draw, and the first to look at: techniques that ask of everything in sight are looked
/// at in each, those that do not once the view rests.
fn frames(settings: &Settings, count: usize) -> (Vec<usize>, usize) {
    let mut frames: Vec<usize> = (0..count).collect();
    if settings.technique != Technique::ChcPlusPlus {
        return (frames, 0);
    }
    frames.extend(vec![count - 1; settings.assumed_visible as usize + 2]);
    let last = frames.len() - 1;
    (frames, last)
}

fn leaves(
    technique: Technique,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..play::cases(context, CASES, faulty) {
        let case = input::case(context.seed, number, None)?;
        let mut rng = input::rng(context.seed, "leaves", number);
        let (settings, latency) = questions::random(&mut rng, technique, &case)?;
        let settings = Settings {
            coverage: Coverage::Stale,
            assumed_visible: settings.assumed_visible.min(4),
            ..settings
        };
        let fault = faulty.then_some(Fault::Boolean);
        let mut renderer = Asked::new(case.shared_objects(), latency, fault)?;
        let tree = case.tree("auto")?;
        let (frames, first) = frames(&settings, case.views().len());
        let mut frame = 0;
        questions::along(&case, &settings, &mut renderer, frames, |_, renderer, _, state| {
            frame += 1;
            if frame <= first {
                return Ok(());
            }
            let owned = owned(&case, &tree, renderer.image());
            for node in (0..tree.nodes.len() as u32).filter(|n| tree.is_leaf(*n)) {
                let (stored, owned) = (state.coverage()[node as usize], owned[node as usize]);
                tally.check(stored >= owned, || {
                    format!("world {number}, node {node}: {stored} stored, {owned} owned")
                });
            }
            Ok(())
        })?;
    }
    Ok(tally)
}

fn sums(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..play::cases(context, CASES, faulty) {
        let case = input::case(context.seed, number, None)?;
        let settings = Settings { coverage: Coverage::Summed, ..Settings::new(Technique::Chc) };
        let mut renderer = Asked::new(case.shared_objects(), 20, None)?;
        let tree = case.tree("auto")?;
        let frames = 0..case.views().len();
        questions::along(&case, &settings, &mut renderer, frames, |index, renderer, _, state| {
            let owned = owned(&case, &tree, renderer.image());
            let mut coverage = state.coverage().to_vec();
            let inner = (0..tree.nodes.len()).rev().filter(|n| !tree.is_leaf(*n as u32));
            let visible = |n: &usize| state.nodes()[*n].visible == state.frames();
            for node in inner.filter(visible) {
                let children = tree.nodes[node].children.clone();
                let children: Vec<u32> = children.map(|child| coverage[child as usize]).collect();
                if faulty {
                    coverage[node] = children.iter().copied().max().unwrap_or(0);
                }
                let (stored, sum) =
                    (coverage[node], children.into_iter().fold(0, u32::saturating_add));
                tally.check(stored == sum && stored >= owned[node], || {
                    let owned = owned[node];
                    format!(
                        "world {number}, frame {index}, node {node}: {stored} stored, children \
                         {sum}, owned {owned}"
                    )
                });
            }
            Ok(())
        })?;
    }
    Ok(tally)
}

fn histogram(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..play::cases(context, CASES, faulty) {
        let case = input::case(context.seed, number, None)?;
        let tree = case.tree("bottom-up")?;
        let full = case.everything(crate::problem::Form::Cpu)?;
        for image in full.iter() {
            let mut pixels = software::owners(image, case.objects().objects.len());
            if faulty {
                pixels.rotate_left(1);
            }
            let mut stored = vec![0; tree.nodes.len()];
            exact_coverage(&tree, &pixels, &mut stored)?;
            for (node, (stored, owned)) in stored.iter().zip(owned(&case, &tree, image)).enumerate()
            {
                tally.check(*stored == owned, || {
                    format!("world {number}, node {node}: {stored} stored, {owned} owned")
                });
            }
        }
    }
    Ok(tally)
}

/// A tree, the coverage of its nodes and what was drawn: the last frame of a path by CHC++.
type Drawn = (std::rc::Rc<Tree>, Vec<u32>, Vec<u32>);

fn last_frame(seed: u64, number: u32) -> Result<Drawn, SuiteError> {
    let case = input::case(seed, number, None)?;
    let settings = Settings { coverage: Coverage::Summed, ..Settings::new(Technique::ChcPlusPlus) };
    let mut renderer = Asked::new(case.shared_objects(), 20, None)?;
    let (mut coverage, mut drawn) = (Vec::new(), Vec::new());
    questions::along(
        &case,
        &settings,
        &mut renderer,
        0..case.views().len(),
        |_, _, out, state| {
            coverage = state.coverage().to_vec();
            drawn.clone_from(&out.drawn);
            Ok(())
        },
    )?;
    Ok((case.tree("auto")?, coverage, drawn))
}

const THRESHOLDS: [u32; 7] = [0, 4, 16, 64, 256, 1024, u32::MAX];

fn cells(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..play::cases(context, CASES, faulty) {
        let (tree, coverage, mut drawn) = last_frame(context.seed, number)?;
        drawn.sort_unstable();
        for tau_px in THRESHOLDS {
            let limits = CellLimits { tau_px, most_level: u32::MAX };
            let found = view_cells(&tree, &coverage, &tree.levels(), &drawn, limits)?;
            let mut in_cells = Vec::new();
            for (index, cell) in found.cells.iter().enumerate() {
                let mut objects = found.objects_of(index).to_vec();
                if faulty && found.cells.len() > 1 {
                    objects[0] = found.objects_of((index + 1) % found.cells.len())[0];
                }
                let below = tree.objects_of(cell.node);
                tally.check(objects.iter().all(|o| below.contains(o)), || {
                    format!("world {number}, threshold {tau_px}: node {} holds others", cell.node)
                });
                in_cells.extend(objects);
            }
            in_cells.sort_unstable();
            tally.check(in_cells == drawn, || {
                format!("world {number}, threshold {tau_px}: {in_cells:?} for {drawn:?}")
            });
        }
    }
    Ok(tally)
}

fn threshold(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..play::cases(context, CASES, faulty) {
        let (tree, coverage, drawn) = last_frame(context.seed, number)?;
        let mut counts = Vec::new();
        for tau_px in THRESHOLDS {
            let limits = CellLimits { tau_px, most_level: u32::MAX };
            let cells = view_cells(&tree, &coverage, &tree.levels(), &drawn, limits)?;
            // Left to itself the text's rule stops where it begins: the root covers most of all.
            let literal = usize::from(coverage[0] > tau_px);
            counts.push(if faulty && literal == 1 { 1 } else { cells.cells.len() });
        }
        let falls = counts.is_sorted_by(|a, b| a >= b) && counts.last() == Some(&1);
        let divided = counts[0] > 1 || drawn.len() < 2;
        tally.check(falls && divided, || format!("world {number}: {counts:?} cells"));
    }
    Ok(tally)
}
