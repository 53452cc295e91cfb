//! What has a closed answer.

use crate::support::{self, Texel, at};
use dapple_opacity_maps::{
    Code, Format, Fourier, Fragment, Moments, Opaque, Order, Settings, fourier, moments, reference,
};
use std::f64::consts::{PI, TAU};

/// Largest difference from the truth at the probes.
fn worst(settings: &Settings, fragments: &[Fragment]) -> f64 {
    let texel = Texel::new(settings, fragments);
    let error = |d: f32| (f64::from(texel.t(d)) - reference::exact(fragments, d)).abs();
    support::probes(fragments).into_iter().map(error).fold(0.0, f64::max)
}

#[test]
fn one_fragment_is_exact_wherever_rays_have_ends() {
    let mut checked = 0;
    for omega in [0.0, 1e-3, 0.7, 30.0] {
        let one = [at(0.4, omega)];
        for settings in support::all() {
            let exact = support::meets_both_ends(&settings.code)
                && !matches!(&settings.code, Code::Stochastic(_) | Code::Binary)
                && !matches!(&settings.code, Code::Deep(d) if d.tolerance > 0.0);
            if exact {
                let half = |format| if format == Format::F16 { 1e-3 } else { 1e-6 };
                let bound = match &settings.code {
                    Code::Fourier(f) => half(f.format),
                    Code::Moments(m) => half(m.format),
                    _ => 1e-6,
                };
                assert!(worst(&settings, &one) <= bound, "{:?} {omega}", settings.code);
                checked += 1;
            }
        }
    }
    assert!(checked >= 60, "{checked}");
}

#[test]
fn enough_nodes_are_exact_and_one_fewer_is_not() {
    let fragments = support::hair(3, 16);
    for order in [Order::Drawn, Order::Sorted] {
        assert!(worst(&support::adaptive(16, order), &fragments) < 1e-6);
        assert!(worst(&support::adaptive(15, order), &fragments) > 1e-4);
    }
    assert!(worst(&support::deep(0.0, 32), &fragments) < 1e-6);
    assert!(worst(&support::deep(0.0, 31), &fragments) > 1e-4);
    // Fragments at one depth are one node of an adaptive map, two of a deep one.
    let mut doubled = fragments.clone();
    doubled.extend(&fragments);
    assert!(worst(&support::adaptive(16, Order::Drawn), &doubled) < 1e-6);
    assert!(worst(&support::deep(0.0, 32), &doubled) < 1e-6);
}

/// The staircase of nodes by definition, where `worse(a, b)` picks which of two areas goes.
fn staircase(fragments: &[Fragment], nodes: usize, worse: fn(f64, f64) -> bool) -> Vec<(f32, f64)> {
    let mut steps: Vec<(f32, f64)> = Vec::new();
    for f in fragments {
        let through = (-f64::from(f.omega)).exp();
        let place = steps.partition_point(|s| s.0 <= f.depth);
        let before = if place == 0 { 1.0 } else { steps[place - 1].1 };
        steps[place..].iter_mut().for_each(|s| s.1 *= through);
        steps.insert(place, (f.depth, before * through));
        if steps.len() > nodes {
            let area = |i: usize| {
                let before = if i == 0 { 1.0 } else { steps[i - 1].1 };
                (before - steps[i].1) * f64::from(steps[i + 1].0 - steps[i].0)
            };
            let mut goes = 0;
            for i in 1..steps.len() - 1 {
                if worse(area(i), area(goes)) {
                    goes = i;
                }
            }
            steps.remove(goes);
        }
    }
    steps
}

#[test]
fn an_adaptive_map_removes_the_node_of_least_area() {
    let (mut agree, mut differ) = (0, 0);
    for seed in 0..20 {
        let fragments = support::hair(seed, 25);
        let texel = Texel::new(&support::adaptive(8, Order::Drawn), &fragments);
        let stored: Vec<(f32, f32)> = texel.words.chunks(2).map(|n| (n[0], n[1])).collect();
        let near = |steps: &[(f32, f64)]| {
            steps.iter().zip(&stored).all(|(a, b)| a.0 == b.0 && (a.1 as f32 - b.1).abs() < 1e-6)
        };
        agree += u32::from(near(&staircase(&fragments, 8, |a, b| a < b)));
        // Control: the node of most area goes.
        differ += u32::from(!near(&staircase(&fragments, 8, |a, b| a > b)));
    }
    assert_eq!((agree, differ), (20, 20));
}

