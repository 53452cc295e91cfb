//! Frames on a device: those of the processor.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod town_support;

use dapple_gpu::testing::test_gpu;
use dapple_many_lights::{
    Shaded,
    region::{FacadeCluster, RegionTechnique},
};
use dapple_night_city::{
    Device, Night, Pipeline,
    decompose::{PointStarts, decompose},
};
use glam::Vec3;
use town_support::{along, images, lit};

/// Cuts on a device differ where a bound is within rounding of the threshold.
const WITHIN: f32 = 4.0 / 25_500.0;

fn furthest(a: &[Vec3], b: &[Vec3]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max)
}

#[test]
fn a_device_lights_what_the_processor_does_overlapped_or_not() {
    overlapped_or_not(Night::default());
}

/// Heights of nodes are looked at there too.
#[test]
fn a_device_lights_what_the_processor_does_by_height() {
    overlapped_or_not(Night { heights: 3, ..Night::default() });
}

fn overlapped_or_not(night: Night) {
    let Some(gpu) = test_gpu() else { return };
    let town = along("tour", 48, (40..46).chain([125]));
    let expected = images(&town, &night, None);
    let device = Device::new(gpu, town.world(false)).unwrap();
    let found = images(&town, &night, Some(&device));
    for (index, (found, expected)) in found.iter().zip(&expected).enumerate() {
        assert!(lit(expected) > 200, "frame {index}");
        let off = furthest(found, expected);
        assert!(off < WITHIN, "frame {index}: {off:e}");
    }
    let mut pipeline = Pipeline::new(&town, &night, Some(&device)).unwrap();
    let mut shaded = Shaded::default();
    let mut overlapped = Vec::new();
    let mut times = Vec::new();
    pipeline
        .overlapped(0..town.views.len(), |_, frame, lighting| {
            assert!(frame.uploaded > 0);
            times.push((frame.stages_ns(), frame.wall_ns));
            lighting.read(&mut shaded)?;
            overlapped.push(shaded.radiance.clone());
            Ok(())
        })
        .unwrap();
    // Stages that run beside each other are each as long as they are.
    assert!(times.iter().all(|(stages, frame)| *stages > 0 && *frame > 0), "{times:?}");
    assert!(overlapped == found);
}

/// What the device itself finds to be in sight depends on when it answers; what is lit is the cut of
/// the lists that follow from it.
#[test]
fn a_device_that_draws_too_lights_the_cuts_of_its_own_lists() {
    let Some(gpu) = test_gpu() else { return };
    let town = along("tour", 48, [20, 21, 60, 61, 100].into_iter());
    // What is too weak is not lost, so that nothing that is seen is.
    let facades = FacadeCluster { threshold: 0.0, ..FacadeCluster::default() };
    let night = Night { region: RegionTechnique::FacadeCluster(facades), ..Night::default() };
    let device = Device::new(gpu, town.world(false)).unwrap().drawing(&town.objects).unwrap();
    let mut pipeline = Pipeline::new(&town, &night, Some(&device)).unwrap();
    let (plain, mut shaded) = (town.lit(), Shaded::default());
    for index in 0..town.views.len() {
        let counts = pipeline.frame(index, false).unwrap().counts;
        assert!(counts.listed == counts.drawn && counts.cells > 0);
        pipeline.read(&mut shaded).unwrap();
        let points = &town.world(false).frames[index].points;
        for (pixel, point) in points.iter().enumerate().step_by(41) {
            if !point.is_there() {
                continue;
            }
            let used = pipeline.front().starts().of(point.object);
            let starts = PointStarts { used, seen: used, hidden: &[] };
            let parts = decompose(&plain, &town.lights, &night.cut, false, point, starts);
            let off = (parts.result.as_vec3() - shaded.radiance[pixel]).abs().max_element();
            assert!(off < WITHIN, "frame {index}, pixel {pixel}: {off:e}");
            assert_eq!(parts.culled, 0, "frame {index}, pixel {pixel}");
        }
    }
}
