//! The ends of every range: nothing here may panic, leave 0..=1, or be anything but a number.

use crate::support::{self, Texel, at};
use dapple_opacity_maps::{Code, Fragment};

fn check(what: &str, fragments: &[Fragment]) {
    for settings in support::all() {
        let texel = Texel::new(&settings, fragments);
        for depth in support::probes(fragments) {
            let t = texel.t(depth);
            assert!((0.0..=1.0).contains(&t), "{what}: {:?} {t} at {depth}", settings.code);
        }
        if support::meets_both_ends(&settings.code) && !fragments.is_empty() {
            let (first, _) = support::ends(fragments);
            assert_eq!(texel.t(first), 1.0, "{what}: {:?}", settings.code);
        }
    }
}

#[test]
fn an_empty_texel_is_lit() {
    for settings in support::all() {
        let texel = Texel::new(&settings, &[]);
        for depth in [-1.0, 0.0, 0.5, 1.0, 3.0, f32::MAX] {
            assert_eq!(texel.t(depth), 1.0, "{:?} at {depth}", settings.code);
        }
    }
}

#[test]
fn extreme_thickness_and_depth_give_numbers() {
    check("clear", &[at(0.2, 0.0), at(0.7, 0.0)]);
    check("huge", &[at(0.2, f32::MAX), at(0.4, f32::MAX), at(0.7, 1e6)]);
    check("denormal", &[at(0.2, 1e-40), at(0.7, f32::from_bits(1))]);
    check("both planes", &[at(0.0, 0.5), at(1.0, 0.5)]);
    check("outside", &[at(-5.0, 0.5), at(7.0, 0.5)]);
    check("far outside", &[at(-1e30, 0.5), at(1e30, 0.5), at(0.5, 0.1)]);
    check("a tiny depth", &[at(f32::from_bits(1), 0.5), at(-0.0, 0.5), at(0.0, 0.25)]);
    check("nearly one", &[at(0.5, 0.5), at(0.500_000_06, 0.5), at(0.500_001, 0.5)]);
    check("two ends of the span", &[at(0.25, 0.5), at(0.250_001, 0.5), at(0.250_002, 9.0)]);
}

#[test]
fn clear_fragments_cast_no_shadow() {
    for settings in support::all().iter().filter(|s| s.code != Code::Binary) {
        let texel = Texel::new(settings, &[at(0.2, 0.0), at(0.7, 0.0)]);
        for depth in [0.1, 0.3, 0.9, 1.5] {
            assert_eq!(texel.t(depth), 1.0, "{:?}", settings.code);
        }
    }
}

#[test]
fn fifty_thousand_fragments_on_a_texel() {
    let n = 50_000;
    let spread: Vec<_> =
        (0..n).map(|i| at(((i * 7919) % n) as f32 / n as f32, 4.0 / n as f32)).collect();
    check("many", &spread);
    let one_depth = vec![at(0.5, 4.0 / n as f32); n];
    check("many at one depth", &one_depth);
    let truth = (-4.0f64).exp();
    let exact = [
        support::adaptive(8, dapple_opacity_maps::Order::Drawn),
        support::deep(0.01, 64),
        support::fourier(7, true, dapple_opacity_maps::Format::F32),
        support::moments(6, true, dapple_opacity_maps::Format::F32),
    ];
    for settings in exact {
        for fragments in [&spread, &one_depth] {
            let t = f64::from(Texel::new(&settings, fragments).t(1.1));
            assert!((t - truth).abs() < 0.011, "{:?} {t}", settings.code);
        }
    }
    // A half stops growing where a fragment is less than half its step: 4 is not reached, and the
    // texel stays too light.
    let half = support::fourier(7, true, dapple_opacity_maps::Format::F16);
    let t = Texel::new(&half, &one_depth).t(1.1);
    assert!(t > 0.5, "{t}");
}
