//! What each rule of a cut promises by itself.

use super::{
    ALL,
    cuts::{cut_by, method, worst_first},
    hard::{self, CLAMP_M, FORMS},
    input,
};
use crate::{
    SuiteError,
    problems::many_lights::SPEC,
    verify::{About, Gate, GateContext, Tally, gate},
};
use dapple_many_lights::{
    BoundForm, Lightcuts, Selection,
    cut::{Method, Receiver, Rule, recursion, walk},
};
use glam::DVec3;
use rand::RngExt;
use rand_pcg::Pcg64;

const ABSOLUTE: &str = "absolute-cut";
const LIGHTCUTS: &str = "lightcuts";

/// Trees for each case that is asked for.
const TIMES: u32 = 12;

/// Lights of a tree.
const LIGHTS: usize = 40;

/// Thresholds: none, the thesis's three, and more.
const THRESHOLDS: [f64; 6] = [0.0, 1.0 / 25_500.0, 1.0 / 1020.0, 1.0 / 255.0, 1.0, 1e9];

pub fn gates() -> Vec<Gate> {
    let about = |technique, name, statement, fault| About { technique, name, statement, fault };
    vec![
        gate(
            about(
                ALL,
                "row 38 walk",
                "a walk by skip counts looks at what recursion over children looks at, in its order",
                "the walk skips one node less than a subtree has",
            ),
            walked,
        ),
        gate(
            about(
                ABSOLUTE,
                "P15 nested",
                "a smaller threshold refines a cut: each node lies in or below one of the coarser cut",
                "the two cuts are exchanged",
            ),
            nested,
        ),
        gate(
            about(
                ABSOLUTE,
                "row 43 threshold",
                "no cluster of a cut is bounded by more than the threshold",
                "the cut is one of twice the threshold",
            ),
            threshold,
        ),
        gate(
            about(
                LIGHTCUTS,
                "P17 epsilon",
                "no cluster of a cut is bounded by more than its share of the estimate, unless the \
                 cut's size ended it",
                "the cut is one of four times the share",
            ),
            epsilon,
        ),
        gate(
            about(
                LIGHTCUTS,
                "row 41 scan",
                "looking at every node for the worst makes the cut that a heap makes",
                "the scan's share of the estimate is half as large",
            ),
            scan,
        ),
    ]
}

fn walked(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..context.cases * TIMES {
        let case = hard::case(context.seed, "walk", number, LIGHTS)?;
        let mut rng = input::rng(context.seed, "rule", number);
        let rule = match rng.random_bool(0.5) {
            true => Rule::Absolute(THRESHOLDS[rng.random_range(0..THRESHOLDS.len())]),
            false => Rule::Relative(rng.random_range(0.0..2.0)),
        };
        let form = FORMS[rng.random_range(0..2)];
        let receiver = Receiver { point: &case.point, form, clamp_m: CLAMP_M };
        let mut stepped = case.tree.clone();
        if faulty {
            stepped.nodes.iter_mut().filter(|n| n.size > 2).for_each(|node| node.size -= 1);
        }
        let (mut walked, mut recursed) = (Vec::new(), Vec::new());
        walk(&stepped, &stepped.roots, |index, node| {
            let look = rule.look(node, &receiver);
            walked.push((index, look));
            look.taken
        });
        for &root in &case.tree.roots {
            recursion(&case.tree, root, &mut |index, node| {
                let look = rule.look(node, &receiver);
                recursed.push((index, look));
                look.taken
            });
        }
        tally.check(walked == recursed, || {
            format!("case {number}: {} and {} nodes", walked.len(), recursed.len())
        });
    }
    Ok(tally)
}

/// A case's cut by a threshold.
fn by_threshold(case: &hard::Case, threshold: f64, form: BoundForm) -> Vec<(u32, f64)> {
    let method = Method::Rule(Rule::Absolute(threshold), form);
    cut_by(case, &case.tree, method).iter().map(|member| (member.node, member.bound)).collect()
}

