//! Lights that move, in a tree of their own (row 32).

use super::cities::{SMALL, Seen, city, fine};
use crate::{
    SuiteError,
    verify::{About, Gate, GateContext, Tally, gate, rng},
};
use dapple_many_lights::{
    Emission, Light, LightTree, Shaded, radiance,
    tree::{Build, Representative},
};
use dapple_night_city::{Night, Pipeline};
use glam::{DVec3, Vec3};
use rand::RngExt;

/// Relative to what a pixel gets: the image is f32.
const ROUNDED: f64 = 1e-4;

/// Frames.
const FRAMES: usize = 4;

pub fn gates() -> Vec<Gate> {
    vec![gate(
        About {
            technique: "facade-cluster",
            name: "second tree",
            statement: "lights that move are added to every pixel in the next frame, where they are \
                        then, and are gone when they are",
            fault: "the second tree is that of the frame before",
        },
        moving,
    )]
}

fn moving(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let case = city(Seen { frames: 1, ..SMALL }, context.seed, None)?;
    let town = &case.night().town;
    let night = fine(Night::default());
    // Without a threshold trees sum up to their lights.
    let cut = dapple_many_lights::Absolute { threshold: 0.0, ..night.cut };
    let mut pipeline = Pipeline::new(town, &Night { cut, ..night }, None)?;
    let mut shaded = Shaded::default();
    // What is seen settles from frame to frame: another one goes along without.
    let mut plain = Pipeline::new(town, &Night { cut, ..night }, None)?;
    let mut without = Shaded::default();
    let (world, mut rng) = (town.world(false), rng(context.seed, "moving", 0));
    let points = &world.frames[0].points;
    let there: Vec<_> = points.iter().filter(|point| point.is_there()).collect();
    for frame in 0..FRAMES {
        let mut lights = Vec::new();
        if frame + 1 < FRAMES {
            for _ in 0..rng.random_range(1..6) {
                let near = there[rng.random_range(0..there.len())];
                let metres = rng.random_range(0.5..4.0);
                lights.push(Light {
                    position: near.position.as_dvec3() + near.normal.as_dvec3() * metres,
                    axis: DVec3::NEG_Y,
                    intensity: DVec3::new(3.0, 2.0, 1.0) * rng.random_range(0.5..2.0),
                    emission: Emission::Omni,
                });
            }
        }
        if !faulty || frame == 0 {
            let tree = match lights.is_empty() {
                true => LightTree::default(),
                false => LightTree::build(&lights, Build::Median, Representative::Weighted)?,
            };
            pipeline.replace_moving(&lights, &tree)?;
        }
        pipeline.frame(0, false)?;
        pipeline.read(&mut shaded)?;
        plain.frame(0, false)?;
        plain.read(&mut without)?;
        let pairs = shaded.radiance.iter().zip(&without.radiance);
        for (point, (with, without)) in points.iter().zip(pairs) {
            if !point.is_there() {
                tally.check(*with == Vec3::ZERO, || format!("frame {frame}: the sky is lit"));
                continue;
            }
            let added: DVec3 = lights.iter().map(|l| radiance(point, l, world.clamp_m)).sum();
            let expected = without.as_dvec3() + added;
            let off = (with.as_dvec3() - expected).abs().max_element();
            let most = ROUNDED * (1e-3 + expected.max_element());
            tally.within(off, most, || format!("frame {frame}: {with} for {expected}"));
        }
    }
    Ok(tally)
}
