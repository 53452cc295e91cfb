//! Properties of the estimators over arbitrary windows.

mod support;

use dapple_shadows::filtering::channels::Reduction;
use dapple_shadows::filtering::estimators::{
    Real, chebyshev, exponential, gaussian, moments, power,
};
use dapple_shadows::filtering::kernel::Kernel;
use dapple_shadows::filtering::windows::Scratch;
use dapple_shadows::filtering::{
    EsmSpace, Estimator, KernelShape, Lookup, Receiver, Settings, Splits, VsmVariant, reference,
};
use proptest::prelude::*;
use support::{cases, map, noise, receivers};

struct Window {
    depths: Vec<f64>,
    mean: f64,
    square: f64,
    min: f64,
    max: f64,
}

fn window(depths: Vec<f64>) -> Window {
    let n = depths.len() as f64;
    let mean = depths.iter().sum::<f64>() / n;
    let square = depths.iter().map(|z| z * z).sum::<f64>() / n;
    let min = depths.iter().copied().fold(f64::INFINITY, f64::min);
    let max = depths.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Window { depths, mean, square, min, max }
}

fn exact(w: &Window, z: f64) -> f64 {
    w.depths.iter().filter(|&&o| o >= z).count() as f64 / w.depths.len() as f64
}

/// VSM, Gaussian CDF and power CDF at one receiver, in the precision of `R`.
fn three<R: Real>(w: &Window, z: f64) -> [R; 3] {
    let (mean, square, z) = (R::of(w.mean), R::of(w.square), R::of(z));
    [
        chebyshev::visibility(mean, square, z, R::of(0.0)),
        gaussian::visibility(mean, square, z, R::of(0.0)),
        power::visibility(R::of(w.min), R::of(w.max), mean, z, R::of(0.0)),
    ]
}

fn depths() -> impl Strategy<Value = Vec<f64>> {
    let any = prop::collection::vec(0.0..1.0f64, 1..50);
    // A few depths in many texels: edges, one depth, near-equal depths.
    let few = (prop::collection::vec(0.0..1.0f64, 1..3), prop::collection::vec(0usize..3, 1..50))
        .prop_map(|(values, picks)| picks.iter().map(|i| values[i % values.len()]).collect());
    let close = prop::collection::vec(0.5..0.500_001f64, 1..20);
    prop_oneof![any, few, close]
}

/// The same with depths at both ends and between, so that no moment matrix is near singular.
fn spread() -> impl Strategy<Value = Vec<f64>> {
    depths().prop_map(|mut depths| {
        depths.extend([0.0, 0.4, 1.0]);
        depths
    })
}

