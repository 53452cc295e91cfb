//! Inputs at the edge of what is allowed, and beyond it.

mod support;

use dapple_shadows::filtering::{
    DepthMap, EsmSpace, Estimator, EvsmComponents, FilterError, Format, Receiver, Settings,
    VsmVariant, cpu, reference,
};
use support::{KERNELS, LOOKUPS, all_settings, map, noise};

fn extreme_maps() -> Vec<(&'static str, DepthMap)> {
    vec![
        ("empty", map(9, 5, |_, _| 1.0)),
        ("at the near plane", map(9, 5, |_, _| 0.0)),
        ("one depth", map(9, 5, |_, _| 0.5)),
        ("subnormal", map(9, 5, |x, _| if x < 4 { 1e-40 } else { 0.0 })),
        ("1e-7 apart", map(9, 5, |x, y| if (x + y) % 2 == 0 { 0.5 } else { 0.500_000_1 })),
        ("nearly all at the minimum", map(9, 5, |x, y| if x + y == 7 { 1.0 } else { 0.0 })),
        ("nearly all at the maximum", map(9, 5, |x, y| if x + y == 7 { 0.0 } else { 1.0 })),
        ("1e-3 of 1e6", map(9, 5, |x, _| 1e-9 * x as f32)),
        ("one texel", map(1, 1, |_, _| 0.3)),
        ("one row", map(17, 1, |x, _| x as f32 / 17.0)),
        ("thousands of depths", noise(70, 50, 30)),
    ]
}

fn extreme_receivers() -> Vec<Receiver> {
    let mut all = Vec::new();
    let z = [
        -f32::MAX,
        -1.0,
        -1e-30,
        0.0,
        1e-40,
        1e-9,
        1e-7,
        0.3,
        0.5,
        0.500_000_06,
        0.500_000_2,
        0.501,
        0.999,
        1.0,
        1.000_000_1,
        2.0,
        1e6,
        f32::MAX,
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
    ];
    let uv = [(0.0, 0.0), (1.0, 1.0), (0.5, 0.5), (0.111, 0.2), (f32::NAN, 0.5), (0.5, 1.01)];
    for z in z {
        for (u, v) in uv {
            for slope in [0.0, 1e9, f32::MAX, f32::NAN] {
                all.push(Receiver::new(u, v, z).with_slope(slope, -slope));
            }
        }
    }
    all
}

#[test]
fn every_visibility_is_a_finite_share() {
    let receivers = extreme_receivers();
    let mut checked = 0;
    for settings in all_settings() {
        for (name, map) in extreme_maps() {
            for kernel in KERNELS {
                for lookup in LOOKUPS {
                    for min_variance in [0.0, settings.min_variance] {
                        for plane_bias in [false, true] {
                            let s = Settings {
                                kernel,
                                lookup,
                                min_variance,
                                plane_bias,
                                moment_bias: if min_variance > 0.0 {
                                    settings.moment_bias
                                } else {
                                    0.0
                                },
                                ..settings
                            };
                            let mut filter = cpu::Filter::new(map.width, map.height, &s).unwrap();
                            filter.prefilter(&map).unwrap();
                            let mut out = vec![f32::NAN; receivers.len()];
                            filter.shade(&map, &receivers, &mut out).unwrap();
                            for (v, r) in out.iter().zip(&receivers) {
                                assert!((0.0..=1.0).contains(v), "{v} at {r:?}: {name}, {s:?}");
                                if !r.in_map() {
                                    assert_eq!(*v, 1.0);
                                }
                                checked += 1;
                            }
                        }
                    }
                }
            }
        }
        let s = Settings { width_texels: 5, ..settings };
        for (name, map) in extreme_maps() {
            let v = reference::visibility(&map, &receivers, &s).unwrap();
            assert!(v.iter().all(|v| (0.0..=1.0).contains(v)), "{name}: {s:?}");
        }
    }
    assert!(checked > 1_000_000, "{checked}");
}