#[test]
fn a_deep_map_keeps_what_it_needs() {
    // Two steps, each two nodes; merged by one straight piece where the error allows.
    let steps = [at(0.2, 0.05), at(0.8, 0.05)];
    let used = |tolerance| {
        let texel = Texel::new(&support::deep(tolerance, 8), &steps);
        texel.words[0]
    };
    assert_eq!(used(0.0), 4.0);
    assert_eq!(used(0.06), 2.0);
    // By hand: tolerance 0.06, T = 1, 0.9512, 0.9048. From (0.2, 1) to the last vertex.
    let texel = Texel::new(&support::deep(0.06, 8), &steps);
    assert_eq!(texel.words[1..3], [0.2, 1.0]);
    assert!((texel.words[3] - 0.8).abs() < 1e-7);
    assert!((texel.words[4] - (-0.1f32).exp()).abs() < 1e-6, "{:?}", texel.words);
}

#[test]
fn a_fourier_series_of_one_fragment_is_the_closed_sum() {
    let settings = Fourier { pairs: 5, bounded: false, format: Format::F32 };
    for (c, omega) in [(0.3f32, 1.0f32), (0.5, 2.5), (0.9, 0.1)] {
        for d in [0.1f32, 0.29, 0.3, 0.5, 0.77, 0.95] {
            let (x, y) = (f64::from(d), f64::from(c));
            let term = |k: f64| ((TAU * k * (x - y)).sin() + (TAU * k * y).sin()) / (PI * k);
            let sum: f64 = (1..=5).map(|k| term(f64::from(k))).sum();
            let closed = f64::from(omega) * (x + sum);
            let ours = fourier::reference_omega(&settings, &[at(c, omega)], None, false, d);
            assert!((ours - closed).abs() < 1e-12, "{ours} {closed}");
            // Control: sines of the wrong sign are another series.
            let wrong = |k: f64| ((TAU * k * (x + y)).sin() - (TAU * k * y).sin()) / (PI * k);
            let wrong = f64::from(omega) * (x + (1..=5).map(|k| wrong(f64::from(k))).sum::<f64>());
            assert!((ours - wrong).abs() > 1e-3 || (c == 0.5), "{ours} {wrong}");
        }
    }
}

#[test]
fn an_even_slab_is_straight() {
    // Absorption that is even over the range has no coefficient but a_0.
    let n = 500;
    let slab: Vec<_> = (0..n).map(|i| at((i as f32 + 0.5) / n as f32, 2.0 / n as f32)).collect();
    for settings in [support::fourier(7, false, Format::F32), support::deep(0.01, 64)] {
        let texel = Texel::new(&settings, &slab);
        for i in 0..=100 {
            let d = i as f32 / 100.0;
            let analytic = (-2.0 * d).exp();
            assert!((texel.t(d) - analytic).abs() < 0.012, "{:?} {d}", settings.code);
        }
    }
    // Two straight pieces would do for an error of 0.02 over e^-2d.
    let texel = Texel::new(&support::deep(0.02, 64), &slab);
    assert!(texel.words[0] <= 5.0, "{}", texel.words[0]);
}

