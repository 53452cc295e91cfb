//! Range, both ends, and order.

use crate::support::{self, Late, Texel, at};
use dapple_opacity_maps::{Code, Format, Fragment, Order, Settings, code, reference};
use proptest::prelude::*;

/// What is wrong with a texel's ends and range, if anything.
fn fault(settings: &Settings, texel: &Texel, fragments: &[Fragment]) -> Option<String> {
    for depth in support::probes(fragments) {
        let t = texel.t(depth);
        if !(0.0..=1.0).contains(&t) {
            return Some(format!("T = {t} at {depth}"));
        }
    }
    let both = support::meets_both_ends(&settings.code);
    let (first, last) = if both { support::ends(fragments) } else { (0.0, 1.0) };
    let front = texel.t(first);
    if front != 1.0 {
        return Some(format!("T = {front} in front of everything"));
    }
    let exact = match settings.code {
        Code::Binary => 0.0,
        _ => (-support::total(fragments)).exp(),
    };
    let behind = f64::from(texel.t(last + 1e-5));
    let bound = support::end_bound(settings, exact, fragments);
    ((behind - exact).abs() > bound)
        .then(|| format!("T = {behind} behind everything, expected {exact} +- {bound}"))
}

proptest! {
    #![proptest_config(support::cases(48))]

    #[test]
    fn transmittance_stays_in_range_and_meets_its_ends(fragments in support::rays()) {
        for settings in support::all() {
            let texel = Texel::new(&settings, &fragments);
            prop_assert_eq!(fault(&settings, &texel, &fragments), None, "{:?}", settings.code);
        }
    }

    #[test]
    fn transmittance_never_rises(fragments in support::rays()) {
        let mut checked = 0;
        for settings in support::all() {
            // Bounds of moments are monotone in exact arithmetic; rounding is magnified by the bias.
            let slack = match &settings.code {
                Code::Fourier(_) => continue,
                Code::Moments(m) => {
                    dapple_opacity_maps::moments::port_bound(m, &fragments, None) as f32
                }
                _ => 0.0,
            };
            checked += 1;
            let texel = Texel::new(&settings, &fragments);
            let mut lowest = 1.0f32;
            for depth in support::probes(&fragments) {
                let t = texel.t(depth);
                prop_assert!(t <= lowest + slack, "{:?}: {} at {}", settings.code, t, depth);
                lowest = lowest.min(t);
            }
        }
        prop_assert!(checked >= 15);
    }

    #[test]
    fn an_adaptive_map_is_never_darker_than_the_truth(fragments in support::rays()) {
        for nodes in [2, 5, 16] {
            let texel = Texel::new(&support::adaptive(nodes, Order::Drawn), &fragments);
            for depth in support::probes(&fragments) {
                let truth = reference::exact(&fragments, depth) as f32;
                prop_assert!(texel.t(depth) >= truth - 1e-6);
            }
        }
    }

    #[test]
    fn a_deep_map_stays_within_its_tolerance(fragments in support::rays()) {
        for tolerance in [0.0, 0.002, 0.01, 0.1, 0.5] {
            let texel = Texel::new(&support::deep(tolerance, 1024), &fragments);
            for depth in support::probes(&fragments) {
                let error = f64::from(texel.t(depth)) - reference::exact(&fragments, depth);
                prop_assert!(error.abs() <= f64::from(tolerance) + 2e-7, "{} {}", tolerance, error);
            }
        }
    }

    #[test]
    fn order_of_drawing_changes_only_what_it_may(fragments in support::rays()) {
        let mut turned = fragments.clone();
        turned.reverse();
        for settings in support::all() {
            let texels = [&fragments, &turned].map(|f| Texel::new(&settings, f));
            let exactly = match &settings.code {
                Code::Binary | Code::Stochastic(_) | Code::Deep(_) => true,
                Code::Adaptive(a) => a.order == Order::Sorted,
                _ => false,
            };
            if exactly {
                prop_assert_eq!(texels[0].used(), texels[1].used(), "{:?}", settings.code);
            }
        }
    }
}

#[test]
fn a_code_that_is_read_too_deep_is_caught() {
    let fragments = [at(0.2, 0.3), at(0.22, 0.4), at(0.6, 0.5)];
    let mut checked = 0;
    for settings in support::all().into_iter().filter(|s| support::meets_both_ends(&s.code)) {
        let good = Texel::new(&settings, &fragments);
        assert_eq!(fault(&settings, &good, &fragments), None, "{:?}", settings.code);
        let late = Box::new(Late(code::of(&settings)));
        let late = Texel::with_code(late, 0, &fragments, None);
        // A sample may by chance have let the first fragments through.
        if !matches!(&settings.code, Code::Stochastic(s) if s.samples < 16) {
            assert!(fault(&settings, &late, &fragments).is_some(), "{:?}", settings.code);
            checked += 1;
        }
    }
    assert!(checked >= 15, "{checked}");
}

#[test]
fn a_fourier_series_rings() {
    // The one code that promises no order: it has to show.
    let texel = Texel::new(&support::fourier(7, false, Format::F32), &[at(0.5, 2.0)]);
    let rises =
        (1..200).any(|i| texel.t(i as f32 / 200.0) > texel.t((i - 1) as f32 / 200.0) + 1e-3);
    assert!(rises);
}