#[test]
fn one_depth_is_a_step_for_the_statistical_estimators() {
    let flat = map(9, 9, |_, _| 0.5);
    let at = |z| Receiver::new(0.5, 0.5, z);
    let vsm = Estimator::Vsm { variant: VsmVariant::Plain };
    for estimator in [
        Estimator::Hard,
        Estimator::Pcf { taps: 0 },
        vsm,
        Estimator::GaussianCdf,
        Estimator::PowerCdf,
    ] {
        let s = Settings { bias: 0.0, min_variance: 0.0, ..Settings::new(estimator) };
        let v = reference::visibility(&flat, &[at(0.4), at(0.5), at(0.5001)], &s).unwrap();
        for (v, expected) in v.iter().zip([1.0, 1.0, 0.0]) {
            assert!((v - expected).abs() < 1e-12, "{estimator:?}: {v}");
        }
    }
}

/// A receiver near the far plane whose own plane runs past it within the window: what is stored
/// there is empty, and empty texels hide nothing. One occluder still does: the control.
#[test]
fn an_empty_texel_hides_nothing_from_a_plane_that_runs_past_it() {
    let steep = Receiver::new(0.5, 0.5, 0.98).with_slope(0.9, -0.4);
    for lookup in LOOKUPS {
        let closer = Settings::new(Estimator::Pcf { taps: 0 });
        let s = Settings { lookup, plane_bias: true, ..closer };
        for (name, map, lit) in [
            ("empty", map(16, 16, |_, _| 1.0), true),
            ("occluded", map(16, 16, |x, _| if x < 8 { 0.1 } else { 1.0 }), false),
        ] {
            let exact = reference::visibility(&map, &[steep], &s).unwrap()[0];
            let mut filter = cpu::Filter::new(map.width, map.height, &s).unwrap();
            filter.prefilter(&map).unwrap();
            let mut fast = [f32::NAN];
            filter.shade(&map, &[steep], &mut fast).unwrap();
            assert_eq!(exact > 1.0 - 1e-12, lit, "{name}: {exact}");
            assert!((f64::from(fast[0]) - exact).abs() < 1e-6, "{name}: {fast:?}, {exact}");
        }
    }
}

#[test]
fn the_widest_window_on_a_tiny_map_sees_the_whole_of_it() {
    // Repeated borders weigh most, but the minimum and maximum are those of the map.
    let tiny = map(3, 2, |x, y| 0.1 * (1 + x + 3 * y) as f32);
    let s = Settings { width_texels: 4095, bias: 0.0, ..Settings::new(Estimator::PowerCdf) };
    let mut filter = cpu::Filter::new(3, 2, &s).unwrap();
    filter.prefilter(&tiny).unwrap();
    let mut out = [f32::NAN; 3];
    let at = |z| Receiver::new(0.5, 0.5, z);
    filter.shade(&tiny, &[at(0.05), at(0.59), at(0.601)], &mut out).unwrap();
    assert_eq!(out[0], 1.0);
    assert!(out[1] > 0.0 && out[1] < 0.5, "{}", out[1]);
    assert_eq!(out[2], 0.0);
}

#[test]
fn bad_knobs_are_refused_by_name() {
    let good = Settings::new(Estimator::PowerCdf);
    for width_texels in [0, 2, 4096, 4097, u32::MAX] {
        let s = Settings { width_texels, ..good };
        assert_eq!(s.check(8, 8), Err(FilterError::Width { width: width_texels }));
    }
    assert!(Settings { width_texels: 4095, ..good }.check(8, 8).is_ok());
    assert!(matches!(good.check(0, 8), Err(FilterError::EmptyMap { .. })));
    for s in [
        Settings { bias: f32::NAN, ..good },
        Settings { min_variance: -1.0, ..good },
        Settings { bleed_reduction: 1.0, ..good },
        Settings { exponent: 0.0, ..good },
        Settings { moment_bias: f32::INFINITY, ..good },
    ] {
        assert!(matches!(s.check(8, 8), Err(FilterError::Knob { .. })), "{s:?}");
    }
    let splits = dapple_shadows::filtering::Splits::Uniform;
    for layers in [0, 3, 16] {
        let s = Settings { layers, ..Settings::new(Estimator::LayeredPower { splits }) };
        assert_eq!(s.check(8, 8), Err(FilterError::Layers { layers }));
    }
}