#[test]
fn moments_meet_as_many_depths_as_half_their_number() {
    let three = [at(0.2, 0.3), at(0.45, 0.6), at(0.9, 0.5)];
    for (count, fragments) in [(4, &three[..2]), (6, &three[..])] {
        let settings = |bias| Moments {
            moments: count,
            bias,
            overestimation: 0.5,
            bounded: false,
            format: Format::F32,
        };
        for d in [0.05f32, 0.3, 0.4, 0.6, 0.7, 0.97] {
            let truth = reference::exact(fragments, d);
            let t = |bias| moments::reference(&settings(bias), fragments, None, false, d);
            assert!((t(1e-10) - truth).abs() < 1e-4, "{count} {d}: {} {truth}", t(1e-10));
        }
        // Control: another distribution's moments, and one depth too many.
        let t = |bias| moments::reference(&settings(bias), fragments, None, false, 0.3);
        assert!((t(0.5) - reference::exact(fragments, 0.3)).abs() > 0.02);
    }
    let four = Moments {
        moments: 4,
        bias: 1e-10,
        overestimation: 0.5,
        bounded: false,
        format: Format::F32,
    };
    let t = moments::reference(&four, &three, None, false, 0.6);
    assert!((t - reference::exact(&three, 0.6)).abs() > 0.01, "{t}");
}

#[test]
fn moments_bound_the_truth_from_both_sides() {
    let mut checked = 0;
    for seed in 0..20 {
        let fragments = support::hair(seed, 40);
        for count in [4, 6] {
            let t = |overestimation, d| {
                let settings = Moments {
                    moments: count,
                    bias: 1e-9,
                    overestimation,
                    bounded: false,
                    format: Format::F32,
                };
                moments::reference(&settings, &fragments, None, false, d)
            };
            let mut before = [1.0; 3];
            for i in 1..100 {
                let d = i as f32 / 100.0;
                let truth = reference::exact(&fragments, d);
                let now = [t(0.0, d), t(0.6, d), t(1.0, d)];
                assert!(now[0] <= truth + 1e-5 && truth <= now[2] + 1e-5, "{now:?} {truth}");
                assert!(now[0] <= now[1] && now[1] <= now[2]);
                // Both bounds and what lies between fall with depth.
                assert!(now.iter().zip(before).all(|(now, before)| *now <= before + 1e-6));
                before = now;
                checked += 1;
            }
        }
    }
    assert_eq!(checked, 20 * 2 * 99);
}

#[test]
fn an_opaque_caster_of_weight_is_one_more_fragment() {
    let translucent = [at(0.2, 0.3), at(0.5, 0.4)];
    let trunk = at(0.7, 3.0);
    let all = [translucent[0], translucent[1], trunk];
    for mut settings in support::all() {
        settings.opaque = Opaque::Weight { weight: 3.0, in_bounds: true };
        let code = || dapple_opacity_maps::code::of(&settings);
        let apart = Texel::with_code(code(), 5, &translucent, Some(trunk));
        let together = Texel::with_code(code(), 5, &all, None);
        assert_eq!(apart.used(), together.used(), "{:?}", settings.code);
        // Without a place in the bounds it shows only behind them, and in full.
        settings.opaque = Opaque::Weight { weight: 3.0, in_bounds: false };
        let code = dapple_opacity_maps::code::of(&settings);
        let beyond = Texel::with_code(code, 5, &translucent, Some(trunk));
        let t = beyond.t(1.5);
        let expected = together.t(1.5);
        assert_eq!(t, expected, "{:?}", settings.code);
    }
}

#[test]
fn bytes_and_passes_are_those_of_the_layout() {
    let expected = [
        (Settings::plain(Code::Binary), 4, 1),
        (support::fourier(3, false, Format::F16), 14, 1),
        (support::fourier(7, true, Format::F32), 68, 2),
        (support::moments(4, false, Format::F16), 10, 1),
        (support::moments(6, true, Format::F32), 36, 2),
        (support::adaptive(8, Order::Drawn), 64, 1),
        (support::stochastic(16, 0), 64, 1),
        (support::deep(0.01, 32), 260, 1),
    ];
    for (settings, bytes, passes) in expected {
        let code = dapple_opacity_maps::code::of(&settings);
        assert_eq!((code.bytes_per_texel(), code.geometry_passes()), (bytes, passes));
        if !matches!(settings.code, Code::Fourier(_) | Code::Moments(_)) {
            assert_eq!(code.bytes_per_texel(), 4 * code.words() as u64);
        }
        let used = code.used_bytes(&vec![3.0; code.words()]);
        assert_eq!(used, if matches!(settings.code, Code::Deep(_)) { 28 } else { bytes });
    }
}
