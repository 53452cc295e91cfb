//! Estimators that bound the exact share from above: Chebyshev and its warped forms, moments,
//! exponentials.

use super::{About, gate, input};
use crate::{
    SuiteError,
    verify::{Gate, GateContext, Tally},
};
use dapple_shadows::filtering::estimators::{
    chebyshev, exponential, exponential_variance as evsm, moments,
};
use rand::RngExt;

/// A visibility from a window and a receiver's depth; honest or faulty.
type Estimate = fn(&[f64], f64, bool) -> f64;

const MEAN_FIRST: &str = "depths are averaged before they are squared";

pub fn gates() -> Vec<Gate> {
    let about = |technique, name, statement, fault| About { technique, name, statement, fault };
    let bound = "visibility is at least the exact share of depths that are not nearer";
    vec![
        gate(about("vsm", "P7.2 bound", bound, MEAN_FIRST), |c, f| bounds("vsm", vsm, c, f)),
        gate(about("evsm", "P7.2 bound", bound, MEAN_FIRST), |c, f| {
            bounds("evsm", evsm_four, c, f)
        }),
        gate(about("msm", "P7.2 bound", bound, MEAN_FIRST), |c, f| bounds("msm", msm, c, f)),
        gate(
            about("esm", "P7.11 bound", bound, "the mean depth stands for the mean exponential"),
            |c, f| bounds("esm", esm, c, f),
        ),
        gate(
            about(
                "vsm",
                "P7.9 beyond the maximum",
                "with the maximum, a receiver beyond every depth is dark",
                "the maximum is not used",
            ),
            beyond_maximum,
        ),
        gate(
            about(
                "vsm",
                "P7.8 one depth",
                "a window of one depth is a step function without NaN",
                "the quotient 0/0 is not guarded",
            ),
            one_depth,
        ),
        gate(
            about(
                "vsm",
                "P7.7 affine",
                "an affine change of all depths changes nothing",
                "a minimum variance that does not scale",
            ),
            affine,
        ),
        gate(
            about(
                "evsm",
                "both warps",
                "the smaller of both bounds is at most the positive warp's",
                "the larger of both",
            ),
            both_warps,
        ),
        gate(
            about(
                "msm",
                "four moments",
                "four moments bound at least as tightly as two",
                "depths shifted between the moments",
            ),
            four_moments,
        ),
    ]
}

fn vsm(window: &[f64], z: f64, faulty: bool) -> f64 {
    let m = input::mean(window, |d| d);
    let square = if faulty { m * m } else { input::mean(window, |d| d * d) };
    chebyshev::visibility(m, square, z, 0.0)
}

const C: f64 = 5.54;

fn evsm_four(window: &[f64], z: f64, faulty: bool) -> f64 {
    let p = input::mean(window, |d| evsm::warp_positive(d, C));
    let n = input::mean(window, |d| evsm::warp_negative(d, C));
    let square = |f: &dyn Fn(f64) -> f64, m: f64| {
        if faulty { m * m } else { input::mean(window, |d| f(d) * f(d)) }
    };
    let pp = square(&|d| evsm::warp_positive(d, C), p);
    let nn = square(&|d| evsm::warp_negative(d, C), n);
    evsm::visibility4([p, pp, n, nn], z, C, 0.0)
}

/// The negative warp's bound alone: no depth lies beyond a positive mean without end.
fn evsm_negative(window: &[f64], z: f64) -> f64 {
    let n = input::mean(window, |d| evsm::warp_negative(d, C));
    let nn = input::mean(window, |d| evsm::warp_negative(d, C).powi(2));
    evsm::visibility4([f64::MAX, f64::MAX, n, nn], z, C, 0.0)
}

fn msm(window: &[f64], z: f64, faulty: bool) -> f64 {
    let b = if faulty {
        moments::pack(input::mean(window, |d| d))
    } else {
        std::array::from_fn(|i| input::mean(window, |d| moments::pack(d)[i]))
    };
    moments::visibility(b, z, 0.0, moments::bias_target(false))
}