#[test]
fn exponents_that_overflow_the_format_are_refused() {
    let esm = |space| Settings::new(Estimator::Esm { space });
    let evsm = Settings::new(Estimator::Evsm { components: EvsmComponents::Four });
    for (settings, format, limit) in [
        (esm(EsmSpace::Linear), Format::F32, 88.0),
        (esm(EsmSpace::Linear), Format::F16, 11.0),
        (evsm, Format::F32, 44.0),
        (evsm, Format::F16, 5.54),
        (esm(EsmSpace::Log), Format::F16, 700.0),
    ] {
        let at = |exponent| Settings { exponent, ..settings.with_format(format) };
        assert!(at(limit).check(4, 4).is_ok());
        let refused = at(limit * 1.01).check(4, 4);
        assert!(matches!(refused, Err(FilterError::Overflow { .. })), "{refused:?}");
        // At the limit the farthest depth is stored, not infinite.
        let far = map(4, 4, |_, _| 1.0);
        let s = Settings { bias: 0.0, ..at(limit) };
        let v = reference::visibility(&far, &[Receiver::new(0.5, 0.5, 1.0)], &s).unwrap();
        assert!(v[0] > 0.99, "{s:?}: {}", v[0]);
    }
    let u16 = esm(EsmSpace::Linear).with_format(Format::U16).check(4, 4);
    assert_eq!(u16, Err(FilterError::Unstorable { format: Format::U16 }));
    assert!(evsm.with_format(Format::U16).check(4, 4).is_err());
}

#[test]
fn misuse_of_a_filter_is_an_error() {
    let s = Settings::new(Estimator::GaussianCdf);
    let mut filter = cpu::Filter::new(8, 4, &s).unwrap();
    let good = noise(8, 4, 1);
    let r = [Receiver::new(0.5, 0.5, 0.5)];
    assert_eq!(filter.shade(&good, &r, &mut [0.0]), Err(FilterError::NotFiltered));
    assert!(matches!(filter.prefilter(&noise(4, 8, 1)), Err(FilterError::MapSize { .. })));
    let mut bad = good.clone();
    bad.depths[3] = f32::NAN;
    assert!(matches!(filter.prefilter(&bad), Err(FilterError::Depth { texel: 3, .. })));
    assert!(matches!(reference::visibility(&bad, &r, &s), Err(FilterError::Depth { .. })));
    filter.prefilter(&good).unwrap();
    let short = filter.shade(&good, &r, &mut []);
    assert_eq!(short, Err(FilterError::OutputLength { receivers: 1, outputs: 0 }));
    assert!(filter.shade(&good, &r, &mut [0.0]).is_ok());
}

/// Depth noise of one step of the format, seen as a standard deviation (specification 5.3).
#[test]
fn variance_of_a_flat_window_is_rounding_noise() {
    // sigma^2 = M2 - M1^2 with both rounded: half a step of M2 plus 2 z times half a step of z.
    for (format, at_most) in [(Format::F16, 0.0271), (Format::F32, 3.1e-4)] {
        let mut worst = 0.0f64;
        for i in 0..2000 {
            let z = 0.88 + 0.04 * f64::from(i) / 2000.0;
            let (mean, square) = (format.round(z), format.round(z * z));
            worst = worst.max((square - mean * mean).abs().sqrt());
        }
        assert!(worst <= at_most && worst > 0.7 * at_most, "{format:?}: {worst}");
    }
}
