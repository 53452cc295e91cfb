//! Layered maps where little is left to go right: nothing, one thing, too much, no room.

use crate::support::*;
use dapple_opacity_maps::{
    Blend, Blur, Format, Fragments, Lookup, NO_OPAQUE, Opaque, Packing, Receiver, Settings, Taps,
    cpu::Maps,
    layered::{
        LayeredCode, bytes_per_texel,
        counters::{self, Counters},
        geometry_passes,
    },
};

const LAYERS: [u32; 8] = [1, 2, 3, 4, 5, 32, 33, 256];
const LOOKUPS: [Lookup; 3] = [Lookup::Lerp, Lookup::Nearest, Lookup::Exclusive];

fn one_texel(texel: Vec<(f32, f32)>) -> Fragments {
    map(1, &[texel])
}

fn at(maps: &Maps, depth: f32) -> f32 {
    maps.transmittance(&Receiver::at(0.5, 0.5, depth))
}

#[test]
fn nothing_shades_nothing() {
    let mut opaque_alone = one_texel(vec![]);
    opaque_alone.opaque[0] = 0.5;
    for layout in layouts() {
        for layers in LAYERS {
            let settings = settings(layered(layout.clone(), layers));
            let maps = build(&settings, &one_texel(vec![]));
            for depth in [-1.0, 0.0, 0.5, 1.0, 2.0, f32::MAX, f32::MIN] {
                assert_eq!(at(&maps, depth), 1.0, "{layout:?} {depth}");
            }
            // An opaque caster with a map of its own is no fragment.
            let maps = build(&settings, &opaque_alone);
            assert_eq!((at(&maps, 0.5), at(&maps, 0.6)), (1.0, 0.0));
        }
    }
}

#[test]
fn one_fragment_shades_what_lies_behind_it() {
    for layout in layouts() {
        for layers in LAYERS {
            for lookup in LOOKUPS {
                let mut one = layered(layout.clone(), layers);
                one.lookup = lookup;
                let deep = matches!(layout, dapple_opacity_maps::Layout::Deep { .. });
                let maps = build(&settings(one), &one_texel(vec![(0.5, 0.7)]));
                assert_eq!(at(&maps, 0.499), 1.0);
                if !(deep && lookup == Lookup::Exclusive && layers == 1) {
                    assert!(
                        (at(&maps, 1.6) - (-0.7f32).exp()).abs() < 1e-6,
                        "{layout:?} {lookup:?}"
                    );
                }
                // At the fragment itself: lit, but where a lookup counts its own layer.
                let expected = if lookup == Lookup::Nearest { (-0.7f32).exp() } else { 1.0 };
                assert_eq!(at(&maps, 0.5), expected, "{layout:?} {layers} {lookup:?}");
            }
        }
    }
}

#[test]
fn many_fragments_at_one_depth_are_one() {
    let fragments = one_texel(vec![(0.25, 0.01); 1000]);
    for layout in layouts() {
        let maps = build(&settings(layered(layout.clone(), 16)), &fragments);
        assert_eq!(at(&maps, 0.25), 1.0, "{layout:?}");
        assert!((at(&maps, 1.3) - (-10.0f32).exp()).abs() < 1e-6, "{layout:?}");
    }
}

#[test]
fn fragments_on_boundaries_belong_to_the_layer_behind() {
    // Dyadic boundaries are exact: k / 4.
    let texel: Vec<(f32, f32)> = (0..=4).map(|k| (k as f32 / 4.0, 1.0)).collect();
    for layout in [even(), deep(1.0), bounded(0.0)] {
        let one = layered(layout.clone(), 4);
        let maps = build(&settings(one.clone()), &one_texel(texel.clone()));
        // The last lies on the end, which belongs to the last layer.
        assert_eq!(sums(&maps, &one, 0), [1.0, 2.0, 3.0, 5.0], "{layout:?}");
        for k in 0..4 {
            let expected = (-(k as f32)).exp();
            assert!((at(&maps, k as f32 / 4.0) - expected).abs() < 1e-6, "{layout:?} {k}");
        }
    }
}