fn esm(window: &[f64], z: f64, faulty: bool) -> f64 {
    let c = 80.0;
    let weight = 1.0 / window.len() as f64;
    let soft = exponential::log_mean(window.iter().map(|d| (weight, *d)), c);
    let stored = if faulty { input::mean(window, |d| d) } else { soft };
    exponential::visibility_log(stored, z, c)
}

fn bounds(
    id: &str,
    estimate: Estimate,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, id, case);
        let window = input::window(&mut rng);
        for z in input::receiver_depths(&mut rng, &window) {
            let (v, exact) = (estimate(&window, z, faulty), input::exact(&window, z));
            tally.within(exact - v, 1e-6, || format!("{} depths, receiver {z}: {v}", window.len()));
        }
    }
    Ok(tally)
}

fn beyond_maximum(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "beyond", case);
        let window = input::window(&mut rng);
        let max = window.iter().copied().fold(0.0, f64::max);
        let (m, square) = (input::mean(&window, |d| d), input::mean(&window, |d| d * d));
        let z = max + rng.random_range(1e-6..0.5);
        let known = if faulty { f64::INFINITY } else { max };
        let v = chebyshev::visibility_max(m, square, known, z, 1e-5);
        tally.within(v, 0.0, || format!("{z} beyond {max}"));
    }
    Ok(tally)
}

fn one_depth(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "one", case);
        // A square that f64 represents, so that the variance is exactly 0.
        let d = f64::from(rng.random_range(0..=1024_u32)) / 1024.0;
        for z in [0.0, d - 1e-7, d, d + 1e-7, 1.0] {
            let v = if faulty {
                0.0 / (0.0 + (z - d) * (z - d))
            } else {
                chebyshev::visibility(d, d * d, z, 0.0)
            };
            let expected = if z > d { 0.0 } else { 1.0 };
            tally.within((v - expected).abs(), 0.0, || format!("depth {d}, receiver {z}: {v}"));
        }
    }
    Ok(tally)
}

fn affine(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let least = if faulty { 1e-2 } else { 0.0 };
    let of = |window: &[f64], z: f64| {
        let m = input::mean(window, |d| d);
        // The variance about the mean: an affine map must not lose digits of its own.
        let variance = input::mean(window, |d| (d - m) * (d - m));
        chebyshev::visibility(0.0, variance, z - m, least)
    };
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "affine", case);
        let window = input::window(&mut rng);
        let (scale, shift) =
            (10_f64.powf(rng.random_range(-3.0..6.0)), rng.random_range(-10.0..10.0));
        let moved: Vec<f64> = window.iter().map(|d| scale * d + shift).collect();
        for z in input::receiver_depths(&mut rng, &window) {
            let change = (of(&window, z) - of(&moved, scale * z + shift)).abs();
            tally.within(change, 1e-6, || format!("scale {scale}, shift {shift}, receiver {z}"));
        }
    }
    Ok(tally)
}

fn both_warps(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "warps", case);
        let window = input::window(&mut rng);
        let p = input::mean(&window, |d| evsm::warp_positive(d, C));
        let pp = input::mean(&window, |d| evsm::warp_positive(d, C).powi(2));
        for z in input::receiver_depths(&mut rng, &window) {
            let two = evsm::visibility2(p, pp, z, C, 0.0);
            let four = evsm_four(&window, z, false);
            let four = if faulty { two.max(evsm_negative(&window, z)) } else { four };
            tally.within(four - two, 1e-12, || format!("receiver {z}: {four} over {two}"));
        }
    }
    Ok(tally)
}

fn four_moments(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "moments", case);
        let window = input::window(&mut rng);
        for z in input::receiver_depths(&mut rng, &window) {
            let four = if faulty {
                let b = std::array::from_fn(|i| {
                    input::mean(&window, |d| moments::pack(if i == 1 { 0.5 * d } else { d })[i])
                });
                moments::visibility(b, z, 0.0, moments::bias_target(false))
            } else {
                msm(&window, z, false)
            };
            let two = vsm(&window, z, false);
            tally.within(four - two, 1e-6, || format!("receiver {z}: {four} over {two}"));
        }
    }
    Ok(tally)
}
