//! Layers of opacity on the device against the reference, on the device's own fragments.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod gpu_support;

use dapple_gpu::Gpu;
use dapple_gpu::light_space::LightSpaceMesh;
use dapple_opacity_maps::gpu::fragments;
use dapple_opacity_maps::layered::reference::LayeredReference;
use dapple_opacity_maps::reference::Reference;
use dapple_opacity_maps::{Code, Fragments, Receiver, Settings};
use gpu_support::{MODEL, bounded, exclusive_gpu, foliage, frame, plain, receivers};

const SIZE: [u32; 2] = [67, 45];

/// Largest difference from the reference over receivers that no rounding can tip, and how many
/// receivers there are of those and of the others.
fn worst(
    settings: &Settings,
    fragments: &Fragments,
    receivers: &[Receiver],
    got: &[f32],
) -> (f64, usize, usize) {
    assert_eq!(receivers.len(), got.len());
    let reference = Reference::new(settings, fragments).unwrap();
    let Code::Layered(layered) = &settings.code else { unreachable!() };
    let ties = LayeredReference::new(layered, settings.opaque, fragments);
    let (mut worst, mut judged, mut tied) = (0.0f64, 0, 0);
    for (receiver, &got) in receivers.iter().zip(got) {
        assert!((0.0..=1.0).contains(&got), "{got}");
        if ties.near_tie(settings, receiver) {
            tied += 1;
            continue;
        }
        judged += 1;
        let error = (f64::from(got) - reference.transmittance(receiver)).abs();
        worst = worst.max(error);
    }
    (worst, judged, tied)
}

fn check(gpu: &Gpu, mesh: &LightSpaceMesh, settings: &Settings) -> f64 {
    let own = fragments(gpu, mesh, MODEL, SIZE).unwrap();
    let receivers = receivers(9, 3000);
    let drawn = frame(gpu, mesh, &receivers, SIZE, settings);
    let (worst, judged, tied) = worst(settings, &own, &receivers, &drawn.transmittances);
    eprintln!("{worst:.1e} over {judged} receivers, {tied} near ties: {:?}", settings.code);
    assert!(judged > 2000, "{judged}");
    worst
}

#[test]
fn the_default_is_the_reference_on_the_devices_own_fragments() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let mesh = foliage(3, 200);
    let error = check(gpu, &mesh, &plain(bounded(16)));
    assert!(error < 1e-5, "{error}");
}
