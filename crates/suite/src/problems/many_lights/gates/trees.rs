//! Light trees: what nodes hold, and how each way to cluster does it.

use super::{
    ALL,
    greedy::{self, angle, depth},
    hard, input,
};
use crate::{
    SuiteError,
    verify::{About, Gate, GateContext, Tally, gate},
};
use dapple_many_lights::{
    Emission, Light, LightTree, Point, bound,
    tree::{
        Build, Representative,
        city::{Levels, keys},
    },
    worlds::WINDOW,
};
use dapple_scene::city::{self, Knobs};
use glam::{DVec3, Vec3};
use rand::RngExt;
use rand_pcg::Pcg64;
use std::f64::consts::PI;

/// Trees for each case that is asked for.
const TIMES: u32 = 20;

/// Lights of a tree.
const LIGHTS: usize = 40;

/// Share by which sums of intensities may differ.
const SUM: f64 = 1e-5;

/// Angle by which a cone may miss an axis, radians.
const ANGLE: f64 = 1e-6;

/// Seeds over which a random representative is averaged.
const SEEDS: u64 = 10_000;

/// Standard errors that a mean over those may be off: 2e-9 by chance.
const MOST_Z: f64 = 6.0;

pub fn gates() -> Vec<Gate> {
    let about = |name, statement, fault| About { technique: ALL, name, statement, fault };
    vec![
        gate(
            about(
                "P13 nodes",
                "boxes hold their lights, intensities are sums, cones hold all axes, and every \
                 light is in one leaf, however lights are clustered and represented",
                "a cluster is made of its first child alone",
            ),
            nodes,
        ),
        gate(
            about(
                "row 34 greedy",
                "the original tree has 2 n - 1 nodes, and every join is the pair of least cost",
                "lights are halved instead",
            ),
            greedy::gate,
        ),
        gate(
            about(
                "row 35 median",
                "a tree of halves has 2 n - 1 nodes and is as deep as the logarithm of its lights",
                "pairs are joined instead",
            ),
            median,
        ),
        gate(
            about(
                "row 36 hierarchy",
                "a city's tree is 5 deep and has at most 1.6 nodes a light",
                "without storeys, in halves",
            ),
            hierarchy,
        ),
        gate(
            about(
                "row 37 weighted",
                "a weighted representative is the mean by luminance, and lies in its box",
                "all lights weigh alike",
            ),
            weighted,
        ),
        gate(
            about(
                "row 37 random",
                "the mean estimate over 10,000 seeds of a random representative is what the lights \
                 give",
                "the brightest light is missing from the tree",
            ),
            random,
        ),
    ]
}

fn nodes(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..context.cases * TIMES {
        let mut case = hard::case(context.seed, "P13", number, LIGHTS)?;
        let nodes = &mut case.tree.nodes;
        if faulty {
            for index in 0..nodes.len() {
                if !nodes[index].is_leaf() {
                    let child = nodes[index + 1];
                    let node = &mut nodes[index];
                    (node.min, node.max, node.cone_rad) = (child.min, child.max, child.cone_rad);
                }
            }
        }
        let checked = case.tree.check(&case.lights);
        tally.check(checked.is_ok(), || format!("case {number}: {checked:?}"));
        let mut leaves: Vec<usize> = Vec::new();
        for &root in &case.tree.roots {
            leaves.extend(case.below(root as usize));
        }
        leaves.sort_unstable();
        let all: Vec<usize> = (0..case.lights.len()).collect();
        tally.check(leaves == all, || format!("case {number}: leaves are {leaves:?}"));
        for (index, node) in case.tree.nodes.iter().enumerate() {
            let mut sum = DVec3::ZERO;
            for light in case.below(index).map(|light| &case.lights[light]) {
                sum += light.intensity;
                let inside = light.position.clamp(node.min, node.max) == light.position;
                tally.check(inside, || format!("node {index}: {} is outside", light.position));
                let directed = light.emission != Emission::Omni;
                let off = if directed { angle(node.axis, light.axis) } else { 0.0 };
                tally.check(off <= node.cone_rad + ANGLE, || {
                    format!("node {index}: an axis is {off} off, cone {}", node.cone_rad)
                });
                tally.check(light.emission.code() == node.kind, || format!("node {index}: kinds"));
            }
            let off = (sum - node.intensity).abs().max_element();
            tally.check(off <= SUM * sum.max_element(), || {
                format!("node {index}: {} for a sum of {sum}", node.intensity)
            });
        }
    }
    Ok(tally)
}

/// Lights of one kind in a cube of 100 m, none like another.
pub fn cloud(rng: &mut Pcg64, count: usize, emission: Emission) -> Vec<Light> {
    let light = |_| Light {
        position: DVec3::from_array(std::array::from_fn(|_| rng.random_range(0.0..100.0))),
        axis: DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)))
            .normalize_or(DVec3::Y),
        intensity: DVec3::from_array(std::array::from_fn(|_| rng.random_range(0.1..5.0))),
        emission,
    };
    (0..count).map(light).collect()
}