proptest! {
    #![proptest_config(cases())]

    // P7.1
    #[test]
    fn visibilities_fall_from_one_to_zero(depths in depths()) {
        let w = window(depths);
        let mut before = [1.0f64; 3];
        let mut before32 = [1.0f32; 3];
        for i in 0..=400 {
            let z = f64::from(i) / 200.0 - 0.5;
            let v = three::<f64>(&w, z);
            let v32 = three::<f32>(&w, z);
            for e in 0..3 {
                prop_assert!((0.0..=1.0).contains(&v[e]) && (0.0..=1.0).contains(&v32[e]));
                prop_assert!(v[e] <= before[e] + 1e-12, "{} at {}", e, z);
                prop_assert!(v32[e] <= before32[e] + 1e-6);
                if z <= w.mean {
                    prop_assert_eq!(v[e], 1.0);
                }
            }
            (before, before32) = (v, v32);
        }
    }

    #[test]
    fn visibilities_are_continuous_at_the_mean(depths in spread()) {
        let w = window(depths);
        let sigma = (w.square - w.mean * w.mean).max(0.0).sqrt();
        prop_assert!(sigma > 0.05);
        for v in three::<f64>(&w, w.mean + 1e-9 * sigma) {
            prop_assert!(v > 1.0 - 1e-5, "{}", v);
        }
    }

    // P7.2, P7.3
    #[test]
    fn chebyshev_bounds_the_exact_share_and_the_gaussian(depths in depths(), z in 0.0..1.0f64) {
        let w = window(depths);
        for z in w.depths.iter().copied().chain([z]) {
            // An equal depth and its mean may differ in the last digit.
            let shifted = z - 1e-12;
            let [cheb, gauss, _] = three::<f64>(&w, shifted);
            let sigma2 = w.square - w.mean * w.mean;
            if sigma2 > 1e-9 {
                prop_assert!(cheb >= exact(&w, z) - 1e-6);
            }
            prop_assert!(gauss <= cheb + 1e-15);
            let [cheb, gauss, _] = three::<f32>(&w, shifted);
            prop_assert!(gauss <= cheb + f32::EPSILON);
        }
    }

    // P7.4
    #[test]
    fn power_fit_reproduces_the_mean(min in 0.0..0.5f64, range in 0.01..0.5f64, share in 0.02..0.98f64) {
        let mean = min + share * range;
        let beta = power::exponent(min, min + range, mean);
        prop_assert!(beta > 0.0);
        // E[z] = max - integral of F; substituting t = s^4 tames beta < 1 at 0.
        let n = 4000;
        let mut integral = 0.0;
        for i in 0..n {
            let s: f64 = (f64::from(i) + 0.5) / f64::from(n);
            integral += s.powi(4).powf(beta) * 4.0 * s.powi(3) / f64::from(n);
        }
        prop_assert!((min + range - integral * range - mean).abs() < 1e-5 * range.max(0.1));
    }

    // P7.5
    #[test]
    fn filtered_mean_and_variance_stay_within_the_range(
        line in prop::collection::vec(0.0..1.0f64, 1..40), half in 0u32..20, gauss: bool,
    ) {
        let shape = if gauss { KernelShape::Gaussian } else { KernelShape::Box };
        let kernel = Kernel::new(shape, 2 * half + 1);
        let run = |reduction, f: &dyn Fn(f64) -> f64| {
            let mut scratch = Scratch::new(line.len(), kernel.radius());
            let inner = scratch.inner(line.len(), kernel.radius());
            for (slot, &z) in inner.iter_mut().zip(&line) {
                slot.fill(f(z));
            }
            let mut out = Vec::new();
            scratch.filter(reduction, &kernel, line.len(), |_, lanes| out.push(lanes[3]));
            out
        };
        let mean = run(Reduction::Mean, &|z| z);
        let square = run(Reduction::Mean, &|z| z * z);
        let min = run(Reduction::Min, &|z| z);
        let max = run(Reduction::Max, &|z| z);
        prop_assert_eq!(mean.len(), line.len());
        for i in 0..line.len() {
            prop_assert!(min[i] - 1e-14 <= mean[i] && mean[i] <= max[i] + 1e-14);
            let variance = square[i] - mean[i] * mean[i];
            prop_assert!(variance <= 0.25 * (max[i] - min[i]).powi(2) + 1e-14);
        }
    }

    // P7.7; ranges of 1e-3 to 1e6 as they are before normalisation.
    #[test]
    fn affine_depths_change_nothing(
        depths in prop::collection::vec(0.0..1.0f64, 2..40), z in 0.0..1.0f64,
        scale in -3.0..6.0f64, offset in 0.0..10.0f64,
    ) {
        let w = window(depths);
        prop_assume!(w.max - w.min > 1e-2);
        let scale = 10f64.powf(scale);
        let moved = window(w.depths.iter().map(|d| scale * (d + offset)).collect());
        let (a, b) = (three::<f64>(&w, z), three::<f64>(&moved, scale * (z + offset)));
        for (a, b) in a.iter().zip(b) {
            prop_assert!((a - b).abs() < 1e-6, "{} {}", a, b);
        }
    }

    // P7.8, P7.9
    #[test]
    fn one_depth_is_a_step_and_beyond_the_maximum_is_dark(depth in 0.01..0.9f64, dz in 1e-4..0.1f64) {
        let w = window(vec![depth; 9]);
        let exact_square = Window { square: depth * depth, mean: depth, ..w };
        prop_assert_eq!(three::<f64>(&exact_square, depth - dz), [1.0; 3]);
        prop_assert_eq!(three::<f64>(&exact_square, depth), [1.0; 3]);
        prop_assert_eq!(three::<f64>(&exact_square, depth + dz), [0.0; 3]);
    }

    // P7.11
    #[test]
    fn exponential_is_never_darker_than_the_exact_share(depths in depths(), c in 1.0..88.0f64) {
        let w = window(depths);
        let share = 1.0 / w.depths.len() as f64;
        let mean = w.depths.iter().map(|&z| share * exponential::warp(z, c)).sum::<f64>();
        let log = exponential::log_mean(w.depths.iter().map(|&z| (share, z)), c);
        for i in 0..=50 {
            let z = f64::from(i) / 50.0;
            let v = exponential::visibility(mean, z, c);
            prop_assert!(v >= exact(&w, z) - 1e-12);
            prop_assert!((v - exponential::visibility_log(log, z, c)).abs() < 1e-9);
        }
    }

    #[test]
    fn four_moments_bound_the_exact_share_tighter_than_two(depths in spread(), z in 0.0..1.0f64) {
        let w = window(depths);
        let mut b = [0.0; 4];
        for &depth in &w.depths {
            for (sum, power) in b.iter_mut().zip(moments::pack(depth)) {
                *sum += power / w.depths.len() as f64;
            }
        }
        let v = moments::visibility(b, z, 0.0, 0.375);
        prop_assert!((0.0..=1.0).contains(&v));
        prop_assert!(v >= exact(&w, z) - 1e-6, "{} {}", v, exact(&w, z));
        let two = chebyshev::visibility(w.mean, w.square, z, 0.0);
        prop_assert!(v <= two + 1e-6, "{} {}", v, two);
    }
}

