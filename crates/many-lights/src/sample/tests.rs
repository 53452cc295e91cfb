//! Chances of lights, enumerated and counted, over random and adversarial worlds.

use super::{
    Random,
    descend::{Draw, draw, probabilities},
    light_bvh,
    statistics::{Moments, chi_squared},
    stochastic,
    walked::{Double, Single, Walked},
};
use crate::{
    Emission, Light, LightTree, Point, StochasticLightcuts, World, radiance,
    tree::{Build, Representative},
    worlds::{Cloud, cloud},
};
use glam::{DVec3, Vec3};
use proptest::prelude::*;
use std::f64::consts::PI;
use std::sync::Arc;

const CLAMP_M: f64 = 0.1;

const ALL: [Emission; 4] = [
    Emission::Omni,
    Emission::Oriented,
    Emission::Spot { half_angle_rad: 0.25 * PI },
    Emission::Directional,
];

fn both(lights: &[Light], keys: Option<&[Vec<u32>]>, clamp_m: f64) -> (Double, Single) {
    let build = keys.map_or(Build::Median, Build::Keys);
    let tree = LightTree::build(lights, build, Representative::Weighted).unwrap();
    let single = Single::new(tree.pack(), clamp_m);
    (Double { tree: Arc::new(tree), clamp_m }, single)
}

fn small(emissions: &[Emission], lights: u32) -> World {
    let settings = Cloud {
        lights,
        emissions: emissions.to_vec(),
        seed: 7,
        size: [13, 11],
        frames: 1,
        origin: DVec3::ZERO,
    };
    cloud(&settings).world
}

/// All that a pixel may draw: of light-BVH sampling, and of stochastic lightcuts and its real-time form
/// with few and many nodes, whose cut is made at `pivot`.
fn all_chances(walked: &impl Walked, point: &Point, pivot: &Point) -> Vec<Vec<Vec<Draw>>> {
    let mut all = vec![vec![light_bvh::chances(walked, point)]];
    for (cut, real_time) in [(1, false), (5, false), (5, true), (1000, true)] {
        let settings = StochasticLightcuts { cut, real_time };
        let at = if real_time { pivot } else { point };
        let mut slots = Vec::new();
        stochastic::cut(walked, &settings, at, &mut slots, &mut 0);
        assert!(slots.len() <= (cut as usize).max(walked.roots().len()), "{}", slots.len());
        all.push(stochastic::chances(walked, &slots, point));
    }
    all
}

/// Chances are chances, no light that gives anything has none, and means are the sum of all lights.
fn check(walked: &impl Walked, leaves: u32, point: &Point, pivot: &Point) {
    let every = (0..leaves).filter(|&node| walked.size(node) == 1);
    let whole: DVec3 = every.clone().map(|leaf| walked.radiance(leaf, point)).sum();
    for (which, groups) in all_chances(walked, point, pivot).iter().enumerate() {
        let mut met = std::collections::BTreeSet::new();
        let mut mean = DVec3::ZERO;
        for group in groups {
            let sum: f64 = group.iter().map(|draw| draw.probability).sum();
            assert!(sum <= 1.0 + 1e-12, "{which}: {sum}");
            for draw in group {
                assert!(draw.probability > 0.0 && draw.probability <= 1.0 + 1e-12);
                assert!(met.insert(draw.leaf), "{which}: drawn from two nodes");
                mean += walked.radiance(draw.leaf, point);
            }
        }
        for leaf in every.clone() {
            let gives = walked.radiance(leaf, point);
            assert!(
                met.contains(&leaf) || gives == DVec3::ZERO,
                "{which}: {leaf} gives {gives} and is never drawn"
            );
        }
        let off = (mean - whole).abs().max_element();
        assert!(off <= 1e-12 * whole.max_element(), "{which}: {mean} {whole}");
    }
}

fn nodes(walked: &impl Walked) -> u32 {
    walked.roots().iter().map(|&root| walked.size(root)).sum()
}