fn median(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..context.cases * 2 {
        let mut rng = input::rng(context.seed, "median", number);
        let count = match number {
            0..8 => number as usize + 1,
            8..12 => [63, 64, 65, 1025][number as usize - 8],
            _ => rng.random_range(2..300),
        };
        let mut lights = cloud(&mut rng, count, WINDOW);
        if number % 3 == 0 {
            let first = lights[0].position;
            lights.iter_mut().for_each(|light| light.position = first);
        }
        let build = if faulty { Build::Greedy { spread: 1.0 } } else { Build::Median };
        let tree = LightTree::build(&lights, build, Representative::Weighted)?;
        let expected = count.next_power_of_two().trailing_zeros() as usize;
        tally.check(depth(&tree) == expected, || {
            format!("{count} lights: {} deep rather than {expected}", depth(&tree))
        });
        let nodes = tree.nodes.len();
        tally.check(nodes == 2 * count - 1, || format!("{count} lights: {nodes} nodes"));
    }
    Ok(tally)
}

fn hierarchy(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for blocks in [[2, 1], [2, 2]] {
        let knobs = Knobs { blocks_x: blocks[0], blocks_z: blocks[1], ..Knobs::default() };
        let city = city::generate(&knobs, context.seed)?;
        let (mut lights, mut paths) = keys(&city, DVec3::ZERO, Levels::default());
        lights.truncate(city.lights.len());
        paths.truncate(city.lights.len());
        let build = if faulty { Build::Median } else { Build::Keys(&paths) };
        let tree = LightTree::build(&lights, build, Representative::Weighted)?;
        tally.check(depth(&tree) == 5, || format!("{} deep", depth(&tree)));
        let share = tree.nodes.len() as f64 / lights.len() as f64;
        tally.within(share, 1.6, || format!("{} nodes for {}", tree.nodes.len(), lights.len()));
        let checked = tree.check(&lights);
        tally.check(checked.is_ok(), || format!("{checked:?}"));
    }
    Ok(tally)
}

fn weighted(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..context.cases * TIMES / 4 {
        let mut rng = input::rng(context.seed, "weighted", number);
        let lights = hard::lights(&mut rng, LIGHTS);
        let tree = LightTree::build(&lights, Build::Median, Representative::Weighted)?;
        for (index, node) in tree.nodes.iter().enumerate() {
            let own = || hard::below(&tree, index).map(|light| &lights[light]);
            let total: f64 = own().map(Light::luminance).sum();
            let even = faulty || total == 0.0;
            let weight = |light: &Light| if even { 1.0 } else { light.luminance() };
            let weights: f64 = own().map(weight).sum();
            let mean: DVec3 = own().map(|l| l.position * (weight(l) / weights)).sum();
            let size = node.min.abs().max(node.max.abs()).max_element();
            tally.within(node.position.distance(mean), 1e-9 * size, || format!("node {index}"));
            let inside = node.position.clamp(node.min, node.max) == node.position;
            tally.check(inside, || format!("node {index} is represented outside of its box"));
        }
    }
    Ok(tally)
}

/// Somebody lit from well outside of a cube of 100 m.
pub fn outside() -> Point {
    let (normal, albedo) = (Vec3::NEG_Z, Vec3::ONE);
    Point { position: Vec3::new(50.0, 50.0, 140.0), normal, albedo, ..Point::default() }
}

fn random(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let builds = [Build::Median, Build::Greedy { spread: 1.0 }];
    for number in 0..context.cases.min(if faulty { 1 } else { 2 }) {
        let mut rng = input::rng(context.seed, "random", number);
        let mut lights = cloud(&mut rng, 6, Emission::Spot { half_angle_rad: PI });
        for light in &mut lights {
            light.intensity = DVec3::splat(light.luminance());
        }
        lights.sort_by(|a, b| b.intensity.x.total_cmp(&a.intensity.x));
        let point = outside();
        // Drawn by luminance, a light's estimate is what it gives over its share of all luminance.
        let total: f64 = lights.iter().map(Light::luminance).sum();
        let gives = |light: &Light| dapple_many_lights::radiance(&point, light, hard::CLAMP_M).x;
        let exact: f64 = lights.iter().map(gives).sum();
        let squares = |light: &Light| gives(light).powi(2) * total / light.luminance();
        let variance = lights.iter().map(squares).sum::<f64>() - exact * exact;
        let mut sum = 0.0;
        for seed in 0..SEEDS {
            let seed = context.seed.wrapping_mul(SEEDS) + seed;
            let representative = Representative::Random { seed };
            let build = builds[number as usize % builds.len()];
            let tree = LightTree::build(&lights[usize::from(faulty)..], build, representative)?;
            sum += bound::estimate(&tree.nodes[0], &point, hard::CLAMP_M).x;
        }
        let z = (sum / SEEDS as f64 - exact) / (variance / SEEDS as f64).sqrt();
        tally.within(z.abs(), MOST_Z, || format!("case {number}: standard errors"));
    }
    Ok(tally)
}
