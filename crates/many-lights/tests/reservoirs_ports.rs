//! Forms of reservoirs draw the same random numbers, so they give the same images but where rounding
//! lets a draw fall the other way; such pixels are counted.

#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

mod reservoirs_worlds;

use dapple_gpu::testing::test_gpu;
use dapple_many_lights::{
    Form, LightTree, Lighting, Reservoirs, Shaded, Technique, World,
    gpu::Scene,
    make,
    worlds::{Cloud, cloud},
};
use glam::Vec3;
use reservoirs_worlds::{bent, mixed, mixed_with_shadows};
use std::sync::Arc;

const BOTH: Reservoirs = Reservoirs {
    candidates: 8,
    temporal: true,
    history: 20,
    neighbours: 3,
    radius_px: 6.0,
    unbiased: true,
};

/// Pixels that may differ by more than rounding: those where a draw fell the other way, and those
/// that reused one of them later.
const SHARE: f64 = 0.002;

/// Rounding of f32, through a division of sums of products.
const ROUNDING: f32 = 1e-4;

fn images<'g>(
    form: Form,
    settings: Reservoirs,
    world: &Arc<World>,
    scene: Option<&Arc<Scene<'g>>>,
    seed: u32,
) -> Vec<Shaded> {
    let tree = Arc::new(LightTree::default());
    let mut lighting: Box<dyn Lighting + 'g> =
        make(form, &Technique::Reservoirs(settings), world, &tree, scene).unwrap();
    lighting.reset(seed).unwrap();
    let each = (0..world.frames.len()).map(|index| {
        let mut shaded = Shaded::default();
        lighting.shade(index, true).unwrap();
        lighting.read(&mut shaded).unwrap();
        shaded
    });
    each.collect()
}

/// Pixels of all frames, and those that differ by more than rounding.
fn differing(a: &[Shaded], b: &[Shaded]) -> (usize, usize) {
    let (mut all, mut differ) = (0, 0);
    for (a, b) in a.iter().zip(b) {
        assert_eq!(a.radiance.len(), b.radiance.len());
        all += a.radiance.len();
        let pairs = a.radiance.iter().zip(&b.radiance);
        differ += pairs.filter(|(a, b)| !(is_close(**a, **b))).count();
    }
    (all, differ)
}

fn is_close(a: Vec3, b: Vec3) -> bool {
    (a - b).abs().max_element() <= ROUNDING * a.max(b).max_element()
}

fn assert_port(what: &str, a: &[Shaded], b: &[Shaded]) {
    let (all, differ) = differing(a, b);
    // Of few pixels one may.
    assert!(differ as f64 <= (SHARE * all as f64).max(1.0), "{what}: {differ} of {all} pixels");
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (a.work, b.work);
        assert_eq!((a.pixels, a.samples), (b.pixels, b.samples), "{what}");
        for (name, a, b) in [
            ("lights", a.lights, b.lights),
            ("rays", a.rays, b.rays),
            ("reused", a.reused, b.reused),
        ] {
            // What one pixel may do more or less of, too.
            assert!(a.abs_diff(b) as f64 <= SHARE * a as f64 + 16.0, "{what}: {name} {a} {b}");
        }
    }
}

fn settings() -> [(&'static str, Reservoirs); 4] {
    [
        ("no reuse", Reservoirs { temporal: false, neighbours: 0, ..BOTH }),
        ("temporal", Reservoirs { neighbours: 0, ..BOTH }),
        ("both", BOTH),
        ("biased", Reservoirs { unbiased: false, ..BOTH }),
    ]
}

/// Four kinds of light, 33 x 21 pixels, four frames.
fn larger() -> Arc<World> {
    let emissions = reservoirs_worlds::EMISSIONS.to_vec();
    let cloud =
        cloud(&Cloud { lights: 500, emissions, size: [33, 21], frames: 4, ..Cloud::default() });
    Arc::new(cloud.world)
}

#[test]
fn single_precision_is_the_reference_but_for_draws_that_rounding_turns() {
    for (name, world) in [
        ("mixed", mixed()),
        ("shadows", mixed_with_shadows()),
        ("bent", bent()),
        ("larger", larger()),
    ] {
        for (what, settings) in settings() {
            let reference = images(Form::Reference, settings, &world, None, 7);
            let cpu = images(Form::Cpu, settings, &world, None, 7);
            assert_port(&format!("{name} {what}"), &reference, &cpu);
        }
    }
}

#[test]
fn the_device_gives_what_the_processor_gives() {
    let Some(gpu) = test_gpu() else { return };
    for (name, world) in [("mixed", mixed()), ("bent", bent()), ("larger", larger())] {
        let scene = Arc::new(Scene::new(gpu, &world).unwrap());
        for (what, settings) in settings() {
            let cpu = images(Form::Cpu, settings, &world, None, 7);
            let device = images(Form::Gpu, settings, &world, Some(&scene), 7);
            assert_port(&format!("{name} {what} on the device"), &cpu, &device);
        }
    }
}

#[test]
fn another_seed_is_no_port() {
    let (one, other) =
        (images(Form::Cpu, BOTH, &larger(), None, 7), images(Form::Cpu, BOTH, &larger(), None, 8));
    let (all, differ) = differing(&one, &other);
    // A little of it is sky.
    assert!(2 * differ > all, "{differ} of {all}");
}

#[test]
fn worlds_of_no_light_one_and_one_pixel_are_the_same_on_a_device() {
    let Some(gpu) = test_gpu() else { return };
    for (lights, size) in [(0, [9, 7]), (1, [9, 7]), (2, [1, 1]), (40, [1, 1]), (3, [8, 8])] {
        let world =
            cloud(&Cloud { lights, emissions: vec![], size, frames: 2, ..Cloud::default() });
        let world = Arc::new(world.world);
        let scene = Arc::new(Scene::new(gpu, &world).unwrap());
        let cpu = images(Form::Cpu, BOTH, &world, None, 3);
        let device = images(Form::Gpu, BOTH, &world, Some(&scene), 3);
        let (all, differ) = differing(&cpu, &device);
        // Of so few pixels one may fall the other way.
        assert!(differ <= 1, "{lights} lights, {size:?}: {differ} of {all}");
        if lights == 0 {
            assert!(device.iter().all(|d| d.radiance.iter().all(|rgb| *rgb == Vec3::ZERO)));
        }
    }
}