#[test]
fn receivers_off_the_map_and_not_finite_are_lit() {
    let maps = build(&settings(layered(bounded(0.0), 4)), &one_texel(vec![(0.1, 9.0), (0.2, 9.0)]));
    for (u, v, depth) in [
        (-0.1, 0.5, 0.9),
        (0.5, 1.1, 0.9),
        (f32::NAN, 0.5, 0.9),
        (0.5, 0.5, f32::NAN),
        (0.5, 0.5, f32::INFINITY),
    ] {
        assert_eq!(maps.transmittance(&Receiver::at(u, v, depth)), 1.0, "{u} {v} {depth}");
    }
    assert!(at(&maps, 0.9) < 1e-6, "the control is not");
    let invalid = Receiver { flags: 0, ..Receiver::at(0.5, 0.5, 0.9) };
    assert_eq!(maps.transmittance(&invalid), 1.0);
}

#[test]
fn formats_saturate_stall_and_overflow_as_they_must() {
    let end = |format, omega: f32, count: usize| {
        let texel = (0..count).map(|i| (0.2 + 0.5 * i as f32 / count as f32, omega)).collect();
        let mut one = layered(bounded(0.0), 4);
        (one.format, one.packing) = (format, Packing::Targets(1));
        let maps = build(&settings(one.clone()), &one_texel(texel));
        (at(&maps, 0.9), sums(&maps, &one, 0)[3])
    };
    // Slabs clip each of their textures: eight layers in two reach twice the thickness of one.
    let slabs = |layers| {
        let texel = (0..100).map(|i| (0.2 + 0.005 * i as f32, 0.5)).collect();
        let mut one = layered(bounded(0.0), layers);
        (one.format, one.packing) = (Format::Unorm8, Packing::Slabs);
        at(&build(&settings(one), &one_texel(texel)), 0.9)
    };
    let e = std::f32::consts::E;
    assert!((slabs(4) - 1.0 / e).abs() < 1e-6 && (slabs(8) - 1.0 / (e * e)).abs() < 1e-6);
    assert!((end(Format::Unorm8, 0.69, 50).0 - 1.0 / e).abs() < 1e-6, "the floor of bytes");
    assert!((end(Format::Unorm8Scaled, 0.69, 50).0 - 1.0 / 256.0).abs() < 1e-6);
    assert_eq!(end(Format::F16, 0.001, 50_000).1, 4.0, "halves stall");
    assert_eq!(end(Format::F16, 0.69, 50_000).1, 2048.0, "halves count too much, then stall");
    assert!((end(Format::F32, 0.69, 50_000).1 - 34_500.0).abs() < 10.0);
    assert_eq!(end(Format::Fixed, 1.0, 50_000).1, 4096.0, "fixed point clips");
    assert!((end(Format::Fixed, 0.01, 50_000).1 - 500.0).abs() < 0.05);
}

#[test]
fn fifty_thousand_fragments_on_a_texel_keep_their_order() {
    let mut rng = generator(3);
    let texel: Vec<(f32, f32)> =
        (0..50_000).map(|_| (unit(&mut rng), 2e-4 * unit(&mut rng))).collect();
    let fragments = one_texel(texel);
    for layout in [even(), deep(1.0), bounded(0.0), bounded(0.8)] {
        for packing in [Packing::Sorted, Packing::Targets(8)] {
            let mut one = layered(layout.clone(), 32);
            one.packing = packing;
            let maps = build(&settings(one), &fragments);
            for i in 0..=50 {
                let depth = i as f32 / 50.0;
                let exact = (-prefix(&fragments, 0, depth).0).exp();
                let off = (f64::from(at(&maps, depth)) - exact).abs();
                assert!(off < 0.02, "{layout:?} {packing:?} {depth}: {off}");
            }
        }
    }
}

