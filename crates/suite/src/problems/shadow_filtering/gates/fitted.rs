//! Estimators that fit a distribution: the Gaussian and the power function.

use super::{About, gate, input};
use crate::{
    SuiteError,
    verify::{Gate, GateContext, Tally},
};
use dapple_shadows::filtering::{
    DepthMap, KernelShape, Lookup, Receiver, Settings,
    estimators::{chebyshev, erf, gaussian, power},
    faults::{self, Fault},
    lookup::Footprint,
    reference,
};
use rand::RngExt;
use std::f64::consts::PI;

/// Specification 5.3: share p of the window occludes, receiver at the far depth; the Gaussian's
/// answer, and the power function's with the receiver moved by 0.05 of the range.
const PLANAR_EDGE: [(f64, f64, f64); 5] = [
    (0.10, 0.739, 0.604),
    (0.25, 0.564, 0.247),
    (0.50, 0.317, 0.100),
    (0.75, 0.083, 0.046),
    (0.90, 0.003, 0.025),
];

pub fn gates() -> Vec<Gate> {
    let about = |technique, name, statement, fault| About { technique, name, statement, fault };
    let shape =
        "visibility is 1 up to the mean, continuous there, and falls with the receiver's depth";
    vec![
        gate(
            about("gaussian-cdf", "P7.1 shape", shape, "the printed error function, without sign"),
            |c, f| falls("gaussian-cdf", c, |w, z| gaussian_at(w, z, f)),
        ),
        gate(
            about("power-cdf", "P7.1 shape", shape, "not normalised by the mean's share"),
            |c, f| falls("power-cdf", c, |w, z| power_at(w, z, f)),
        ),
        gate(
            about(
                "gaussian-cdf",
                "P7.3 below Chebyshev",
                "the Gaussian is at most Chebyshev's bound",
                "Chebyshev's depths are averaged before they are squared",
            ),
            below_chebyshev,
        ),
        gate(
            about(
                "gaussian-cdf",
                "row 50 error function",
                "the rational form is within 3.4e-4 of the error function and odd",
                "the printed form, without sign",
            ),
            error_function,
        ),
        gate(
            about(
                "gaussian-cdf",
                "5.3 planar edge",
                "the table of section 5.3 to 1e-3",
                "depths are averaged before they are squared",
            ),
            |_, f| Ok(planar_edge(|p| gaussian_edge(p, f), |row| row.1)),
        ),
        gate(
            about("power-cdf", "5.3 planar edge", "the table of section 5.3 to 1e-3", "no bias"),
            |_, f| Ok(planar_edge(|p| power_edge(p, f), |row| row.2)),
        ),
        gate(
            about(
                "power-cdf",
                "P7.4 fit",
                "the fitted distribution has the window's mean",
                "minimum and maximum exchanged in the exponent",
            ),
            reproduces_mean,
        ),
        gate(
            about(
                "power-cdf",
                "P7.9 conservative maximum",
                "0 at and beyond the largest depth of the four windows, above 0 before it",
                "minimum and maximum blended like means",
            ),
            conservative_maximum,
        ),
    ]
}

fn gaussian_at(window: &[f64], z: f64, faulty: bool) -> f64 {
    let (m, square) = (input::mean(window, |d| d), input::mean(window, |d| d * d));
    let f = if faulty { gaussian::visibility_printed } else { gaussian::visibility };
    f(m, square, z, 0.0)
}

fn ends(window: &[f64]) -> (f64, f64) {
    window.iter().fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), d| (a.min(*d), b.max(*d)))
}

fn power_at(window: &[f64], z: f64, faulty: bool) -> f64 {
    let (min, max) = ends(window);
    let m = input::mean(window, |d| d);
    let v = power::visibility(min, max, m, z, 0.0);
    if !faulty || z <= m || z >= max {
        return v;
    }
    let beta = power::exponent(min, max, m);
    1.0 - ((z - min) / (max - min)).powf(beta)
}

fn falls(
    id: &str,
    context: &GateContext<'_>,
    estimate: impl Fn(&[f64], f64) -> f64,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, id, case);
        let window = input::window(&mut rng);
        let m = input::mean(&window, |d| d);
        let (min, max) = ends(&window);
        let mut depths = input::receiver_depths(&mut rng, &window);
        depths.push(m);
        depths.sort_by(f64::total_cmp);
        let mut before = 1.0;
        for z in depths {
            let v = estimate(&window, z);
            tally.within(v - before, 1e-12, || format!("rises at receiver {z}"));
            tally.check(z > m || v == 1.0, || format!("{v} before the mean {m} at {z}"));
            before = v;
        }
        // A millionth of the range beyond the mean: no jump. The exponent may make it steep.
        let steep = 1.0 + (m - min) / (max - m);
        let step = 1e-6 * (max - min) / steep;
        let jump = 1.0 - estimate(&window, m + step);
        tally.within(jump, 1e-3, || format!("jumps at the mean {m} of {min}..{max}"));
    }
    Ok(tally)
}