fn three_planes(share: u32) -> dapple_shadows::filtering::DepthMap {
    map(16, 16, |x, _| if x % 8 < share { 0.2 } else { 0.5 })
}

// P7.9 through the whole chain
#[test]
fn beyond_every_stored_depth_power_and_maximum_are_dark() {
    let mut dim = noise(33, 33, 20);
    dim.depths.iter_mut().for_each(|z| *z *= 0.5);
    for settings in support::all_settings() {
        let dark = matches!(
            settings.estimator,
            Estimator::PowerCdf | Estimator::Vsm { variant: VsmVariant::Max } | Estimator::Hard
        ) || matches!(settings.estimator, Estimator::Pcf { .. });
        if dark {
            let mut r = receivers(&dim, 200, 21);
            r.iter_mut().for_each(|r| *r = Receiver::new(r.u.clamp(0.0, 1.0), 0.5, 0.502));
            let v = reference::visibility(&dim, &r, &settings).unwrap();
            assert!(v.iter().all(|&v| v == 0.0), "{settings:?}");
        }
    }
}

// P7.10
#[test]
fn an_unoccluded_plane_is_lit_at_any_slope() {
    let side = 64u32;
    let esm = Estimator::Esm { space: EsmSpace::Linear };
    let vsm = Estimator::Vsm { variant: VsmVariant::Plain };
    let lit = [Estimator::GaussianCdf, Estimator::PowerCdf, esm, vsm];
    let pcf = Estimator::Pcf { taps: 0 };
    for (a, b) in [(0.0, 0.0), (0.3, 0.1), (-0.45, 0.45), (0.9, 0.0)] {
        let plane = |u: f32, v: f32| 0.5 + a * (u - 0.5) + b * (v - 0.5);
        let map = map(side, side, |x, y| {
            plane((x as f32 + 0.5) / side as f32, (y as f32 + 0.5) / side as f32)
        });
        // Away from the border, where repeated texels are not the plane.
        let at = |i: u32| 0.25 + 0.5 * (i as f32 + 0.37) / 23.0;
        let r: Vec<Receiver> = (0..23 * 23)
            .map(|i| (at(i % 23), at(i / 23)))
            .map(|(u, v)| Receiver::new(u, v, plane(u, v)).with_slope(a, b))
            .collect();
        for lookup in support::LOOKUPS {
            for estimator in lit.into_iter().chain([Estimator::Hard, pcf]) {
                let plane_bias = true;
                let s = Settings { lookup, plane_bias, ..Settings::new(estimator) };
                let v = reference::visibility(&map, &r, &s).unwrap();
                let darkest = v.iter().copied().fold(1.0, f64::min);
                assert!(darkest > 1.0 - 1e-6, "{a} {b} {estimator:?}: {darkest}");
            }
        }
        if a != 0.0 {
            let v = reference::visibility(&map, &r, &Settings::new(pcf)).unwrap();
            assert!(v.iter().any(|&v| v < 0.9), "control: without plane bias nothing darkened");
        }
    }
}