#[test]
fn opacities_from_0_to_huge_and_depths_anywhere_stay_in_range() {
    let omegas = [0.0, f32::MIN_POSITIVE / 2.0, 1.0 / 255.0, 1.0, 1e6, 1e30, f32::MAX];
    let depths = [-1e6, -0.0, 0.0, 1e-30, 1e-3, 1.0, 1e6];
    let texel: Vec<(f32, f32)> =
        depths.iter().flat_map(|&d| omegas.iter().map(move |&w| (d, w))).collect();
    let fragments = one_texel(texel);
    let formats = [Format::F32, Format::F16, Format::Unorm8, Format::Unorm8Scaled, Format::Fixed];
    let mut checked = 0;
    for layout in layouts() {
        for format in formats {
            for blend in [Blend::Add, Blend::Over] {
                for packing in [Packing::Sorted, Packing::Slabs, Packing::Targets(8)] {
                    let mut one = layered(layout.clone(), 5);
                    (one.format, one.blend, one.packing) = (format, blend, packing);
                    let settings = settings(one);
                    if settings.check().is_err() {
                        continue;
                    }
                    let maps = build(&settings, &fragments);
                    for depth in depths.into_iter().chain([0.5, f32::MAX, f32::MIN]) {
                        let t = at(&maps, depth);
                        assert!((0.0..=1.0).contains(&t), "{settings:?} {depth}: {t}");
                        checked += 1;
                    }
                }
            }
        }
    }
    assert!(checked > 1000);
}

#[test]
fn bounds_are_never_nan_and_empty_texels_are_no_casters_in_soft_starts() {
    let fragments = random(21, 5, 5, 10);
    let maps = build(&settings(layered(bounded(0.5), 8)), &fragments);
    for texel in 0..25 {
        let words = maps.texel(texel);
        assert!(words.iter().all(|w| w.is_finite()));
        assert_eq!(words[0] > words[1], fragments.texel(texel).is_empty());
    }
    // A caster among eight empty texels: the share of taps behind a first fragment is 1 / 9.
    let mut texels = vec![vec![]; 9];
    texels[4] = vec![(0.3, 2.0), (0.4, 2.0)];
    let soft = |soft_start| {
        let mut one = layered(bounded(0.0), 4);
        one.soft_start = soft_start;
        let settings = Settings { taps: Taps::Box3, blur: Blur::Stored, ..settings(one) };
        let receiver = Receiver::at(0.5, 0.5, 0.9);
        f64::from(build(&settings, &map(3, &texels)).transmittance(&receiver))
    };
    assert!((soft(false) - (-4.0f64 / 9.0).exp()).abs() < 1e-6);
    assert!((soft(true) - (-4.0f64 / 81.0).exp()).abs() < 1e-6);
}

#[test]
fn settings_that_make_no_sense_are_refused() {
    let refused = |change: &dyn Fn(&mut dapple_opacity_maps::Layered)| {
        let mut one = layered(deep(0.3), 8);
        change(&mut one);
        settings(one).check().unwrap_err().to_string()
    };
    assert!(refused(&|l| l.layers = 0).contains("layers = 0"));
    assert!(refused(&|l| l.layers = 257).contains("1..=256"));
    assert!(refused(&|l| l.layout = bounded(f32::NAN)).contains("lambda"));
    assert!(refused(&|l| l.layout = bounded(1.1)).contains("lambda"));
    assert!(refused(&|l| l.packing = Packing::Targets(9)).contains("targets"));
    assert!(refused(&|l| l.write_bias = f32::NAN).contains("write bias"));
    assert!(refused(&|l| l.blend = Blend::Alpha).contains("four channels"));
    assert!(refused(&|l| l.soft_start = true).contains("soft start"));
    assert!(refused(&|l| (l.format, l.blend) = (Format::Fixed, Blend::Over)).contains("added"));
    assert!(
        refused(&|l| {
            l.layout = dapple_opacity_maps::Layout::Deep { span: 0.3, growth: 1.0, listing: true };
            l.packing = Packing::Slabs;
        })
        .contains("listing")
    );
    let split = dapple_opacity_maps::Split {
        lambda: 0.5,
        kind: dapple_opacity_maps::SplitKind::Table8,
        width: 2,
    };
    let bins = dapple_opacity_maps::Bins::Full;
    let layout = dapple_opacity_maps::Layout::Bounded { split, bins };
    assert!(refused(&|l| l.layout = layout.clone()).contains("width"));
}

