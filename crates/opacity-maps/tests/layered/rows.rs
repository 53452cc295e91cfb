//! What each kind of layer must show on inputs made for it.

use crate::support::*;
use dapple_opacity_maps::{
    Bins, Blur, Layout, Lookup, Opaque, Receiver, Settings, Slicing, Taps, cpu::Maps,
};

#[test]
fn blurring_sums_darkens_somewhere() {
    // P13 is no equality.
    let with = |blur| {
        let settings = Settings { taps: Taps::Box3, blur, ..settings(layered(even(), 8)) };
        let maps = build(&settings, &rich());
        receivers(3, 300).iter().map(|r| maps.transmittance(r)).collect::<Vec<_>>()
    };
    let (stored, each) = (with(Blur::Stored), with(Blur::Transmittance));
    assert!(stored.iter().zip(&each).filter(|(a, b)| *a + 0.05 < **b).count() > 20);
}

#[test]
fn with_a_layer_for_each_fragment_lookups_are_strict_inclusive_or_between() {
    // Fragments in the middle of 16 of 256 layers.
    let texel: Vec<(f32, f32)> = (0..=16).map(|i| (i as f32 / 16.0, 0.1)).collect();
    let fragments = map(1, &[texel]);
    let with = |lookup| {
        let mut one = layered(bounded(0.0), 256);
        one.lookup = lookup;
        build(&settings(one), &fragments)
    };
    let [exclusive, nearest, lerp] = [Lookup::Exclusive, Lookup::Nearest, Lookup::Lerp].map(with);
    let thickness =
        |maps: &Maps, depth: f32| -f64::from(maps.code().decode(0, maps.texel(0), depth)).ln();
    for i in 0..=16 {
        let depth = i as f32 / 16.0;
        let (strict, inclusive) = prefix(&fragments, 0, depth);
        assert!((thickness(&exclusive, depth) - strict).abs() < 1e-5, "{i}");
        assert!((thickness(&nearest, depth) - inclusive).abs() < 1e-5, "{i}");
        let between = thickness(&lerp, depth);
        assert!(between >= strict - 1e-5 && between <= inclusive + 1e-5);
    }
    for i in 0..16 {
        // Between fragments all three agree.
        let depth = (i as f32 + 0.5) / 16.0;
        let exact = prefix(&fragments, 0, depth).0;
        for maps in [&exclusive, &nearest, &lerp] {
            assert!((thickness(maps, depth) - exact).abs() < 1e-5);
        }
    }
}

#[test]
fn all_bounded_layers_are_used_and_the_thesis_s_bins_waste_one() {
    // 1000 fragments evenly along every ray: each layer must hold some.
    let texel: Vec<(f32, f32)> = (0..1000).map(|i| (0.3 + i as f32 * 2e-4, 1.0)).collect();
    let fragments = map(1, &[texel]);
    let use_of = |layout: Layout| {
        let one = layered(layout, 4);
        let sums = sums(&build(&settings(one.clone()), &fragments), &one, 0);
        let mut before = 0.0;
        sums.iter().map(|&s| s - std::mem::replace(&mut before, s)).collect::<Vec<f32>>()
    };
    assert!(use_of(bounded(0.0)).iter().all(|&n| (249.0..=251.0).contains(&n)));
    let Layout::Bounded { split, .. } = bounded(0.0) else { unreachable!() };
    let thesis = use_of(Layout::Bounded { split, bins: Bins::Thesis });
    assert_eq!(thesis[3], 1.0, "the last fragment alone: {thesis:?}");
    // Deep layers that end too early pile up in the last, too late leave it empty.
    assert!(use_of(deep(0.05))[3] > 750.0);
    assert_eq!(use_of(deep(0.9))[3], 0.0);
}

