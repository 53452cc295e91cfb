//! Clustered shading and the cap on a device give what they give on the processor.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod lists_support;

use dapple_gpu::testing::{say_not_run, test_gpu};
use dapple_many_lights::{
    Capped, Clustered, Emission, Form, LightTree, Shaded, Technique, World,
    gpu::Scene,
    make,
    worlds::{Cloud, Facade, WINDOW, cloud, emissions, facade},
};
use lists_support::{close, extremes, shaded};
use std::sync::Arc;

/// Each frame of a world on the device: counted, and as it is timed.
fn on_device(technique: &Technique, world: &World) -> Option<Vec<[Shaded; 2]>> {
    let Some(gpu) = test_gpu() else {
        say_not_run("no graphics device");
        return None;
    };
    let world = Arc::new(world.clone());
    let tree = Arc::new(LightTree::median(&world.lights).unwrap());
    let scene = Arc::new(Scene::new(gpu, &world).unwrap());
    let mut lighting = make(Form::Gpu, technique, &world, &tree, Some(&scene)).unwrap();
    lighting.reset(1).unwrap();
    let mut nothing_yet = Shaded::default();
    assert!(lighting.read(&mut nothing_yet).is_err());
    let mut frames = Vec::new();
    for frame in 0..world.frames.len() {
        let frames_of = [true, false].map(|count| {
            let times = lighting.shade(frame, count).unwrap();
            assert!(times.is_empty() || times.iter().any(|(pass, _)| *pass == "light"));
            let mut shaded = Shaded::default();
            lighting.read(&mut shaded).unwrap();
            shaded
        });
        frames.push(frames_of);
    }
    assert!(lighting.shade(world.frames.len(), false).is_err());
    gpu.check().unwrap();
    Some(frames)
}

/// Pixels where the device differs from the processor, over all frames; and both forms' work.
fn differing(technique: &Technique, world: &World, least: f64) -> Option<usize> {
    let frames = on_device(technique, world)?;
    let mut differing = 0;
    for (frame, [counted, timed]) in frames.iter().enumerate() {
        let expected = shaded(Form::Cpu, technique, world, frame, true);
        assert_eq!(counted.radiance, timed.radiance, "counting changes nothing");
        assert_eq!(timed.work, Default::default());
        assert!(counted.visits.is_empty());
        differing += close(&counted.radiance, &expected.radiance, 2e-5, least).len();
        let (found, expected) = (counted.work, expected.work);
        assert_eq!(found.pixels, expected.pixels);
        assert_eq!((found.bounds, found.ended), (expected.bounds, expected.ended));
        // A depth on the border of two slices may fall to either.
        let near = |a: u64, b: u64| a.abs_diff(b) as f64 <= 2.0 + 0.03 * b as f64;
        assert!(near(found.entries, expected.entries), "{found:?} {expected:?}");
        assert!(near(found.lights, expected.lights), "{found:?} {expected:?}");
        if matches!(technique, Technique::Clustered(Clustered { slices: 1, .. })) {
            assert_eq!((found.entries, found.lights), (expected.entries, expected.lights));
        }
    }
    Some(differing)
}

fn clustered(cutoff: f64, tile: u32, slices: u32, window: bool) -> Technique {
    Technique::Clustered(Clustered { cutoff, tile, slices, window })
}

#[test]
fn clusters_are_lit_as_on_the_processor() {
    let (made, _) = facade(&Facade { size: [50, 30], ..Facade::default() });
    let mut worlds = vec![made.world];
    for emissions in emissions() {
        let size = [45, 27];
        let of = Cloud { lights: 300, emissions, frames: 2, size, ..Cloud::default() };
        worlds.push(cloud(&of).world);
    }
    for world in &worlds {
        for technique in [
            clustered(1e-3, 16, 12, true),
            clustered(1e-2, 8, 24, false),
            clustered(3e-3, 7, 1, false),
            clustered(1e-2, 64, 1, true),
            clustered(1e-2, 1, 3, true),
            clustered(1e-300, 1000, 1000, false),
        ] {
            let Some(differing) = differing(&technique, world, 1e-6) else { return };
            // A light's very reach may be decided either way where it is cut off hard.
            assert!(differing <= 2, "{technique:?}: {differing} pixels");
        }
    }
}

#[test]
fn the_cap_is_as_on_the_processor() {
    let emissions = vec![Emission::Omni, WINDOW, Emission::Directional, Emission::Oriented];
    let size = [45, 27];
    let of = Cloud { lights: 400, emissions, frames: 2, size, ..Cloud::default() };
    let world = cloud(&of).world;
    for most in [1, 20, 400, u32::MAX] {
        let Some(differing) = differing(&Technique::Capped(Capped { most }), &world, 1e-6) else {
            return;
        };
        assert_eq!(differing, 0, "{most}");
    }
}

#[test]
fn extremes_are_survived() {
    for (name, world) in extremes() {
        for technique in [
            clustered(1e-2, 8, 4, true),
            clustered(1e-9, 16, 1, false),
            clustered(f64::INFINITY, 4, 2, true),
            Technique::Capped(Capped { most: 1 }),
            Technique::Capped(Capped { most: 1000 }),
        ] {
            let Some(differing) = differing(&technique, &world, 1e-5) else { return };
            assert_eq!(differing, 0, "{name} {technique:?}");
        }
    }
}

#[test]
fn scenes_of_others_are_refused() {
    let Some(gpu) = test_gpu() else {
        say_not_run("no graphics device");
        return;
    };
    let made = cloud(&Cloud::default());
    let world = Arc::new(made.world.clone());
    let tree = Arc::new(LightTree::median(&world.lights).unwrap());
    let scene = Arc::new(Scene::new(gpu, &world).unwrap());
    let other = Arc::new(made.world.clone());
    for technique in [clustered(1e-2, 8, 4, true), Technique::Capped(Capped { most: 9 })] {
        assert!(make(Form::Gpu, &technique, &world, &tree, Some(&scene)).is_ok());
        assert!(make(Form::Gpu, &technique, &world, &tree, None).is_err());
        assert!(make(Form::Gpu, &technique, &other, &tree, Some(&scene)).is_err());
    }
    let cells = clustered(1e-2, 1, 1 << 20, true);
    assert!(make(Form::Gpu, &cells, &world, &tree, Some(&scene)).is_err());
}
