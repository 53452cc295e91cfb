//! The processor's form against the reference.

use dapple_shadows::cascades::cpu::Shadows;
use dapple_shadows::cascades::faults::{self as faulted, Fault};
use dapple_shadows::cascades::reference::{port_bounds, visibility};
use dapple_shadows::cascades::{Cascade, CascadeError, CascadeReceiver, Settings, Taps};
use dapple_shadows::filtering::DepthMap;
use rand::RngExt;

use crate::gpu_support::rng;
use crate::scene::{self, all_settings, cascades, maps, nearest};

/// Receivers of the scene, some of them moved to random depths and slopes and off the map.
pub fn mixed(count: usize, seed: u64) -> Vec<CascadeReceiver> {
    let mut rng = rng(seed);
    let mut all = scene::receivers(count, seed);
    for (i, r) in all.iter_mut().enumerate() {
        match i % 4 {
            0 => {}
            1 => {
                r.depth += rng.random_range(-0.01..0.01f32);
                r.slope_u *= rng.random_range(-3.0..3.0f32);
            }
            2 => r.u += rng.random_range(-0.3..0.3f32),
            _ => {
                r.view_depth = rng.random_range(0.0..120.0f32);
                r.depth = rng.random_range(-0.1..1.1f32);
            }
        }
    }
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1e30, 1e30] {
        let inside = all[0];
        all.push(CascadeReceiver { u: bad, ..inside });
        all.push(CascadeReceiver { v: bad, ..inside });
        all.push(CascadeReceiver { depth: bad, ..inside });
        all.push(CascadeReceiver { view_depth: bad, ..inside });
        all.push(inside.with_slope(bad, 0.1));
        all.push(CascadeReceiver { flags: 0, ..inside });
    }
    all
}

/// Visibilities outside the bounds.
pub fn outside(found: &[f32], bounds: &[(f64, f64)]) -> usize {
    assert_eq!(found.len(), bounds.len());
    // A share of taps in f32 is the share in f64, rounded.
    let off = |v: f64, (low, high): (f64, f64)| v < low - 1e-6 || v > high + 1e-6;
    found.iter().zip(bounds).filter(|(v, b)| off(f64::from(**v), **b)).count()
}

/// Share of receivers that bounds leave open.
pub fn open(bounds: &[(f64, f64)]) -> f64 {
    bounds.iter().filter(|(low, high)| low != high).count() as f64 / bounds.len() as f64
}

fn noise(count: usize, side: u32, seed: u64) -> Vec<DepthMap> {
    let mut rng = rng(seed);
    let map = |_| {
        let depths = (0..side * side).map(|_| rng.random::<f32>()).collect();
        DepthMap { width: side, height: side, depths }
    };
    (0..count).map(map).collect()
}

#[test]
fn the_port_is_the_reference_within_rounding() {
    let side = 61;
    let all = mixed(6000, 4);
    for count in [1, 2, 4, 8] {
        let cascades = cascades(count, 0.7, side, 2);
        // Noise has no surface that a lack of bias could darken.
        let inputs = [
            (maps(&cascades, side, nearest), &Fault::ALL[..]),
            (noise(count, side, 5), &[Fault::NextCascade, Fault::CropOneTexel]),
        ];
        for (maps, faults) in inputs {
            for settings in all_settings() {
                let bounds = port_bounds(&maps, &cascades, &all, &settings).unwrap();
                let shadows = Shadows::new(side, &cascades, &settings).unwrap();
                let mut found = vec![f32::NAN; all.len()];
                shadows.shade(&maps, &all, &mut found).unwrap();
                assert_eq!(outside(&found, &bounds), 0, "{count} {settings:?}");
                assert!(open(&bounds) < 0.01, "{count} {settings:?}: {}", open(&bounds));
                // The reference itself lies within, and each fault without.
                let exact = visibility(&maps, &cascades, &all, &settings).unwrap();
                let exact: Vec<_> = exact.into_iter().map(|v| v as f32).collect();
                assert_eq!(outside(&exact, &bounds), 0);
                for &fault in faults {
                    let faulty =
                        faulted::visibility(&maps, &cascades, &all, &settings, fault).unwrap();
                    let faulty: Vec<_> = faulty.into_iter().map(|v| v as f32).collect();
                    let seen = outside(&faulty, &bounds);
                    let silent = fault == Fault::NextCascade && count == 1;
                    assert!(silent || seen > 20, "{fault:?} {count} {settings:?}: {seen}");
                }
            }
        }
    }
}

#[test]
fn counters_by_hand() {
    let cascades = [
        Cascade { near: 1.0, far: 2.0, offset: [0.0, 0.0], scale: 0.5 },
        Cascade { near: 2.0, far: 4.0, offset: [0.5, 0.5], scale: 0.5 },
        Cascade { near: 4.0, far: 8.0, offset: [0.0, 0.0], scale: 0.0 },
    ];
    let at = |u, v, view| CascadeReceiver::at(u, v, 0.5, view);
    // In the first, in the second, outside its own, in the empty one, none.
    let all = [
        at(0.25, 0.25, 1.5),
        at(0.75, 0.75, 3.0),
        at(0.25, 0.25, 3.0),
        at(0.25, 0.25, 5.0),
        CascadeReceiver { flags: 0, ..at(0.25, 0.25, 1.5) },
    ];
    let shadows = Shadows::new(16, &cascades, &Settings::new(Taps::Box3)).unwrap();
    let counters = shadows.counters(&all);
    assert_eq!(counters.geometry_passes, 3);
    assert_eq!((counters.map_texels, counters.map_bytes), (3 * 256, 3 * 1024));
    assert_eq!(counters.shade_texels, 2 * 9);
    assert_eq!(counters.bytes_read, 18 * 4 + 5 * 32);
    assert_eq!(counters.bytes_written, 3 * 1024 + 5 * 4);
}

#[test]
fn sizes_that_do_not_fit_are_refused() {
    let good = cascades(2, 0.5, 8, 0);
    let settings = Settings::new(Taps::One);
    for side in [0, 1 << 20] {
        let refused = Shadows::new(side, &good, &settings).unwrap_err();
        assert!(matches!(refused, CascadeError::Knob { name: "side", .. }));
    }
    assert!(matches!(Shadows::new(8, &[], &settings), Err(CascadeError::Count { count: 0 })));
    let shadows = Shadows::new(8, &good, &settings).unwrap();
    let maps = maps(&good, 8, nearest);
    let all = scene::receivers(3, 1);
    let refused = shadows.shade(&maps, &all, &mut [0.0; 2]).unwrap_err();
    assert_eq!(refused, CascadeError::Length { what: "results", expected: 3, actual: 2 });
    assert!(shadows.shade(&maps[1..], &all, &mut [0.0; 3]).is_err());
    let small = noise(2, 4, 1);
    let refused = shadows.shade(&small, &all, &mut [0.0; 3]).unwrap_err();
    assert!(matches!(refused, CascadeError::Map { cascade: 0, .. }));
}

#[test]
fn a_map_of_one_texel_serves() {
    let one = [DepthMap { width: 1, height: 1, depths: vec![0.5] }];
    let all = [0.4, 0.6].map(|z| CascadeReceiver::at(0.3, 0.9, z, 1.5));
    for taps in Taps::ALL {
        let shadows = Shadows::new(1, &[Cascade::whole(1.0, 2.0)], &Settings::new(taps)).unwrap();
        let mut found = [f32::NAN; 2];
        shadows.shade(&one, &all, &mut found).unwrap();
        assert_eq!(found, [1.0, 0.0], "{taps:?}");
    }
}
