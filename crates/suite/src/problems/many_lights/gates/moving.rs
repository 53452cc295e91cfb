//! Light trees that follow lights, and trees beside a tree.

use super::{
    ALL,
    greedy::depth,
    hard, input,
    trees::{cloud, outside},
};
use crate::{
    SuiteError,
    verify::{About, Gate, GateContext, Tally, gate},
};
use dapple_many_lights::{
    Emission, Light, LightTree,
    cut::{Receiver, Rule, walk},
    tree::{Build, Representative},
    worlds::WINDOW,
};
use glam::DVec3;
use rand::RngExt;

pub fn gates() -> Vec<Gate> {
    let about = |name, statement, fault| About { technique: ALL, name, statement, fault };
    vec![
        gate(
            about(
                "refit",
                "a tree that followed its lights is the one that is made anew, at a few node visits \
                 a level",
                "a light moved unseen",
            ),
            refit,
        ),
        gate(
            about(
                "second tree",
                "lights that move in a tree of their own are summed with the others",
                "the second tree is that of the frame before",
            ),
            second,
        ),
    ]
}

fn refit(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..context.cases {
        let mut rng = input::rng(context.seed, "refit", number);
        let count = rng.random_range(1..200);
        let mut lights = cloud(&mut rng, count, WINDOW);
        let binary: Vec<Vec<u32>> =
            (0..count as u32).map(|i| (0..8).rev().map(|bit| i >> bit & 1).collect()).collect();
        let build = Build::Keys(&binary);
        let mut tree = LightTree::build(&lights, build, Representative::Weighted)?;
        let mut packed = tree.pack();
        for step in 0..4 {
            let index = rng.random_range(0..count);
            lights[index].position += 30.0 * hard::unit(&mut rng);
            lights[index].intensity *= rng.random_range(0.5..2.0);
            if faulty && step == 0 {
                continue;
            }
            let visits = tree.moved(&lights, index as u32, Representative::Weighted)?;
            packed.moved(&tree, index as u32);
            // The root, and down and up both children of each level.
            let most = 1 + 4 * depth(&tree);
            tally.within(visits as f64, most as f64, || format!("{count} lights: node visits"));
        }
        let anew = LightTree::build(&lights, build, Representative::Weighted)?;
        let checked = tree.check(&lights);
        tally.check(checked.is_ok(), || format!("case {number}: {checked:?}"));
        tally.check(packed.nodes == tree.pack().nodes, || format!("case {number}: packed"));
        for (index, (moved, anew)) in tree.nodes.iter().zip(&anew.nodes).enumerate() {
            let boxes = (moved.min, moved.max) == (anew.min, anew.max);
            tally.check(boxes, || format!("case {number}, node {index}: another box"));
            let off =
                moved.position.distance(anew.position) + moved.intensity.distance(anew.intensity);
            tally.within(off, 1e-7, || format!("case {number}, node {index}"));
        }
    }
    Ok(tally)
}

fn second(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..context.cases {
        let mut rng = input::rng(context.seed, "second", number);
        let fixed = cloud(&mut rng, 40, WINDOW);
        let mut tree = LightTree::build(&fixed, Build::Median, Representative::Weighted)?;
        let extent = tree.extent();
        for frame in 0..3 {
            let count = rng.random_range(0..8);
            let emission = [Emission::Omni, WINDOW][rng.random_range(0..2)];
            let mut moving = cloud(&mut rng, count, emission);
            moving
                .push(Light { intensity: DVec3::splat(2000.0), ..cloud(&mut rng, 1, emission)[0] });
            moving.iter_mut().for_each(|light| light.axis = DVec3::Z);
            if !faulty || frame == 0 {
                let own = LightTree::build(&moving, Build::Median, Representative::Nearest)?;
                tree.replace_after(extent, &own);
            }
            let point = outside();
            let receiver = Receiver { point: &point, form: hard::FORMS[0], clamp_m: hard::CLAMP_M };
            let mut sum = DVec3::ZERO;
            walk(&tree, &tree.roots, |_, node| {
                let look = Rule::Absolute(0.0).look(node, &receiver);
                sum += if look.taken { look.estimate } else { DVec3::ZERO };
                look.taken
            });
            let gives = |light: &Light| dapple_many_lights::radiance(&point, light, hard::CLAMP_M);
            let exact: DVec3 = fixed.iter().chain(&moving).map(gives).sum();
            let off = (sum - exact).abs().max_element() / exact.max_element();
            tally.within(off, 1e-12, || format!("case {number}, frame {frame}"));
        }
    }
    Ok(tally)
}
