//! Properties of layered maps (numbers as in docs: P2 to P14), each with a fault that breaks it.

use crate::support::*;
use dapple_opacity_maps::{
    Blend, Blur, Format, Fragments, Layered, Layout, Lookup, Model, Packing, Receiver, Settings,
    Taps, cpu::Maps, faults::Fault,
};
use proptest::prelude::*;

/// What most properties are tried on.
fn maps_to_try() -> impl Strategy<Value = Fragments> {
    (any::<u64>(), 1..5u32, 1..5u32, 1..24usize).prop_map(|(seed, w, h, n)| random(seed, w, h, n))
}

fn any_layered() -> impl Strategy<Value = Layered> {
    let layers = prop::sample::select(vec![1u32, 2, 3, 4, 5, 8, 16, 33, 64]);
    let lookup = prop::sample::select(vec![Lookup::Lerp, Lookup::Nearest, Lookup::Exclusive]);
    (prop::sample::select(layouts()), layers, lookup).prop_map(|(layout, layers, lookup)| {
        let mut one = layered(layout, layers);
        one.lookup = lookup;
        one
    })
}

fn with_fault(fault: Fault, layered: &Layered, fragments: &Fragments) -> Maps {
    let settings = settings(layered.clone());
    build_with(&settings, fragments, fault.code(&settings).unwrap()).unwrap()
}

fn each_texel(fragments: &Fragments, mut holds: impl FnMut(usize) -> bool) -> bool {
    (0..fragments.texels()).all(&mut holds)
}

/// P2: one layer for each fragment, none lost.
fn counts_fragments(maps: &Maps, layered: &Layered, fragments: &Fragments) -> bool {
    each_texel(fragments, |texel| {
        let sums = sums(maps, layered, texel);
        let whole = sums.iter().all(|s| s.fract() == 0.0);
        whole && sums[sums.len() - 1] == fragments.texel(texel).len() as f32
    })
}

/// P3: sums never fall from layer to layer.
fn never_falls(maps: &Maps, layered: &Layered, fragments: &Fragments) -> bool {
    each_texel(fragments, |texel| sums(maps, layered, texel).windows(2).all(|w| w[0] <= w[1]))
}

/// P4: transmittance lies in 0..=1 and never rises along a ray.
fn decays(maps: &Maps, fragments: &Fragments) -> bool {
    each_texel(fragments, |texel| {
        let at = |i: i32| maps.code().decode(texel, maps.texel(texel), i as f32 / 400.0);
        let values: Vec<f32> = (-2..=420).map(at).collect();
        values.iter().all(|t| (0.0..=1.0).contains(t))
            && values.windows(2).all(|w| w[1] <= w[0] + 1e-6)
    })
}

/// P5: lit in front of everything, e^-Σω behind everything.
fn ends_are_exact(maps: &Maps, fragments: &Fragments) -> bool {
    each_texel(fragments, |texel| {
        let decode = |depth| maps.code().decode(texel, maps.texel(texel), depth);
        let end = (-total(fragments, texel)).exp();
        decode(-0.01) == 1.0 && (f64::from(decode(9.0)) - end).abs() < 1e-5
    })
}