#[test]
fn an_opaque_caster_of_weight_w_lets_e_to_the_minus_w_through() {
    let mut fragments = map(2, &[vec![(0.2, 0.5), (0.4, 0.5)], vec![]]);
    fragments.opaque = vec![0.8, 0.8];
    for weight in [3.0, 10.0, 1e6] {
        for in_bounds in [false, true] {
            for layout in [even(), deep(0.3), bounded(0.0)] {
                let opaque = Opaque::Weight { weight, in_bounds };
                let mut one = layered(layout.clone(), 8);
                one.lookup = Lookup::Nearest;
                let settings = Settings { opaque, ..settings(one) };
                let maps = build(&settings, &fragments);
                let behind = |u| f64::from(maps.transmittance(&Receiver::at(u, 0.5, 0.95)));
                let expected = f64::from(-weight).exp();
                assert!((behind(0.75) - expected).abs() < 1e-6, "trunk alone: {layout:?}");
                assert!((behind(0.25) - expected * (-1.0f64).exp()).abs() < 1e-6);
                assert_eq!(maps.transmittance(&Receiver::at(0.25, 0.5, 0.1)), 1.0);
            }
        }
    }
    // Row 35: a surface far below stretches bounds, and leaves layers in the gap empty.
    let used = |in_bounds| {
        let one = layered(bounded(0.0), 16);
        let opaque = Opaque::Weight { weight: 3.0, in_bounds };
        let settings = Settings { opaque, ..settings(one.clone()) };
        let texel: Vec<(f32, f32)> = (0..64).map(|i| (0.1 + i as f32 * 1e-3, 0.1)).collect();
        let mut fragments = map(1, &[texel]);
        fragments.opaque = vec![0.9];
        let sums = sums(&build(&settings, &fragments), &one, 0);
        let mut before = 0.0;
        sums.iter().filter(|&&s| s > std::mem::replace(&mut before, s)).count()
    };
    assert_eq!(used(false), 16);
    assert!(used(true) <= 3);
}

#[test]
fn blurs_reduce_noise_with_taps() {
    // White noise in thickness: variance falls with the number of taps.
    let fragments = random(12, 48, 48, 6);
    let spread = |taps| {
        let settings = Settings { taps, ..settings(layered(even(), 16)) };
        let maps = build(&settings, &fragments);
        let mut values: Vec<f64> = receivers(4, 2000)
            .iter()
            .map(|r| f64::from(maps.transmittance(&Receiver { depth: 0.99, ..*r })))
            .collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        values.iter_mut().for_each(|v| *v = (*v - mean).powi(2));
        values.iter().sum::<f64>() / values.len() as f64
    };
    let [one, nine, sixteen, jittered] =
        [Taps::One, Taps::Box3, Taps::Box4, Taps::Stochastic16].map(spread);
    assert!(nine < 0.2 * one && sixteen < nine && jittered < 0.2 * one);
}

#[test]
fn density_planes_hold_equal_thickness_and_others_do_not() {
    let fragments = random(13, 16, 16, 40);
    let spread = |slicing| {
        let one = layered(Layout::Planes(slicing), 8);
        let maps = build(&settings(one.clone()), &fragments);
        let mut layers = [0.0f64; 8];
        for texel in 0..fragments.texels() {
            let sums = sums(&maps, &one, texel);
            let mut before = 0.0;
            for (layer, &s) in layers.iter_mut().zip(&sums) {
                *layer += f64::from(s - std::mem::replace(&mut before, s));
            }
        }
        let mean = layers.iter().sum::<f64>() / 8.0;
        layers.iter().map(|l| (l - mean).abs() / mean).fold(0.0, f64::max)
    };
    assert!(spread(Slicing::Density) < 0.1);
    assert!(spread(Slicing::Uniform) > 0.2 && spread(Slicing::Growing) > 0.2);
}

#[test]
fn layers_of_views_follow_both_ends_of_each_ray() {
    let fragments = map(2, &[vec![(0.2, 0.1), (0.4, 0.1)], vec![(0.5, 0.1), (0.9, 0.1)]]);
    let settings = settings(layered(bounded(0.0), 4));
    let maps = build(&settings, &fragments);
    let dapple_opacity_maps::Code::Layered(one) = &settings.code else { unreachable!() };
    let code = dapple_opacity_maps::layered::LayeredCode::new(one, Opaque::Separate);
    for (texel, first, depth) in [(0, 0.2, 0.2), (1, 0.5, 0.4)] {
        let layer = |share: f32| code.layer_at(maps.texel(texel), first + depth * share);
        let seen = [-0.1, 0.1, 0.3, 0.6, 0.9, 1.1].map(layer);
        assert_eq!(seen, [None, Some(0), Some(1), Some(2), Some(3), None]);
    }
}