#[test]
fn every_light_that_gives_anything_may_be_drawn() {
    let world = small(&ALL, 61);
    let (double, single) = both(&world.lights, None, world.clamp_m);
    let there: Vec<_> = world.frames[0].points.iter().filter(|p| p.is_there()).collect();
    assert!(there.len() > 50);
    for (index, point) in there.iter().enumerate() {
        let pivot = there[(index * 7) % there.len()];
        check(&double, nodes(&double), point, pivot);
        check(&single, nodes(&single), point, pivot);
    }
}

#[test]
fn frequencies_are_the_enumerated_chances() {
    let world = small(&ALL, 40);
    let (double, single) = both(&world.lights, None, world.clamp_m);
    let there: Vec<_> = world.frames[0].points.iter().filter(|p| p.is_there()).collect();
    for (index, point) in there.iter().step_by(there.len() / 5).enumerate() {
        let values = [
            frequencies(&double, |node| [double.importance(node, point)], index as u32),
            frequencies(&single, |node| [single.importance(node, point)], index as u32),
            frequencies(&double, |node| stochastic::worth(&double, point, node), 7),
            frequencies(&single, |node| stochastic::worth(&single, point, node), 9),
        ];
        // 20 tests at 1 in 10,000 each: deterministic, and 1 in 500 by chance of seeds.
        for (chance, control) in values {
            assert!(chance > 1e-4, "{values:?}");
            assert!(control < 1e-6, "{values:?}");
        }
    }
}

/// The chance of counts of draws under their enumerated chances, and under others.
fn frequencies<const N: usize>(
    walked: &impl Walked,
    worth: impl Fn(u32) -> [f64; N],
    seed: u32,
) -> (f64, f64) {
    let chances = probabilities(walked, walked.roots(), &worth);
    let mut expected = vec![0.0; nodes(walked) as usize + 1];
    for draw in &chances {
        expected[draw.leaf as usize] = draw.probability;
    }
    let nothing = nodes(walked) as usize;
    expected[nothing] = (1.0 - expected.iter().sum::<f64>()).max(0.0);
    if expected[nothing] < 1e-12 {
        expected[nothing] = 0.0;
    }
    let mut counts = vec![0; expected.len()];
    let mut random = Random::new(seed, 1, 2);
    let mut visits = 0;
    for _ in 0..50_000 {
        let roots = walked.roots().iter().copied();
        match draw(walked, roots, &worth, &mut random, &mut visits) {
            Some(Draw { leaf, probability }) => {
                let known = expected[leaf as usize];
                assert!((probability - known).abs() <= 1e-12 * known);
                counts[leaf as usize] += 1;
            }
            None => counts[nothing] += 1,
        }
    }
    assert!(visits > 50_000);
    let mut wrong = expected.clone();
    wrong.rotate_left(1);
    for (wrong, right) in wrong.iter_mut().zip(&expected) {
        *wrong = 0.5 * (*wrong + right);
    }
    (chi_squared(&counts, &expected), chi_squared(&counts, &wrong))
}

#[test]
fn a_sampler_with_wrong_chances_is_found_biased() {
    let world = small(&[Emission::Omni], 12);
    let (double, _) = both(&world.lights, None, world.clamp_m);
    let points: Vec<_> = world.frames[0].points.iter().filter(|p| p.is_there()).take(20).collect();
    // `wrong` mixes 1 % of equal chances into what it divides by, not into what it draws by.
    let images = |wrong: f64| {
        let mut moments = Moments::default();
        for seed in 0..4000 {
            let one = |(pixel, point): (usize, &&Point)| {
                let worth = |node| [double.importance(node, point)];
                let mut random = Random::new(seed, 0, pixel as u32);
                let roots = double.roots().iter().copied();
                let Some(drawn) = draw(&double, roots, &worth, &mut random, &mut 0) else {
                    return Vec3::ZERO;
                };
                let equal = 1.0 / world.lights.len() as f64;
                let chance = drawn.probability + wrong * (equal - drawn.probability);
                (double.radiance(drawn.leaf, point) / chance).as_vec3()
            };
            moments.push(&points.iter().enumerate().map(one).collect::<Vec<_>>());
        }
        let known: Vec<_> = points.iter().map(|point| world.truth(point)).collect();
        let variance: Vec<_> = points
            .iter()
            .zip(&known)
            .map(|(point, known)| {
                let square = |draw: &Draw| {
                    let radiance = double.radiance(draw.leaf, point);
                    radiance * radiance / draw.probability
                };
                let squares: DVec3 = light_bvh::chances(&double, point).iter().map(square).sum();
                (squares - *known * *known).max(DVec3::ZERO)
            })
            .collect();
        moments.z_test(&known, &variance, 0.01, 1e-6)
    };
    let right = images(0.0);
    assert!(right.passes() && right.tests == 60, "{right:?}");
    let wrong = images(0.2);
    assert!(!wrong.passes(), "{wrong:?}");
}