/// P6, first half: at the boundaries between layers, linear lookup gives the exact prefix.
fn boundaries_are_exact(maps: &Maps, fragments: &Fragments, layers: u32) -> bool {
    each_texel(fragments, |texel| {
        let words = maps.texel(texel);
        let (first, last) = (words[0], words[1]);
        (1..layers).all(|k| {
            let depth = first + (last - first) * k as f32 / layers as f32;
            let strict = prefix(fragments, texel, depth - 1e-5).0;
            let inclusive = prefix(fragments, texel, depth + 1e-5).1;
            let t = f64::from(maps.code().decode(texel, words, depth));
            t <= (-strict).exp() + 1e-3 && t >= (-inclusive).exp() - 1e-3
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(256) })]

    #[test]
    fn p2_every_fragment_has_one_layer(fragments in maps_to_try(), layered in any_layered()) {
        let mut ones = fragments;
        ones.items.iter_mut().for_each(|f| f.omega = 1.0);
        prop_assert!(counts_fragments(&build(&settings(layered.clone()), &ones), &layered, &ones));
    }

    #[test]
    fn p3_sums_never_fall_and_totals_depend_on_nothing(
        fragments in maps_to_try(), layered in any_layered(), seed in any::<u64>(),
    ) {
        let plain = build(&settings(layered.clone()), &fragments);
        prop_assert!(never_falls(&plain, &layered, &fragments));
        let mut fixed = layered;
        fixed.format = Format::Fixed;
        let mut other = fixed.clone();
        other.layout = bounded(0.3);
        let a = build(&settings(fixed.clone()), &fragments);
        let b = build(&settings(fixed.clone()), &shuffled(&fragments, seed));
        let c = build(&settings(other.clone()), &fragments);
        for texel in 0..fragments.texels() {
            prop_assert_eq!(a.texel(texel), b.texel(texel));
            prop_assert_eq!(sums(&a, &fixed, texel).last().copied(),
                sums(&c, &other, texel).last().copied());
            let off = total(&fragments, texel) - f64::from(sums(&a, &fixed, texel)[fixed.layers as usize - 1]);
            prop_assert!(off.abs() < 1e-4);
        }
    }

    #[test]
    fn p4_transmittance_decays(fragments in maps_to_try(), layered in any_layered()) {
        prop_assert!(decays(&build(&settings(layered), &fragments), &fragments));
    }

    #[test]
    fn p5_ends_are_exact(fragments in maps_to_try(), layered in any_layered()) {
        let mut layered = layered;
        if matches!(layered.layout, Layout::Deep { .. }) {
            // The last layer is open: only a lookup that counts it reaches the end.
            layered.lookup = Lookup::Nearest;
        }
        prop_assert!(ends_are_exact(&build(&settings(layered), &fragments), &fragments));
    }

    #[test]
    fn p6_errors_are_bounded_by_the_layer(fragments in maps_to_try(), layered in any_layered()) {
        let mut layered = layered;
        layered.lookup = Lookup::Lerp;
        let maps = build(&settings(layered.clone()), &fragments);
        for texel in 0..fragments.texels() {
            let sums = sums(&maps, &layered, texel);
            let mut previous = 0.0;
            let largest = sums.iter().map(|&s| f64::from(s - std::mem::replace(&mut previous, s)))
                .fold(0.0, f64::max);
            for i in 0..200 {
                let depth = i as f32 / 200.0;
                let t = f64::from(maps.code().decode(texel, maps.texel(texel), depth));
                let exact = prefix(&fragments, texel, depth).0;
                prop_assert!((-t.ln() - exact).abs() <= largest + 1e-4, "{} {exact}", -t.ln());
            }
        }
    }

    #[test]
    fn p7_packings_agree(fragments in maps_to_try(), layered in any_layered(), over in any::<bool>()) {
        let (mut fragments, mut layered) = (fragments, layered);
        if over {
            layered.blend = Blend::Over;
            // Opacity is clamped to 1 - 2^-10 before its logarithm, in slabs for each texture alone.
            fragments.items.iter_mut().for_each(|f| f.omega *= 0.2);
        }
        let receivers = receivers(5, 200);
        let with = |packing, format| {
            let mut one = layered.clone();
            (one.packing, one.format) = (packing, format);
            let settings = settings(one);
            settings.check().unwrap();
            let maps = build(&settings, &fragments);
            receivers.iter().map(|r| maps.transmittance(r)).collect::<Vec<f32>>()
        };
        let others = [Packing::Single, Packing::Slabs, Packing::Targets(1), Packing::Targets(8)];
        let sorted = with(Packing::Sorted, Format::F32);
        for packing in others {
            for (a, b) in sorted.iter().zip(with(packing, Format::F32)) {
                prop_assert!((a - b).abs() < 3e-5, "{packing:?} {a} {b}");
            }
        }
        if !over {
            let sorted = with(Packing::Sorted, Format::Fixed);
            for packing in others {
                for (a, b) in sorted.iter().zip(with(packing, Format::Fixed)) {
                    // Sums are the same; slabs alone are added up after they are read.
                    let slack = if packing == Packing::Slabs { 1e-6 } else { 0.0 };
                    prop_assert!((a - b).abs() <= slack, "{packing:?} {a} {b}");
                }
            }
        }
        if !over {
            // Drawn in the same order, maps have the same bits in narrow formats too.
            for format in [Format::F16, Format::Unorm8] {
                prop_assert_eq!(with(Packing::Single, format), with(Packing::Targets(8), format));
            }
        }
    }

    #[test]
    fn p8_methods_meet_where_their_layers_do(seed in any::<u64>(), layers in 1..40u32) {
        // Every texel from 0.25 to 0.75: all three layouts have the same boundaries.
        let mut fragments = random(seed, 3, 3, 20);
        for texel in 0..9 {
            let (from, to) = (fragments.starts[texel] as usize, fragments.starts[texel + 1] as usize);
            for f in &mut fragments.items[from..to] {
                f.depth = 0.25 + 0.5 * f.depth;
            }
            if to > from {
                fragments.items[from].depth = 0.25;
                fragments.items[to - 1].depth = if to - from > 1 { 0.75 } else { 0.25 };
            }
        }
        let values = |layout: Layout, lookup| {
            let mut one = layered(layout, layers);
            one.lookup = lookup;
            let maps = build(&settings(one.clone()), &fragments);
            (0..9)
                .filter(|&t| fragments.texel(t).len() > 1)
                .map(|t| sums(&maps, &one, t))
                .collect::<Vec<_>>()
        };
        let ours = values(bounded(0.0), Lookup::Lerp);
        prop_assert_eq!(&ours, &values(even(), Lookup::Lerp));
        prop_assert_eq!(&ours, &values(deep(0.5), Lookup::Lerp));
    }

    #[test]
    fn p8_one_layer_holds_the_total(fragments in maps_to_try(), layout in prop::sample::select(layouts())) {
        let mut one = layered(layout, 1);
        one.lookup = Lookup::Nearest;
        let maps = build(&settings(one.clone()), &fragments);
        for texel in 0..fragments.texels() {
            let expected = total(&fragments, texel);
            prop_assert!((f64::from(sums(&maps, &one, texel)[0]) - expected).abs() < 1e-5);
        }
    }

    #[test]
    fn p9_bounded_layers_ignore_where_the_light_s_planes_lie(
        fragments in maps_to_try(), layers in 1..40u32, lambda in 0.0..=1.0f32,
    ) {
        // Halved and shifted by powers of two: exact in f32.
        let mut moved = fragments.clone();
        moved.items.iter_mut().for_each(|f| f.depth = 0.5 * f.depth + 0.25);
        let one = layered(bounded(lambda), layers);
        let (a, b) = (build(&settings(one.clone()), &fragments), build(&settings(one.clone()), &moved));
        for texel in 0..fragments.texels() {
            let thin = |m: &Maps| m.texel(texel)[1] - m.texel(texel)[0] < 2e-6;
            if !thin(&a) && !thin(&b) {
                prop_assert_eq!(sums(&a, &one, texel), sums(&b, &one, texel));
            }
        }
    }

    #[test]
    fn p9_reversed_light_sees_the_rest(fragments in maps_to_try(), layers in 1..40u32) {
        let mut reversed = fragments.clone();
        reversed.items.iter_mut().for_each(|f| f.depth = 1.0 - f.depth);
        let mut one = layered(bounded(0.0), layers);
        one.format = Format::Fixed;
        let (a, b) = (build(&settings(one.clone()), &fragments), build(&settings(one.clone()), &reversed));
        for texel in (0..fragments.texels()).filter(|&t| !fragments.texel(t).is_empty()) {
            let (here, there) = (a.texel(texel), b.texel(texel));
            prop_assert_eq!((here[0], here[1]), (1.0 - there[1], 1.0 - there[0]));
            let (depth, thick) = (here[1] - here[0], total(&fragments, texel));
            if depth < 1e-3 {
                continue;
            }
            // At a boundary on which nothing lies, what is in front becomes what is behind.
            for k in 1..layers {
                let share = f64::from(k) / f64::from(layers);
                let z = f64::from(here[0]) + f64::from(depth) * share;
                let near = |f: &dapple_opacity_maps::Fragment| (f64::from(f.depth) - z).abs() < 1e-5;
                if !fragments.texel(texel).iter().any(near) {
                    let sum = sums(&a, &one, texel)[k as usize - 1];
                    let rest = sums(&b, &one, texel)[(layers - k) as usize - 1];
                    prop_assert!((f64::from(sum + rest) - thick).abs() < 1e-4);
                }
            }
        }
    }

    #[test]
    fn p10_bounds_hold_every_fragment(fragments in maps_to_try()) {
        let maps = build(&settings(layered(bounded(0.0), 4)), &fragments);
        prop_assert!(bounds_hold(&maps, &fragments, 0));
    }

    #[test]
    fn p13_blurs_keep_constants_and_order(seed in any::<u64>(), layers in 1..20u32) {
        let one_texel = random(seed, 1, 1, 20);
        let texel: Vec<(f32, f32)> = one_texel.items.iter().map(|f| (f.depth, f.omega)).collect();
        let constant = map(6, &vec![texel; 36]);
        let varied = random(seed ^ 1, 6, 6, 20);
        for taps in [Taps::Box3, Taps::Box4, Taps::Stochastic16] {
            for layout in [even(), deep(0.4), bounded(0.4)] {
                let with = |taps, blur, map: &Fragments| {
                    let settings = Settings { taps, blur, ..settings(layered(layout.clone(), layers)) };
                    let maps = build(&settings, map);
                    receivers(seed, 40).iter().map(|r| maps.transmittance(r)).collect::<Vec<_>>()
                };
                let single = with(Taps::One, Blur::Transmittance, &constant);
                for blur in [Blur::Transmittance, Blur::Stored] {
                    for (a, b) in single.iter().zip(with(taps, blur, &constant)) {
                        prop_assert!((a - b).abs() < 1e-5, "{taps:?} {blur:?}: {a} {b}");
                    }
                }
                // Planes are the same for every texel: so is the layer.
                if layout == even() {
                    let stored = with(taps, Blur::Stored, &varied);
                    for (a, b) in stored.iter().zip(with(taps, Blur::Transmittance, &varied)) {
                        prop_assert!(*a <= b + 1e-5);
                    }
                }
            }
        }
    }

    #[test]
    fn p14_over_is_the_product_in_any_order(seed in any::<u64>(), count in 1..30usize) {
        let mut rng = generator(seed);
        let alphas: Vec<f64> = (0..count).map(|_| 0.6 * f64::from(unit(&mut rng))).collect();
        let texel = |model: Model| alphas.iter().enumerate()
            .map(|(i, &a)| (0.2 + 0.01 * i as f32, model.omega(a) as f32)).collect::<Vec<_>>();
        let fragments = map(1, &[texel(Model::ExpTau)]);
        let end = |format, fragments: &Fragments| {
            let mut over = layered(even(), 5);
            (over.blend, over.format) = (Blend::Over, format);
            f64::from(build(&settings(over), fragments).transmittance(&Receiver::at(0.5, 0.5, 0.9)))
        };
        let product: f64 = alphas.iter().map(|a| 1.0 - a).product();
        let clamped = product.max(1.0 / 1024.0);
        prop_assert!((end(Format::F32, &fragments) - clamped).abs() < 1e-5);
        prop_assert!((end(Format::F32, &shuffled(&fragments, seed)) - clamped).abs() < 1e-5);
        prop_assert!((end(Format::Unorm8, &fragments) - clamped).abs() <= 0.5 * count as f64 / 255.0 + 1e-3);
        // Never brighter than the thesis's own model.
        let raw = build(&settings(layered(even(), 5)), &map(1, &[texel(Model::ExpAlpha)]));
        let added = raw.transmittance(&Receiver::at(0.5, 0.5, 0.9));
        prop_assert!(product <= f64::from(added) + 1e-6);
    }
}

/// P10; texel `t` is judged by the words of texel `t + shift`.
fn bounds_hold(maps: &Maps, fragments: &Fragments, shift: usize) -> bool {
    each_texel(fragments, |texel| {
        let words = maps.texel((texel + shift) % fragments.texels());
        fragments.texel(texel).iter().all(|f| words[0] <= f.depth && f.depth <= words[1])
    })
}

#[test]
fn every_property_is_broken_by_a_fault() {
    let fragments = rich();
    let mut ones = fragments.clone();
    ones.items.iter_mut().for_each(|f| f.omega = 1.0);
    let bom = layered(bounded(0.0), 8);
    let dom = layered(deep(0.3), 16);
    let mut nearest = bom.clone();
    nearest.lookup = Lookup::Nearest;
    let good = |one: &Layered| build(&settings(one.clone()), &fragments);

    // P2 and P5: layers that lack their own fragments lose the last.
    assert!(!counts_fragments(&with_fault(Fault::LatePrefix, &bom, &ones), &bom, &ones));
    assert!(!ends_are_exact(&with_fault(Fault::LatePrefix, &nearest, &fragments), &fragments));
    // P3: the printed masks are not monotone, a depth test depends on order.
    assert!(!never_falls(&with_fault(Fault::Listing, &dom, &fragments), &dom, &fragments));
    let tested = |map: &Fragments| with_fault(Fault::DepthTested, &bom, map);
    let (a, b) = (tested(&fragments), tested(&shuffled(&fragments, 1)));
    assert!((0..36).any(|t| a.texel(t) != b.texel(t)), "row 42: the order of drawing shows");
    let (a, b) = (good(&bom), build(&settings(bom.clone()), &shuffled(&fragments, 1)));
    let differ = |t: usize| a.texel(t).iter().zip(b.texel(t)).any(|(a, b)| (a - b).abs() > 1e-4);
    assert!(!(0..36).any(differ), "and only there");
    // P4: a table that falls.
    assert!(!decays(&with_fault(Fault::WrappingTable, &nearest, &fragments), &fragments));
    // P6: boundaries.
    assert!(boundaries_are_exact(&good(&bom), &fragments, 8));
    for fault in [Fault::MismatchedBias, Fault::NextTexelBounds, Fault::LatePrefix] {
        let maps = with_fault(fault, &bom, &fragments);
        assert!(!boundaries_are_exact(&maps, &fragments, 8), "{fault:?}");
    }
    // P7: the listing differs from what the packings agree on.
    let (a, b) = (good(&dom), with_fault(Fault::Listing, &dom, &fragments));
    assert!((0..36).any(|t| a.texel(t) != b.texel(t)));
    // P8, P9: fewer bins, other bounds.
    for fault in [Fault::FewerBins, Fault::NextTexelBounds] {
        let (a, b) = (good(&bom), with_fault(fault, &bom, &fragments));
        assert!((0..36).any(|t| a.texel(t) != b.texel(t)), "{fault:?}");
    }
    // P10: another texel's bounds.
    assert!(!bounds_hold(&good(&bom), &fragments, 1));
    // P14: states whose channels are not independent.
    let mut alpha = layered(even(), 8);
    alpha.packing = Packing::Targets(2);
    let over = Layered { blend: Blend::Over, ..alpha.clone() };
    for blend in [Blend::Alpha, Blend::Premultiplied] {
        let failing = Layered { blend, ..alpha.clone() };
        let (a, b) = (good(&over), good(&failing));
        let last_of_four = |m: &Maps, t: usize| (m.texel(t)[3], m.texel(t)[7]);
        assert!((0..36).all(|t| last_of_four(&a, t) == last_of_four(&b, t)), "alpha is right");
        assert!((0..36).any(|t| a.texel(t)[0] > b.texel(t)[0] + 0.1), "red is not: {blend:?}");
    }
}
