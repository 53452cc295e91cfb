//! Figures that follow from the formulas alone: two depths in the window, and the error function.

use dapple_shadows::filtering::estimators::{chebyshev, erf, exponential, gaussian, power};

/// Mean and mean square of a share `p` at depth 0 and the rest at 1.
fn edge(p: f64) -> (f64, f64) {
    (1.0 - p, 1.0 - p)
}

fn gaussian_edge(p: f64) -> f64 {
    let (mean, square) = edge(p);
    gaussian::visibility(mean, square, 1.0, 0.0)
}

fn power_edge(p: f64, epsilon: f64) -> f64 {
    power::visibility(0.0, 1.0, edge(p).0, 1.0 - epsilon, 0.0)
}

#[test]
fn planar_shadow_edge_table() {
    let table = [
        (0.10, 0.900, 0.739, 0.604),
        (0.25, 0.750, 0.564, 0.247),
        (0.50, 0.500, 0.317, 0.100),
        (0.75, 0.250, 0.083, 0.046),
        (0.90, 0.100, 0.003, 0.025),
    ];
    for (p, vsm, gauss, pow) in table {
        let (mean, square) = edge(p);
        let got =
            [chebyshev::visibility(mean, square, 1.0, 0.0), gaussian_edge(p), power_edge(p, 0.05)];
        for (got, expected) in got.into_iter().zip([vsm, gauss, pow]) {
            assert!((got - expected).abs() < 1e-3, "p = {p}: {got} is not {expected}");
        }
        assert_eq!(power_edge(p, 0.0), 0.0);
    }
}

#[test]
fn light_bleeding_of_three_planes() {
    // A at 0 and B at dx, half each; C at dx + dy sees neither light.
    for (dy, cheb, gauss, slack) in
        [(1.0, 0.100, 0.0027, 2e-4), (0.25, 0.308, 0.134, 1e-3), (0.1, 0.410, 0.230, 1e-3)]
    {
        for scale in [1e-3, 1.0, 1e6] {
            let (mean, square) = (0.5 * scale, 0.5 * scale * scale);
            let z = (1.0 + dy) * scale;
            let chebyshev: f64 = chebyshev::visibility(mean, square, z, 0.0);
            let gaussian: f64 = gaussian::visibility(mean, square, z, 0.0);
            assert!((chebyshev - cheb).abs() < 1e-3, "{chebyshev}");
            assert!((gaussian - gauss).abs() < slack, "{gaussian}");
            assert_eq!(power::visibility(0.0, scale, mean, z, 0.0), 0.0);
        }
    }
}

/// Share of occluders at which a decreasing visibility crosses 1/2.
fn crossing(visibility: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (1e-9, 1.0 - 1e-9);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if visibility(middle) > 0.5 { low = middle } else { high = middle }
    }
    low
}

#[test]
fn half_lit_edge_moves_outward() {
    assert!((crossing(|p| chebyshev::visibility(1.0 - p, 1.0 - p, 1.0, 0.0)) - 0.5).abs() < 1e-6);
    assert!((crossing(gaussian_edge) - 0.313).abs() < 1e-3);
    for (epsilon, p) in [(0.01, 0.026), (0.05, 0.124), (0.1, 0.235), (0.2, 0.421)] {
        let at = crossing(|p| power_edge(p, epsilon));
        assert!((at - p).abs() < 1e-3, "epsilon {epsilon}: {at}");
    }
}

#[test]
fn exponential_tends_to_the_exact_share() {
    for p in [0.1, 0.5, 0.9] {
        let mut before = f64::INFINITY;
        for c in [5.0, 20.0, 80.0, 320.0] {
            let window = [(p, 0.3), (1.0 - p, 0.6)];
            let log = exponential::log_mean(window.into_iter(), c);
            let v = exponential::visibility_log(log, 0.6, c);
            assert!(v >= 1.0 - p - 1e-12 && v <= before);
            before = v;
        }
        assert!((before - (1.0 - p)).abs() < 1e-6);
    }
}

/// Maclaurin series up to 3, continued fraction of the complement (Lentz) beyond.
fn exact_erf(x: f64) -> f64 {
    let root_pi = std::f64::consts::PI.sqrt();
    if x < 0.0 {
        return -exact_erf(-x);
    }
    if x < 3.0 {
        let (mut term, mut sum) = (x, x);
        for n in 1..200 {
            term *= -x * x / f64::from(n);
            sum += term / f64::from(2 * n + 1);
        }
        return 2.0 / root_pi * sum;
    }
    // x + (1/2) / (x + (2/2) / (x + (3/2) / (x + ...)))
    let tail = (1..=100).rev().fold(x, |tail, k| x + 0.5 * f64::from(k) / tail);
    1.0 - (-x * x).exp() / (root_pi * tail)
}

#[test]
fn exact_erf_agrees_with_tabulated_values() {
    // Abramowitz and Stegun, table 7.1.
    for (x, value) in [(0.5, 0.520_499_877_8), (1.0, 0.842_700_792_9), (2.0, 0.995_322_265_0)] {
        assert!((exact_erf(x) - value).abs() < 1e-10);
    }
    assert!((exact_erf(3.0 - 1e-12) - exact_erf(3.0)).abs() < 1e-10);
}

fn largest_error(approximation: impl Fn(f64) -> f64) -> f64 {
    let grid = (-60_000..=60_000).map(|i| f64::from(i) * 1e-4);
    grid.map(|x| (approximation(x) - exact_erf(x)).abs()).fold(0.0, f64::max)
}

#[test]
fn rational_erf_keeps_its_error_bound() {
    let error = largest_error(erf::erf);
    assert!((3.0e-4..=3.4e-4).contains(&error), "{error}");
    let error = largest_error(|x| erf::erf_with(x, erf::A_MINIMAX));
    assert!((1.0e-4..=1.25e-4).contains(&error), "{error}");
    let error = largest_error(|x| f64::from(erf::erf(x as f32)));
    assert!(error <= 3.4e-4, "{error}");
}

#[test]
fn rational_erf_is_odd_and_monotone() {
    let mut before = -1.0;
    for i in -40_000..=40_000 {
        let x = f64::from(i) * 1e-4;
        let y = erf::erf(x);
        assert_eq!(y, -erf::erf(-x));
        assert!(y >= before - 1e-15, "{x}");
        before = y;
    }
}

#[test]
fn printed_erf_is_neither_odd_nor_close() {
    assert_eq!(erf::erf_printed(-1.0), erf::erf_printed(1.0));
    assert!(largest_error(erf::erf_printed) > 1.0);
}
