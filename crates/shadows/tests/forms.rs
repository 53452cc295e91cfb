//! The CPU form against the reference.
#![allow(clippy::unwrap_used, reason = "the helpers of a test may fail it")]

mod support;

use dapple_shadows::filtering::faults::{self, Fault};
use dapple_shadows::filtering::{
    DepthMap, Estimator, Format, KernelShape, Lookup, Receiver, Settings, VsmVariant, cpu,
    reference,
};
use support::{KERNELS, LOOKUPS, all_settings, blocks, noise, receivers};

fn cpu_visibility(map: &DepthMap, receivers: &[Receiver], settings: &Settings) -> Vec<f32> {
    let mut filter = cpu::Filter::new(map.width, map.height, settings).unwrap();
    filter.prefilter(map).unwrap();
    let mut out = vec![f32::NAN; receivers.len()];
    filter.shade(map, receivers, &mut out).unwrap();
    out
}

/// Receivers outside their port bounds, and receivers looked at.
fn misses(
    values: impl IntoIterator<Item = f64>,
    map: &DepthMap,
    receivers: &[Receiver],
    settings: &Settings,
) -> (usize, usize) {
    let bounds = reference::port_bounds(map, receivers, settings, reference::CPU_STEPS).unwrap();
    let outside = |(v, (low, high)): (f64, &(f64, f64))| !(*low..=*high).contains(&v);
    (values.into_iter().zip(&bounds).filter(|(v, b)| outside((*v, b))).count(), bounds.len())
}

#[test]
fn cpu_keeps_to_the_port_bounds_everywhere() {
    let maps = [noise(37, 29, 1), blocks(61, 47, 2), blocks(64, 64, 3)];
    let mut checked = 0;
    let mut failures = Vec::new();
    for settings in all_settings() {
        for map in &maps {
            let receivers = receivers(map, 300, 4);
            for kernel in KERNELS {
                for lookup in LOOKUPS {
                    for (width_texels, plane_bias) in [(1, false), (7, true), (9, false)] {
                        let s = Settings { kernel, lookup, width_texels, plane_bias, ..settings };
                        let ours = cpu_visibility(map, &receivers, &s).into_iter().map(f64::from);
                        let (missed, looked_at) = misses(ours, map, &receivers, &s);
                        checked += looked_at;
                        if missed > 0 {
                            failures.push(format!("{missed} of {looked_at}: {s:?}"));
                        }
                    }
                }
            }
        }
    }
    assert!(checked >= 300 * 3 * 12 * 40, "only {checked} receivers");
    assert!(failures.is_empty(), "{} settings\n{}", failures.len(), failures.join("\n"));
}

#[test]
fn separable_windows_equal_the_two_dimensional_ones_at_every_width() {
    // 19 x 13 texels: widths from 15 on reach over two borders at once.
    let map = noise(19, 13, 5);
    let receivers = receivers(&map, 60, 6);
    for estimator in [Estimator::PowerCdf, Estimator::Vsm { variant: VsmVariant::Max }] {
        for kernel in KERNELS {
            for width_texels in (1..=31).step_by(2) {
                let lookup = Lookup::Nearest;
                let s = Settings { kernel, lookup, width_texels, ..Settings::new(estimator) };
                let ours = cpu_visibility(&map, &receivers, &s).into_iter().map(f64::from);
                assert_eq!(misses(ours, &map, &receivers, &s).0, 0, "{s:?}");
            }
        }
    }
}

#[test]
fn one_tap_of_closer_filtering_is_the_hard_map() {
    let map = blocks(33, 21, 7);
    let receivers = receivers(&map, 500, 8);
    for lookup in LOOKUPS {
        for taps in [0, 1] {
            let width_texels = if taps == 0 { 1 } else { 7 };
            let hard = Settings { lookup, ..Settings::new(Estimator::Hard) };
            let pcf = Settings { lookup, width_texels, ..Settings::new(Estimator::Pcf { taps }) };
            assert_eq!(
                cpu_visibility(&map, &receivers, &hard),
                cpu_visibility(&map, &receivers, &pcf)
            );
        }
    }
}

