//! Through the renderer: taps, averaged coefficients, memory.

use crate::support;
use dapple_opacity_maps::{
    Blur, Code, Format, Fragments, NO_OPAQUE, Opaque, Receiver, Settings, Taps, cpu::Maps, fourier,
    moments, reference::Reference,
};

/// A map of hair of 8 x 8 texels.
fn hair() -> Fragments {
    let mut out = Fragments { width: 8, height: 8, starts: vec![0], ..Fragments::default() };
    for texel in 0..64 {
        out.items.extend(support::hair(texel, 3 + texel as usize % 9));
        out.starts.push(out.items.len() as u32);
        out.opaque.push(if texel % 5 == 0 { 0.8 } else { NO_OPAQUE });
    }
    out
}

fn receivers() -> Vec<Receiver> {
    let place = |i: usize, step: f32| (i as f32 * step).fract();
    (0..300).map(|i| Receiver::at(place(i, 0.377), place(i, 0.619), place(i, 0.713))).collect()
}

#[test]
fn an_occluder_gives_nought_or_one_and_filtered_edges_go_by_taps() {
    // The left half of the map is covered at depth 0.3, translucently.
    let mut plane = Fragments { width: 8, height: 8, starts: vec![0], ..Fragments::default() };
    for texel in 0..64 {
        if texel % 8 < 4 {
            plane.items.push(support::at(0.3, 0.1));
        }
        plane.starts.push(plane.items.len() as u32);
        plane.opaque.push(NO_OPAQUE);
    }
    for (taps, n) in [(Taps::One, 1), (Taps::Box3, 9), (Taps::Box4, 16)] {
        let settings = Settings { taps, ..Settings::plain(Code::Binary) };
        let mut maps = Maps::new(8, 8, &settings).unwrap();
        maps.build(&plane).unwrap();
        let mut seen = Vec::new();
        for i in 0..=64 {
            let u = i as f32 / 64.0;
            assert_eq!(maps.transmittance(&Receiver::at(u, 0.5, 0.2)), 1.0);
            let t = maps.transmittance(&Receiver::at(u, 0.5, 0.6));
            let steps = t * n as f32;
            assert!((steps - steps.round()).abs() < 1e-5, "{taps:?} {t}");
            if taps == Taps::One {
                assert_eq!(t, if u < 0.5 { 0.0 } else { 1.0 });
            }
            seen.push(steps.round() as i32);
        }
        seen.dedup();
        assert_eq!((seen[0], *seen.last().unwrap()), (0, n), "{taps:?}");
        assert!(taps == Taps::One || seen.len() > 3, "an edge of {seen:?}");
    }
}

#[test]
fn every_code_follows_its_reference_through_every_filter() {
    let (fragments, receivers) = (hair(), receivers());
    let mut checked = 0;
    for base in support::all() {
        for (taps, blur) in [
            (Taps::One, Blur::Transmittance),
            (Taps::Box3, Blur::Transmittance),
            (Taps::Box3, Blur::Stored),
            (Taps::Stochastic16, Blur::Stored),
        ] {
            for opaque in [Opaque::Separate, Opaque::Weight { weight: 3.0, in_bounds: true }] {
                let settings = Settings { taps, blur, opaque, ..base.clone() };
                let mut maps = Maps::new(8, 8, &settings).unwrap();
                maps.build(&fragments).unwrap();
                let reference = Reference::new(&settings, &fragments).unwrap();
                let bound = match &settings.code {
                    Code::Fourier(_) => (0..64)
                        .map(|t| fourier::port_bound(fragments.texel(t), None))
                        .fold(0.0, f64::max),
                    Code::Moments(m) => (0..64)
                        .map(|t| moments::port_bound(m, fragments.texel(t), None))
                        .fold(0.0, f64::max),
                    _ => 1e-6,
                };
                for receiver in receivers.iter().step_by(7) {
                    let t = f64::from(maps.transmittance(receiver));
                    let expected = reference.transmittance(receiver);
                    let error = (t - expected).abs();
                    // An opaque fragment of weight 3 adds as much to Ω as the hair.
                    assert!(error <= 2.0 * bound, "{settings:?} {t} {expected} {bound}");
                    checked += 1;
                }
            }
        }
    }
    assert!(checked > 5000, "{checked}");
}

#[test]
fn averaged_coefficients_are_not_averaged_transmittances() {
    let (fragments, receivers) = (hair(), receivers());
    for code in [support::fourier(7, false, Format::F32), support::moments(4, false, Format::F32)] {
        let shaded = |blur| {
            let settings = Settings { taps: Taps::Box3, blur, ..code.clone() };
            let mut maps = Maps::new(8, 8, &settings).unwrap();
            maps.build(&fragments).unwrap();
            let mut out = vec![0.0; receivers.len()];
            maps.shade(&receivers, &mut out).unwrap();
            out
        };
        let (stored, transmitted) = (shaded(Blur::Stored), shaded(Blur::Transmittance));
        let apart = stored.iter().zip(&transmitted).filter(|(a, b)| (*a - *b).abs() > 0.005);
        assert!(apart.count() > 20);
    }
}

#[test]
fn a_deep_map_counts_what_it_uses() {
    let fragments = hair();
    let settings = support::deep(0.0, 64);
    let mut maps = Maps::new(8, 8, &settings).unwrap();
    maps.build(&fragments).unwrap();
    assert_eq!(maps.map_bytes(), 64 * (4 + 8 * 64 + 4));
    // Every fragment has its own depth here, and so two nodes.
    assert_eq!(maps.used_bytes(), 64 * 8 + 16 * fragments.items.len() as u64);
    let binary = Maps::new(8, 8, &Settings::plain(Code::Binary)).unwrap();
    assert_eq!(binary.used_bytes(), binary.map_bytes());
}
