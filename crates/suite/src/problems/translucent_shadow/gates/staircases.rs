//! Codes that keep the steps of a ray: adaptive maps never darken, deep ones stay within a tolerance.

use super::{About, gate, input, rivals::build};
use crate::{
    SuiteError,
    verify::{Gate, GateContext, Tally},
};
use dapple_opacity_maps::{Adaptive, Code, Deep, Fragments, Order, cpu::Maps, reference};
use rand::RngExt;

pub fn gates() -> Vec<Gate> {
    let about = |technique, name, statement, fault| About { technique, name, statement, fault };
    vec![
        gate(
            about(
                "avsm",
                "never darker",
                "whatever is removed, the staircase is never darker than the truth",
                "it is read 0.05 too deep",
            ),
            never_darker,
        ),
        gate(
            about(
                "avsm",
                "enough nodes",
                "with a node for every fragment it is exact in any order",
                "four nodes",
            ),
            enough_nodes,
        ),
        gate(
            about(
                "deep",
                "tolerance",
                "no transmittance errs by more than the tolerance; 0 is exact",
                "eight nodes must do",
            ),
            tolerance,
        ),
    ]
}

/// A texel's depths of interest: everywhere, and beside and between its fragments.
fn probes(fragments: &Fragments, texel: usize) -> Vec<f32> {
    let mut probes: Vec<f32> = (0..=40).map(|i| i as f32 / 40.0).collect();
    let at = |d: f32| [d.next_down(), d, d.next_up(), d + 1e-3];
    probes.extend(fragments.texel(texel).iter().flat_map(|f| at(f.depth)));
    probes
}

fn never_darker(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let later = if faulty { 0.05 } else { 0.0 };
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "darker", case);
        let fragments = input::fragments(&mut rng);
        let order = [Order::Drawn, Order::Sorted][rng.random_range(0..2_usize)];
        let nodes = rng.random_range(2..=16);
        let maps = build(Code::Adaptive(Adaptive { nodes, order }), &fragments)?;
        for texel in 0..fragments.texels() {
            for depth in probes(&fragments, texel) {
                let truth = reference::exact(fragments.texel(texel), depth);
                let t = input::at(&maps, texel, depth + later);
                tally.within(truth - t, 1e-6, || format!("{nodes} nodes, {order:?}, at {depth}"));
            }
        }
    }
    Ok(tally)
}

/// Holds maps against the truth everywhere.
fn exact(tally: &mut Tally, maps: &Maps, fragments: &Fragments, bound: f64) {
    for texel in 0..fragments.texels() {
        for depth in probes(fragments, texel) {
            let truth = reference::exact(fragments.texel(texel), depth);
            let t = input::at(maps, texel, depth);
            tally.within((t - truth).abs(), bound, || {
                format!("{:?}, texel {texel} at {depth}: {t} {truth}", maps.settings().code)
            });
        }
    }
}

fn enough_nodes(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let fragments = input::fragments(&mut input::rng(context.seed, "enough", case));
        for order in [Order::Drawn, Order::Sorted] {
            let nodes = if faulty { 4 } else { 64 };
            let maps = build(Code::Adaptive(Adaptive { nodes, order }), &fragments)?;
            exact(&mut tally, &maps, &fragments, 1e-6);
        }
    }
    Ok(tally)
}

fn tolerance(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "tolerance", case);
        let fragments = input::fragments(&mut rng);
        for tolerance in [0.0, rng.random_range(0.001..0.3_f32)] {
            let nodes = if faulty { 8 } else { 64 };
            let maps = build(Code::Deep(Deep { tolerance, nodes }), &fragments)?;
            exact(&mut tally, &maps, &fragments, f64::from(tolerance) + 1e-6);
        }
    }
    Ok(tally)
}
