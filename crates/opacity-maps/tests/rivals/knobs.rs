//! Errors shrink as a knob is turned up, on rays through hair.

use crate::support::{self, Texel};
use dapple_opacity_maps::{Format, Fragment, Order, Settings, code, reference};

fn rays() -> Vec<Vec<Fragment>> {
    (0..60).map(|seed| support::hair(seed, 5 + seed as usize % 50)).collect()
}

/// Root mean square of T - truth just behind every fragment and over the range.
fn rmse(settings: &Settings, rays: &[Vec<Fragment>]) -> f64 {
    let (mut sum, mut n) = (0.0, 0.0);
    for (i, ray) in rays.iter().enumerate() {
        let texel = Texel::with_code(code::of(settings), i, ray, None);
        let depths = ray.iter().map(|f| f.depth.next_up());
        for depth in depths.chain((0..=40).map(|i| i as f32 / 40.0)) {
            sum += (f64::from(texel.t(depth)) - reference::exact(ray, depth)).powi(2);
            n += 1.0;
        }
    }
    f64::sqrt(sum / n)
}

fn falls(what: &str, settings: &[Settings], factor: f64) {
    let rays = rays();
    let errors: Vec<f64> = settings.iter().map(|s| rmse(s, &rays)).collect();
    for pair in errors.windows(2) {
        assert!(pair[1] < factor * pair[0], "{what}: {errors:?}");
    }
}

#[test]
fn errors_shrink_with_pairs_nodes_moments_samples_and_tolerance() {
    for bounded in [false, true] {
        for format in [Format::F32, Format::F16] {
            let name = format!("fourier bounded {bounded} {format:?}");
            falls(&name, &[1, 3, 7, 15].map(|n| support::fourier(n, bounded, format)), 0.9);
            let name = format!("moments bounded {bounded} {format:?}");
            falls(&name, &[4, 6].map(|n| support::moments(n, bounded, format)), 1.0);
        }
    }
    for order in [Order::Drawn, Order::Sorted] {
        let name = format!("adaptive {order:?}");
        falls(&name, &[4, 8, 16, 32, 64].map(|n| support::adaptive(n, order)), 0.7);
    }
    falls("stochastic", &[1, 4, 16, 64].map(|n| support::stochastic(n, 5)), 0.65);
    falls("deep", &[0.1, 0.03, 0.01, 0.0].map(|t| support::deep(t, 256)), 0.6);
    falls("deep nodes", &[2, 4, 8, 16, 128].map(|n| support::deep(0.0, n)), 0.7);
}

#[test]
fn bounds_of_a_ray_pay_where_it_is_short() {
    // Two tufts fill half the light's range; bounds give the same coefficients more to do.
    let rays = rays();
    for (whole, bounded) in [
        (support::fourier(3, false, Format::F32), support::fourier(3, true, Format::F32)),
        (support::moments(4, false, Format::F32), support::moments(4, true, Format::F32)),
    ] {
        assert!(rmse(&bounded, &rays) < rmse(&whole, &rays), "{:?}", whole.code);
    }
}