#[test]
fn results_do_not_depend_on_the_threads() {
    let map = blocks(100, 70, 9);
    let receivers = receivers(&map, 5000, 10);
    let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
    for settings in all_settings() {
        let of = |n| pool(n).install(|| cpu_visibility(&map, &receivers, &settings));
        assert_eq!(of(1), of(3), "{settings:?}");
    }
}

/// The bounds would be worthless if they also admitted wrong filters.
#[test]
fn a_window_off_by_one_leaves_the_port_bounds_of_every_setting() {
    let map = noise(37, 29, 11);
    let receivers = receivers(&map, 400, 12);
    for settings in all_settings() {
        let s = Settings { lookup: Lookup::Nearest, ..settings };
        let wrong = faults::visibility(&map, &receivers, &s, Fault::WindowOffByOne).unwrap();
        let (missed, _) = misses(wrong, &map, &receivers, &s);
        assert!(missed >= 20, "{missed} of 400: {s:?}");
    }
}

#[test]
fn every_fault_is_caught_where_it_can_show() {
    let map = noise(37, 29, 13);
    let receivers = receivers(&map, 400, 14);
    let vsm = Estimator::Vsm { variant: VsmVariant::MinVariance };
    for (fault, estimator) in [
        (Fault::PrintedErf, Estimator::GaussianCdf),
        (Fault::MeanBeforeSquare, Estimator::GaussianCdf),
        (Fault::MeanBeforeSquare, vsm),
        (Fault::BilinearMinMax, Estimator::PowerCdf),
        (Fault::WindowOffByOne, vsm),
        (Fault::ClampedReceiver, vsm),
        (Fault::ClampedReceiver, Estimator::Hard),
    ] {
        let s = Settings { width_texels: 3, ..Settings::new(estimator) };
        let right = reference::visibility(&map, &receivers, &s).unwrap();
        assert_eq!(misses(right, &map, &receivers, &s).0, 0);
        let wrong = faults::visibility(&map, &receivers, &s, fault).unwrap();
        let (missed, _) = misses(wrong, &map, &receivers, &s);
        assert!(missed >= 5, "{fault:?} moved {missed} receivers of {estimator:?}");
    }
}

#[test]
fn counters_follow_their_formula_and_ignore_the_width_of_boxes() {
    let map = blocks(50, 40, 15);
    let all_in: Vec<Receiver> = (0..7).map(|_| Receiver::new(0.5, 0.5, 0.5)).collect();
    let counters = |s: &Settings| {
        let mut filter = cpu::Filter::new(50, 40, s).unwrap();
        filter.prefilter(&map).unwrap();
        filter.shade(&map, &all_in, &mut [0.0; 7]).unwrap();
        filter.counters()
    };
    for s in all_settings().into_iter().filter(Settings::prefiltered) {
        let narrow = counters(&Settings { width_texels: 3, ..s });
        assert_eq!(narrow, counters(&Settings { width_texels: 31, ..s }));
        assert_eq!(narrow.prefilter_texels, 2 * 2 * 50 * 40);
        assert_eq!(narrow.shade_texels, 4 * 7);
        assert_eq!(narrow.texels_fetched, narrow.prefilter_texels + narrow.shade_texels);
        let kernel = KernelShape::Gaussian;
        // sigma 31 / sqrt(12) = 8.949: radius 27, 55 weights.
        let wide = counters(&Settings { width_texels: 31, kernel, ..s });
        assert_eq!(wide.prefilter_texels, 2 * 55 * 50 * 40);
    }
    let power = counters(&Settings::new(Estimator::PowerCdf));
    assert_eq!(power.bytes_read, 2 * 2000 * 3 * 4 + 28 * 3 * 4 + 7 * 32);
    assert_eq!(power.bytes_written, 2 * 2000 * 3 * 4 + 7 * 4);
    let pcf = Settings::new(Estimator::Pcf { taps: 0 });
    assert_eq!(counters(&pcf).texels_fetched, 8 * 8 * 7);
    let nearest = Settings { lookup: Lookup::Nearest, ..pcf };
    assert_eq!(counters(&nearest).texels_fetched, 7 * 7 * 7);
    assert_eq!(counters(&nearest.with_format(Format::U16)).prefilter_texels, 2000);
}
