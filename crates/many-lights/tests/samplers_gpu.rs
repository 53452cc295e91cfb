//! Samplers on a device draw the lights that the processor draws.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]
#![allow(clippy::print_stderr, reason = "tests say what they measured")]

use dapple_gpu::testing::test_gpu;
use dapple_many_lights::{
    Form, LightTree, Lighting, Point, Shaded, StochasticLightcuts, Technique, World,
    gpu::Scene,
    make,
    tree::{Build, Representative},
};
use std::sync::Arc;

#[path = "samplers_support/mod.rs"]
mod support;
use support::{ALL, DIFFERING, differing, every, small, tree_of};

fn image<'g>(lighting: &mut (dyn Lighting + 'g), seed: u32, count: bool) -> Shaded {
    let mut shaded = Shaded::default();
    lighting.reset(seed).unwrap();
    lighting.shade(0, count).unwrap();
    lighting.read(&mut shaded).unwrap();
    shaded
}

/// Pixels that differ between device and processor, after counters and other seeds were held too.
fn port(world: &Arc<World>, tree: &Arc<LightTree>, technique: &Technique) -> f64 {
    let Some(gpu) = test_gpu() else { return 0.0 };
    let scene = Arc::new(Scene::new(gpu, world).unwrap());
    let mut cpu = make(Form::Cpu, technique, world, tree, None).unwrap();
    let mut device = make(Form::Gpu, technique, world, tree, Some(&scene)).unwrap();
    let (on_cpu, on_device) = (image(&mut *cpu, 9, true), image(&mut *device, 9, true));
    let timed = image(&mut *device, 9, false);
    assert_eq!(timed.radiance, on_device.radiance, "{technique:?}");
    assert!(timed.visits.is_empty());
    let (a, b) = (on_cpu.work, on_device.work);
    assert_eq!((a.pixels, a.clusters, a.rays), (b.pixels, b.clusters, b.rays));
    for (name, a, b) in [
        ("visits", a.visits, b.visits),
        ("bounds", a.bounds, b.bounds),
        ("lights", a.lights, b.lights),
        ("samples", a.samples, b.samples),
        ("cut", a.cut, b.cut),
        ("most", a.most_cut, b.most_cut),
        ("ended", a.ended, b.ended),
        ("lanes", a.lane_visits, b.lane_visits),
    ] {
        let off = a.abs_diff(b) as f64;
        assert!(off <= 1.0 + 2.0 * DIFFERING * a as f64, "{technique:?}: {name} {a} {b}");
    }
    // Control: other numbers draw other lights, here and there alike.
    let other = image(&mut *device, 10, true);
    let share = differing(&on_device.radiance, &other.radiance);
    assert!(a.samples == 0 || share > 0.1, "{technique:?}: {share}");
    assert!(differing(&image(&mut *cpu, 10, true).radiance, &other.radiance) <= DIFFERING);
    differing(&on_cpu.radiance, &on_device.radiance)
}

#[test]
fn devices_draw_the_same_lights() {
    let world = Arc::new(small(&ALL, 300, [37, 29]).world);
    for technique in every() {
        let share = port(&world, &tree_of(&world), &technique);
        eprintln!("{technique:?}: {:.3} % of pixels fell the other way", 100.0 * share);
        assert!(share <= DIFFERING, "{technique:?}: {share}");
    }
}

#[test]
fn trees_of_many_children_and_wide_cuts_do_too() {
    let world = Arc::new(small(&ALL, 200, [17, 9]).world);
    let keys: Vec<_> = (0..200).map(|i| vec![i % 3, i % 11]).collect();
    let tree = LightTree::build(&world.lights, Build::Keys(&keys), Representative::Weighted);
    let tree = Arc::new(tree.unwrap());
    let cut =
        |cut, real_time| Technique::StochasticLightcuts(StochasticLightcuts { cut, real_time });
    for technique in every().into_iter().chain([cut(1024, false), cut(1024, true), cut(40, true)]) {
        let share = port(&world, &tree, &technique);
        assert!(share <= DIFFERING, "{technique:?}: {share}");
    }
}

#[test]
fn small_and_empty_worlds_are_lit_on_devices() {
    let Some(gpu) = test_gpu() else { return };
    let base = small(&ALL, 4, [3, 2]).world;
    let mut one = base.clone();
    one.lights.truncate(1);
    let mut none = base.clone();
    none.lights.clear();
    let mut nothing = base.clone();
    nothing.frames[0].points.fill(Point::nothing());
    for world in [one, none, nothing] {
        let world = Arc::new(world);
        let tree = tree_of(&world);
        let scene = Arc::new(Scene::new(gpu, &world).unwrap());
        for technique in every() {
            let mut cpu = make(Form::Cpu, &technique, &world, &tree, None).unwrap();
            let mut device = make(Form::Gpu, &technique, &world, &tree, Some(&scene)).unwrap();
            let (a, b) = (image(&mut *cpu, 1, true), image(&mut *device, 1, true));
            assert_eq!(differing(&a.radiance, &b.radiance), 0.0, "{technique:?}");
            assert_eq!(a.work, b.work, "{technique:?}");
        }
    }
}

#[test]
fn a_device_is_asked_for_by_name() {
    let world = Arc::new(small(&ALL, 4, [3, 2]).world);
    for technique in every() {
        let made = make(Form::Gpu, &technique, &world, &tree_of(&world), None);
        assert!(made.err().is_some_and(|error| error.to_string().contains("scene")));
    }
}

#[test]
fn shadow_rays_are_cast_or_refused() {
    let Some(gpu) = test_gpu() else { return };
    let world = Arc::new(small(&ALL, 20, [9, 9]).with_shadows().unwrap());
    let tree = tree_of(&world);
    for technique in every() {
        let device = Scene::new(gpu, &world)
            .and_then(|scene| make(Form::Gpu, &technique, &world, &tree, Some(&Arc::new(scene))));
        match device {
            Err(error) => assert!(error.to_string().contains("shadow rays"), "{error}"),
            Ok(mut device) => {
                let mut cpu = make(Form::Cpu, &technique, &world, &tree, None).unwrap();
                let (a, b) = (image(&mut *cpu, 1, true), image(&mut *device, 1, true));
                assert!(b.work.rays > 0 && differing(&a.radiance, &b.radiance) <= 0.02);
            }
        }
    }
}