fn unit() -> impl Strategy<Value = DVec3> {
    (-1.0..1.0, 0.0..2.0 * PI).prop_map(|(z, turn): (f64, f64)| {
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * turn.cos(), r * turn.sin(), z).normalize()
    })
}

fn light(scale: f64) -> impl Strategy<Value = Light> {
    // Coarse places, so that lights coincide, and lie where points are.
    let place = prop_oneof![-1.0..1.0, Just(0.0), Just(0.5)];
    let intensity = prop_oneof![4 => 0.01..10.0, 1 => Just(0.0)];
    let emission = prop_oneof![
        Just(Emission::Omni),
        Just(Emission::Oriented),
        (0.05..PI).prop_map(|half_angle_rad| Emission::Spot { half_angle_rad }),
        Just(Emission::Directional)
    ];
    let axis = prop_oneof![unit(), Just(DVec3::Y), Just(DVec3::NEG_Y)];
    let colour = prop::array::uniform3(intensity);
    (prop::array::uniform3(place), axis, colour, emission).prop_map(
        move |(position, axis, colour, emission)| Light {
            position: DVec3::from_array(position) * scale,
            axis,
            intensity: DVec3::from_array(colour) * scale.max(1.0),
            emission,
        },
    )
}

fn point(scale: f64) -> impl Strategy<Value = Point> {
    let place = prop_oneof![-1.0..1.0, Just(0.0), Just(0.5)];
    let normal = prop_oneof![unit(), Just(DVec3::Y), Just(DVec3::NEG_Y)];
    let albedo = prop_oneof![4 => 0.0f32..1.0, 1 => Just(0.0)];
    (prop::array::uniform3(place), normal, prop::array::uniform3(albedo)).prop_map(
        move |(position, normal, albedo)| Point {
            position: (DVec3::from_array(position) * scale).as_vec3(),
            object: 0,
            normal: normal.as_vec3(),
            albedo: Vec3::from_array(albedo),
            ..Point::default()
        },
    )
}

type Given = (Vec<Light>, Vec<Vec<u32>>, Point, Point);

fn given() -> impl Strategy<Value = Given> {
    prop_oneof![Just(1e-4), Just(1.0), Just(100.0), Just(1e6)].prop_flat_map(|scale| {
        let lights = prop::collection::vec((light(scale), 0u32..3, 0u32..4), 0..40);
        (lights, point(scale), point(scale)).prop_map(|(lights, point, pivot)| {
            let keys = lights.iter().map(|(_, a, b)| vec![*a, *b]).collect();
            (lights.into_iter().map(|(light, _, _)| light).collect(), keys, point, pivot)
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn no_light_starves_whatever_the_world((lights, keys, point, pivot) in given()) {
        for keys in [None, Some(keys.as_slice())] {
            let (double, single) = both(&lights, keys, CLAMP_M);
            check(&double, nodes(&double), &point, &pivot);
            check(&single, nodes(&single), &point, &pivot);
            let whole: DVec3 = lights.iter().map(|light| radiance(&point, light, CLAMP_M)).sum();
            let leaves = (0..nodes(&double)).filter(|&node| double.size(node) == 1);
            let found: DVec3 = leaves.map(|leaf| double.radiance(leaf, &point)).sum();
            prop_assert!((found - whole).abs().max_element() <= 1e-12 * whole.max_element());
        }
    }
}