#[test]
fn bytes_and_passes_are_what_the_layout_says() {
    let mut one = layered(bounded(0.0), 32);
    one.packing = Packing::Targets(8);
    // 512 x 512: 32 MiB of eight RGBA32F targets, 2 MiB of two bounds.
    assert_eq!(bytes_per_texel(&one) * 512 * 512, (32 + 2) << 20);
    assert_eq!(geometry_passes(&one), 2);
    one.packing = Packing::Single;
    assert_eq!((bytes_per_texel(&one) - 8) * 512 * 512, 128 << 20);
    assert_eq!(geometry_passes(&one), 33);
    one.layers = 33;
    one.packing = Packing::Targets(8);
    assert_eq!((bytes_per_texel(&one), geometry_passes(&one)), (8 + 36 * 4, 3));
    one.end_map = dapple_opacity_maps::EndMap::Swapped;
    assert_eq!(geometry_passes(&one), 4);
    one.packing = Packing::Slabs;
    one.layout = even();
    one.format = Format::F16;
    assert_eq!((bytes_per_texel(&one), geometry_passes(&one)), (36 * 2, 9));
    let maps = build(&settings(one.clone()), &one_texel(vec![]));
    assert_eq!(maps.map_bytes(), 72 + 4);
}

#[test]
fn counters_are_exact() {
    let mut fragments = map(2, &[vec![(0.1, 0.5), (0.2, 0.5), (0.3, 0.5)], vec![]]);
    fragments.opaque = vec![NO_OPAQUE, 0.5];
    let mut one = layered(bounded(0.0), 10);
    let mut check = |packing, format, opaque, expected: (u64, u64)| {
        (one.packing, one.format) = (packing, format);
        let settings = Settings { opaque, ..settings(one.clone()) };
        let found = counters::building(&one, &settings, &fragments);
        let (fragments_read, additions) = expected;
        let words_written = 2 * (2 + 10);
        assert_eq!(found, Counters { fragments_read, additions, words_written, texels_fetched: 0 });
        assert_eq!(words_written as usize, build(&settings, &fragments).code().words() * 2);
    };
    let weight = Opaque::Weight { weight: 3.0, in_bounds: false };
    // Bounds read three; then every pass reads them, and the weighted opaque one.
    check(Packing::Sorted, Format::F32, Opaque::Separate, (3 + 3, 3 + 2 * 10));
    check(Packing::Sorted, Format::F32, weight, (3 + 4, 4 + 2 * 10));
    check(Packing::Sorted, Format::F16, weight, (3 + 2 * 4, 4));
    check(Packing::Single, Format::F32, weight, (3 + 10 * 4, 40));
    check(Packing::Slabs, Format::F32, weight, (3 + 3 * 4, 16));
    check(Packing::Targets(2), Format::F32, weight, (3 + 2 * 4, 48));
    // A receiver reads two bounds, and as many maps as its place needs.
    let settings = settings(layered(bounded(0.0), 10));
    let maps = build(&settings, &fragments);
    let dapple_opacity_maps::Code::Layered(l) = &settings.code else { unreachable!() };
    let code = LayeredCode::new(l, Opaque::Separate);
    let fetched = |depth| {
        let receiver = Receiver::at(0.25, 0.5, depth);
        counters::shading(&code, &settings, &maps, (2, 1), &receiver)
    };
    assert_eq!([0.05, 0.1, 0.2, 0.9].map(fetched), [2, 3, 4, 3]);
}

#[test]
fn frames_do_not_see_the_one_before() {
    let (first, second) = (random(1, 4, 4, 30), random(2, 4, 4, 5));
    for packing in [Packing::Sorted, Packing::Slabs, Packing::Targets(1), Packing::Single] {
        for layout in [even(), deep(0.3), bounded(0.5)] {
            let mut one = layered(layout, 9);
            one.packing = packing;
            let settings = settings(one);
            let mut maps = build(&settings, &first);
            maps.build(&second).unwrap();
            let fresh = build(&settings, &second);
            assert!((0..16).all(|t| maps.texel(t) == fresh.texel(t)));
        }
    }
    let unlike = random(1, 4, 5, 3);
    let mut maps = build(&settings(layered(even(), 4)), &first);
    assert!(maps.build(&unlike).is_err());
}