fn nested(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..context.cases * TIMES {
        let case = hard::case(context.seed, "nested", number, LIGHTS)?;
        let mut rng = input::rng(context.seed, "thresholds", number);
        let [a, b] = [0; 2].map(|_| THRESHOLDS[rng.random_range(0..THRESHOLDS.len())]);
        let form = FORMS[rng.random_range(0..2)];
        let mut coarse = by_threshold(&case, a.max(b), form);
        let mut fine = by_threshold(&case, a.min(b), form);
        if faulty {
            std::mem::swap(&mut coarse, &mut fine);
        }
        for (node, _) in fine {
            let above = coarse.iter().filter(|(top, _)| {
                (*top..*top + case.tree.nodes[*top as usize].size).contains(&node)
            });
            let above = above.count();
            tally.check(above == 1, || format!("{a} and {b}: node {node} is below {above}"));
        }
    }
    Ok(tally)
}

fn threshold(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..context.cases * TIMES {
        let case = hard::case(context.seed, "threshold", number, LIGHTS)?;
        let mut rng = input::rng(context.seed, "thresholds", number);
        let threshold = THRESHOLDS[rng.random_range(0..THRESHOLDS.len())];
        let form = FORMS[rng.random_range(0..2)];
        let cut = by_threshold(&case, if faulty { 2.0 * threshold } else { threshold }, form);
        for (node, bound) in cut {
            tally.check(bound <= threshold, || format!("node {node}: {bound} above {threshold}"));
        }
    }
    Ok(tally)
}

/// Settings of a cut of the worst node first.
fn worst(rng: &mut Pcg64) -> Result<Lightcuts, SuiteError> {
    match method(rng, SPEC.technique(LIGHTCUTS)?)? {
        Method::Worst(settings) => Ok(settings),
        other => Err(SuiteError::Internal(format!("{other:?} splits no worst node"))),
    }
}

fn epsilon(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..context.cases * TIMES {
        let case = hard::case(context.seed, "P17", number, LIGHTS)?;
        let stated = worst(&mut input::rng(context.seed, "P17 settings", number))?;
        let times = if faulty { 4.0 } else { 1.0 };
        let used = Lightcuts { epsilon: times * stated.epsilon, ..stated };
        let (found, members) = worst_first(&case, &case.tree, &used);
        let total: DVec3 = members.iter().map(|member| member.estimate).sum();
        let largest = members.iter().map(|member| member.bound).fold(0.0, f64::max);
        // The running total keeps a rounding of a representative that nearly touched the point.
        let bright: f64 = case.lights.iter().map(|light| light.intensity.max_element()).sum();
        let slack = 1e-13 * bright / (CLAMP_M * CLAMP_M);
        let met = largest <= stated.epsilon * (total.max_element() + slack);
        tally.check(met || found.ended, || {
            format!("case {number}: {largest} of {total}, {}", stated.epsilon)
        });
        let most = (stated.most as usize).max(case.tree.roots.len());
        tally.check(members.len() <= most, || format!("case {number}: {} nodes", members.len()));
    }
    Ok(tally)
}

fn scan(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..context.cases * TIMES {
        let case = hard::case(context.seed, "row 41", number, LIGHTS)?;
        let settings = worst(&mut input::rng(context.seed, "row 41 settings", number))?;
        let heap = Lightcuts { selection: Selection::Heap, ..settings };
        let epsilon = settings.epsilon * if faulty { 0.5 } else { 1.0 };
        let scan = Lightcuts { selection: Selection::Scan, epsilon, ..settings };
        let ((by_heap, of_heap), (by_scan, of_scan)) =
            (worst_first(&case, &case.tree, &heap), worst_first(&case, &case.tree, &scan));
        tally.check(of_heap == of_scan && by_heap.ended == by_scan.ended, || {
            format!("case {number}: {} and {} nodes", of_heap.len(), of_scan.len())
        });
    }
    Ok(tally)
}
