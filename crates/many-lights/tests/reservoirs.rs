//! Reservoirs give the truth on average: with and without reuse, with and without shadows. The biased
//! form is caught by the same test.

#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

mod reservoirs_worlds;

use dapple_many_lights::{
    Form, LightTree, Lighting, Reservoirs, Shaded, Technique, World, make,
    sample::statistics::{Moments, ZTest},
};
use glam::DVec3;
use reservoirs_worlds::{bent, mixed, mixed_with_shadows};
use std::sync::Arc;

const PLAIN: Reservoirs = Reservoirs {
    candidates: 4,
    temporal: false,
    history: 4,
    neighbours: 0,
    radius_px: 5.0,
    unbiased: true,
};

fn made(form: Form, settings: Reservoirs, world: &Arc<World>) -> Box<dyn Lighting + 'static> {
    let tree = Arc::new(LightTree::default());
    make(form, &Technique::Reservoirs(settings), world, &tree, None).unwrap()
}

/// The last of a world's frames over many seeds, against the truth.
fn judge(form: Form, settings: Reservoirs, world: &Arc<World>, seeds: u32) -> ZTest {
    let mut lighting = made(form, settings, world);
    let (mut moments, mut shaded) = (Moments::default(), Shaded::default());
    for seed in 0..seeds {
        lighting.reset(seed).unwrap();
        for index in 0..world.frames.len() {
            lighting.shade(index, false).unwrap();
        }
        lighting.read(&mut shaded).unwrap();
        moments.push(&shaded.radiance);
    }
    let last = world.frames.last().unwrap();
    let truth =
        |p| if dapple_many_lights::Point::is_there(p) { world.truth(p) } else { DVec3::ZERO };
    let truth: Vec<_> = last.points.iter().map(truth).collect();
    moments.z_test(&truth, &moments.variance(), 0.01, 1e-5)
}

fn reuses() -> [(&'static str, Reservoirs); 4] {
    [
        ("none", PLAIN),
        ("temporal", Reservoirs { temporal: true, ..PLAIN }),
        ("spatial", Reservoirs { neighbours: 3, ..PLAIN }),
        ("both", Reservoirs { temporal: true, neighbours: 3, ..PLAIN }),
    ]
}

#[test]
fn every_reuse_gives_the_truth_on_average() {
    for (world_name, world) in
        [("mixed", mixed()), ("shadows", mixed_with_shadows()), ("bent", bent())]
    {
        for (name, settings) in reuses() {
            for (form, seeds) in [(Form::Reference, 800), (Form::Cpu, 2000)] {
                let test = judge(form, settings, &world, seeds);
                assert!(test.passes(), "{world_name} {name} {form:?}: {test:?}");
            }
        }
    }
}

#[test]
fn what_is_biased_near_an_edge_is_caught() {
    for (name, settings) in reuses() {
        let biased = Reservoirs { unbiased: false, ..settings };
        for form in [Form::Reference, Form::Cpu] {
            let test = judge(form, biased, &bent(), 800);
            // Where nothing is reused there is nothing to be biased; a still eye sees the same
            // surface as before.
            assert_eq!(test.passes(), settings.neighbours == 0, "{name} {form:?}: {test:?}");
        }
    }
}