fn below_chebyshev(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "below", case);
        let window = input::window(&mut rng);
        let (m, square) = (input::mean(&window, |d| d), input::mean(&window, |d| d * d));
        for z in input::receiver_depths(&mut rng, &window) {
            let other = if faulty { m * m } else { square };
            let bound = chebyshev::visibility(m, other, z, 0.0);
            let v = gaussian::visibility(m, square, z, 0.0);
            tally.within(v - bound, 1e-15, || format!("receiver {z}: {v} over {bound}"));
        }
    }
    Ok(tally)
}

/// By its power series: good to 1e-9 up to |x| = 4.
fn erf_series(x: f64) -> f64 {
    let (mut term, mut sum) = (x, x);
    for n in 1..200 {
        let n = f64::from(n);
        term *= -x * x / n;
        sum += term / (2.0 * n + 1.0);
    }
    2.0 / PI.sqrt() * sum
}

fn error_function(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases.max(100) {
        let mut rng = input::rng(context.seed, "erf", case);
        let x = rng.random_range(-4.0..4.0_f64);
        let found = if faulty { erf::erf_printed(x) } else { erf::erf(x) };
        tally.within((found - erf_series(x)).abs(), 3.4e-4, || format!("erf({x})"));
    }
    Ok(tally)
}

/// Depth 0 with share p, depth 1 with the rest.
fn gaussian_edge(p: f64, faulty: bool) -> f64 {
    let m = 1.0 - p;
    let square = if faulty { m * m } else { m };
    gaussian::visibility(m, square, 1.0, 0.0)
}

fn power_edge(p: f64, faulty: bool) -> f64 {
    let bias = if faulty { 0.0 } else { 0.05 };
    power::visibility(0.0, 1.0, 1.0 - p, 1.0 - bias, 0.0)
}

fn planar_edge(found: impl Fn(f64) -> f64, column: fn(&(f64, f64, f64)) -> f64) -> Tally {
    let mut tally = Tally::default();
    for row in &PLANAR_EDGE {
        let difference = (found(row.0) - column(row)).abs();
        tally.within(difference, 1e-3, || format!("share {} occluded", row.0));
    }
    tally
}

fn reproduces_mean(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "fit", case);
        let window = input::window(&mut rng);
        let (m, (min, max)) = (input::mean(&window, |d| d), ends(&window));
        let beta = if faulty { power::exponent(max, min, m) } else { power::exponent(min, max, m) };
        tally.check(beta > 0.0, || format!("exponent {beta}"));
        // E[t] = integral of 1 - F. Steps that shrink towards t = 0, where t^beta may be steep:
        // t = s^4, midpoints.
        const STEPS: u32 = 4000;
        let step = 1.0 / f64::from(STEPS);
        let integral: f64 = (0..STEPS)
            .map(|i| {
                let s = (f64::from(i) + 0.5) * step;
                (1.0 - s.powi(4).powf(beta)) * 4.0 * s.powi(3) * step
            })
            .sum();
        let fitted = min + (max - min) * integral;
        tally.within((fitted - m).abs(), 1e-4, || format!("{m} in {min}..{max}"));
    }
    Ok(tally)
}

fn conservative_maximum(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "conservative", case);
        let map = input::map(&mut rng);
        let s = Settings {
            lookup: Lookup::Bilinear,
            kernel: KernelShape::Box,
            plane_bias: false,
            bias: 0.0,
            ..input::plain("power-cdf", "plain", 2 * rng.random_range(0..3) + 1)?
        };
        let mut receivers = Vec::new();
        let mut expected = Vec::new();
        for _ in 0..40 {
            let (u, v) = (rng.random_range(0.0..1.0), rng.random_range(0.0..1.0));
            let (min, max) = extremes(&map, Receiver::new(u, v, 0.5), &s);
            // A hundredth of the range before the maximum, and beyond it.
            let range = max - min;
            if range > 0.01 {
                receivers.push(Receiver::new(u, v, max - 0.01 * range));
                expected.push(true);
            }
            receivers.push(Receiver::new(u, v, max + 1e-3));
            expected.push(false);
        }
        let found = if faulty {
            faults::visibility(&map, &receivers, &s, Fault::BilinearMinMax)?
        } else {
            reference::visibility(&map, &receivers, &s)?
        };
        for ((v, lit), receiver) in found.iter().zip(expected).zip(&receivers) {
            tally.check((*v > 0.0) == lit, || format!("{v} at {receiver:?}, lit {lit}"));
        }
    }
    Ok(tally)
}

/// Smallest and largest depth of the windows around the four texels of a lookup.
fn extremes(map: &DepthMap, receiver: Receiver, s: &Settings) -> (f32, f32) {
    let radius = i64::from(s.width_texels / 2);
    let footprint = Footprint::new(&receiver, s.lookup, map.width, map.height);
    let (mut min, mut max) = (f32::INFINITY, 0.0_f32);
    for ((x, y), _) in footprint.corners() {
        for dy in -radius..=radius {
            for dx in -radius..=radius {
                let i = (i64::from(x) + dx).clamp(0, i64::from(map.width) - 1);
                let j = (i64::from(y) + dy).clamp(0, i64::from(map.height) - 1);
                let z = map.depths[(j * i64::from(map.width) + i) as usize];
                (min, max) = (min.min(z), max.max(z));
            }
        }
    }
    (min, max)
}
