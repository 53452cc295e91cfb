//! The processor's form follows the reference as closely as each code states.

use crate::support::{self, Texel};
use dapple_opacity_maps::{
    Code, Fragments, NO_OPAQUE, Settings, fourier, moments, reference::Reference,
};
use proptest::prelude::*;

/// One texel of fragments.
fn grid(fragments: &[dapple_opacity_maps::Fragment]) -> Fragments {
    Fragments {
        width: 1,
        height: 1,
        starts: vec![0, fragments.len() as u32],
        items: fragments.to_vec(),
        opaque: vec![NO_OPAQUE],
    }
}

/// The stated bound.
fn bound(settings: &Settings, fragments: &[dapple_opacity_maps::Fragment]) -> f64 {
    match &settings.code {
        Code::Fourier(_) => fourier::port_bound(fragments, None),
        Code::Moments(m) => moments::port_bound(m, fragments, None),
        Code::Binary | Code::Stochastic(_) => 0.0,
        _ => 2e-7,
    }
}

fn worst(settings: &Settings, fragments: &[dapple_opacity_maps::Fragment]) -> f64 {
    let grid = grid(fragments);
    let reference = Reference::new(settings, &grid).unwrap();
    let texel = Texel::new(settings, fragments);
    let mut probes = support::probes(fragments);
    probes.dedup();
    let error = |d: f32| (f64::from(texel.t(d)) - reference.at(0, d)).abs();
    // The references are slow: every third probe.
    probes.into_iter().step_by(3).map(error).fold(0.0, f64::max)
}

proptest! {
    #![proptest_config(support::cases(12))]

    #[test]
    fn the_processor_follows_the_reference(fragments in support::rays()) {
        for settings in support::all() {
            let (error, bound) = (worst(&settings, &fragments), bound(&settings, &fragments));
            prop_assert!(error <= bound, "{:?}: {} > {}", settings.code, error, bound);
        }
    }
}

#[test]
fn faulty_ports_are_caught() {
    let fragments = support::hair(4, 30);
    let twisted = |settings: &Settings, twist: &dyn Fn(&mut Vec<f32>)| {
        let grid = grid(&fragments);
        let reference = Reference::new(settings, &grid).unwrap();
        let mut texel = Texel::new(settings, &fragments);
        twist(&mut texel.words);
        let error = |d: f32| (f64::from(texel.t(d)) - reference.at(0, d)).abs();
        (0..50).map(|i| error(i as f32 / 50.0)).fold(0.0, f64::max)
    };
    let f32 = dapple_opacity_maps::Format::F32;
    let fourier = support::fourier(7, false, f32);
    assert!(twisted(&fourier, &|_| {}) <= bound(&fourier, &fragments));
    let wrong_sign = |words: &mut Vec<f32>| words[2] = -words[2];
    assert!(twisted(&fourier, &wrong_sign) > 10.0 * bound(&fourier, &fragments));
    for count in [4, 6] {
        let moments = support::moments(count, false, f32);
        assert!(twisted(&moments, &|_| {}) <= bound(&moments, &fragments));
        let swapped = |words: &mut Vec<f32>| words.swap(1, 2);
        assert!(twisted(&moments, &swapped) > 2.0 * bound(&moments, &fragments));
        // The bias the wrong way round: nearly all of the safe distribution.
        let Code::Moments(knobs) = moments.code else { unreachable!() };
        let bias = 1.0 - dapple_opacity_maps::moments::bias(&knobs) as f32;
        let code = moments::Code {
            settings: dapple_opacity_maps::Moments { bias, ..knobs },
            opaque_in_bounds: false,
        };
        let wrong = Texel::with_code(Box::new(code), 0, &fragments, None);
        let error = |d| {
            let right = moments::reference(&knobs, &fragments, None, false, d);
            (f64::from(wrong.t(d)) - right).abs()
        };
        let error = (0..50).map(|i| error(i as f32 / 50.0)).fold(0.0, f64::max);
        assert!(error > 2.0 * bound(&moments, &fragments), "{error}");
    }
    let stochastic = support::stochastic(16, 7);
    let lost = |words: &mut Vec<f32>| words[3] = NO_OPAQUE;
    assert!(twisted(&stochastic, &lost) > 0.0);
}
