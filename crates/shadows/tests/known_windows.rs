//! Every estimator, from depths to visibilities, on windows whose answer is known by hand. Forms
//! share the packing and the estimators, so holding one against another cannot show a mistake
//! there; this can.
#![allow(clippy::unwrap_used, reason = "the helpers of a test may fail it")]

mod support;

use dapple_shadows::filtering::{
    DepthMap, Estimator, Lookup, Receiver, Settings, VsmVariant, cpu, reference,
};
use support::estimators;

/// Visibility of a receiver in the middle of a window over exactly these depths, one in each
/// column, by the reference and by the CPU form.
fn middle(depths: [f32; 3], z: f32, estimator: Estimator) -> [f64; 2] {
    let map = DepthMap { width: 3, height: 1, depths: depths.to_vec() };
    let s = Settings {
        width_texels: 3,
        bias: 0.0,
        min_variance: 0.0,
        bleed_reduction: 0.25,
        lookup: Lookup::Nearest,
        ..Settings::new(estimator)
    };
    let receivers = [Receiver::new(0.5, 0.5, z)];
    let mut filter = cpu::Filter::new(3, 1, &s).unwrap();
    filter.prefilter(&map).unwrap();
    let mut out = [f32::NAN];
    filter.shade(&map, &receivers, &mut out).unwrap();
    [reference::visibility(&map, &receivers, &s).unwrap()[0], f64::from(out[0])]
}

fn near(got: [f64; 2], expected: f64, what: &str) {
    for got in got {
        assert!((got - expected).abs() < 2e-3, "{what}: {got} is not {expected}");
    }
}

#[test]
fn two_depths_and_a_receiver_at_the_farther_one() {
    for estimator in estimators() {
        // A third of the window occludes. Chebyshev's bound is exact over any increasing warp and
        // in any layer; exp(-0.6 c) is nothing.
        let expected = match estimator {
            Estimator::Hard => 1.0,
            // 1 - erf(sqrt(p / (2 (1 - p)))) = 1 - erf(1/2).
            Estimator::GaussianCdf | Estimator::LayeredGaussian { .. } => 0.4795,
            // t = 1.
            Estimator::PowerCdf | Estimator::LayeredPower { .. } => 0.0,
            // (2/3 - 1/4) / (3/4).
            Estimator::Vsm { variant: VsmVariant::Linstep } => 5.0 / 9.0,
            _ => 2.0 / 3.0,
        };
        near(middle([0.2, 0.8, 0.8], 0.8, estimator), expected, &format!("{estimator:?}"));
    }
    // t = 0.95, beta = 2: (1 - t^2) / (1 - (2/3)^2).
    near(middle([0.2, 0.8, 0.8], 0.77, Estimator::PowerCdf), 0.1755, "power, nearer");
}

#[test]
fn two_depths_between_them_and_beyond_both() {
    for estimator in estimators().into_iter().filter(|e| *e != Estimator::Hard) {
        let what = format!("{estimator:?}");
        // In front of everything.
        near(middle([0.2, 0.8, 0.8], 0.1, estimator), 1.0, &what);
        // Beyond: truth is 0. Chebyshev: var/(var + d^2) = 0.08 / (0.08 + 0.4^2) = 1/3 for VSM.
        let got = middle([0.2, 0.8, 0.8], 1.0, estimator);
        match estimator {
            Estimator::Vsm { variant: VsmVariant::Plain | VsmVariant::MinVariance } => {
                near(got, 1.0 / 3.0, &what);
            }
            Estimator::Vsm { variant: VsmVariant::Linstep } => near(got, 1.0 / 9.0, &what),
            // 1 - erf(0.4 / (sqrt(2) sqrt(0.08))) = 1 - erf(1).
            Estimator::GaussianCdf => near(got, 0.1573, &what),
            // The same bound in the layer of the receiver; splits by the map move its ends.
            Estimator::LayeredVsm { .. } | Estimator::LayeredGaussian { .. } => {
                assert!(got.iter().all(|v| (0.0..1.0 / 3.0 + 2e-3).contains(v)), "{what}: {got:?}");
            }
            // The others know that nothing lies there, or nearly so.
            _ => assert!(got.iter().all(|v| (0.0..0.2).contains(v)), "{what}: {got:?}"),
        }
    }
}

#[test]
fn three_depths_at_the_middle_one() {
    // A third is nearer, a third farther.
    near(middle([0.2, 0.5, 0.8], 0.5, Estimator::Msm), 2.0 / 3.0, "msm");
    near(middle([0.2, 0.5, 0.8], 0.8, Estimator::Msm), 1.0 / 3.0, "msm");
    near(middle([0.2, 0.5, 0.8], 0.5, Estimator::Pcf { taps: 0 }), 2.0 / 3.0, "pcf");
}