// P7.11 through the whole chain
#[test]
fn exponential_maps_are_never_darker_than_closer_filtering() {
    let map = noise(40, 30, 22);
    let r = receivers(&map, 400, 23);
    for kernel in support::KERNELS {
        let of = |estimator| {
            let s = Settings { kernel, lookup: Lookup::Nearest, ..Settings::new(estimator) };
            reference::visibility(&map, &r, &s).unwrap()
        };
        let pcf = of(Estimator::Pcf { taps: 0 });
        for space in [EsmSpace::Linear, EsmSpace::Log] {
            for (v, exact) in of(Estimator::Esm { space }).iter().zip(&pcf) {
                assert!(*v >= exact - 1e-5);
            }
        }
    }
}

// P7.12
#[test]
fn one_layer_is_the_plain_estimator() {
    let map = noise(40, 30, 24);
    let r = receivers(&map, 400, 25);
    for splits in [Splits::Uniform, Splits::Lloyd] {
        for (layered, plain) in [
            (Estimator::LayeredVsm { splits }, Estimator::Vsm { variant: VsmVariant::MinVariance }),
            (Estimator::LayeredGaussian { splits }, Estimator::GaussianCdf),
            (Estimator::LayeredPower { splits }, Estimator::PowerCdf),
        ] {
            let one = Settings { layers: 1, ..Settings::new(layered) };
            assert_eq!(
                reference::visibility(&map, &r, &one).unwrap(),
                reference::visibility(&map, &r, &Settings::new(plain)).unwrap()
            );
        }
    }
}

#[test]
fn layers_reduce_the_leak_and_the_new_estimators_leak_less() {
    let map = three_planes(4);
    let r: Vec<Receiver> = (4..12).map(|i| Receiver::new(i as f32 / 16.0, 0.5, 0.6)).collect();
    let leak = |estimator, layers| {
        let s = Settings { layers, ..Settings::new(estimator) };
        let v = reference::visibility(&map, &r, &s).unwrap();
        v.iter().sum::<f64>() / v.len() as f64
    };
    for splits in [Splits::Uniform, Splits::Lloyd] {
        let mut before = f64::INFINITY;
        for layers in [1, 2, 4, 8] {
            let vsm = leak(Estimator::LayeredVsm { splits }, layers);
            // Lloyd has two depths to split and is done with two layers.
            assert!(vsm < before || vsm < 0.01, "{layers} layers: {vsm} after {before}");
            assert!(leak(Estimator::LayeredGaussian { splits }, layers) <= vsm);
            assert!(leak(Estimator::LayeredPower { splits }, layers) <= vsm);
            before = vsm;
        }
        assert!(before < 0.01, "{splits:?} still leaks {before}");
    }
    assert!(leak(Estimator::LayeredVsm { splits: Splits::Uniform }, 1) > 0.1);
}
