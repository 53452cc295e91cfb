//! The processor's form against the reference, over every layout, format and packing.

use crate::support::*;
use dapple_opacity_maps::{
    Blend, Blur, Format, Fragments, Lookup, Opaque, Packing, Settings, Taps,
    code::TexelCode,
    faults::Fault,
    layered::reference::{TIE, tolerance},
    reference::{Reference, near_tie},
};

/// What a comparison found.
#[derive(Debug, Default)]
struct Found {
    /// Receivers whose answer rounding does not decide.
    checked: usize,
    /// Receivers whose answer it does.
    ties: usize,
    /// How many lie outside of their interval by more than the tolerance.
    wrong: usize,
    /// By how many tolerances the worst does.
    worst: f64,
}

fn compare(
    settings: &Settings,
    fragments: &Fragments,
    code: Option<Box<dyn TexelCode>>,
    count: usize,
) -> Found {
    settings.check().unwrap();
    let maps = match code {
        Some(code) => build_with(settings, fragments, code).unwrap(),
        None => build(settings, fragments),
    };
    let reference = Reference::new(settings, fragments).unwrap();
    let limit = tolerance(fragments.items.len());
    let mut found = Found::default();
    for receiver in receivers(7, count) {
        let (least, greatest) = reference.interval(&receiver);
        let plain = reference.transmittance(&receiver);
        let slack = 1e-12;
        assert!(least <= plain + slack && plain <= greatest + slack, "{least} {plain} {greatest}");
        found.ties += usize::from(greatest - least > TIE);
        found.checked += usize::from(greatest - least <= TIE);
        let t = f64::from(maps.transmittance(&receiver));
        let off = (least - t).max(t - greatest) / limit;
        found.wrong += usize::from(off.is_nan() || off > 1.0);
        found.worst = found.worst.max(off);
    }
    found
}

fn assert_agrees(settings: &Settings, fragments: &Fragments) {
    let found = compare(settings, fragments, None, 300);
    assert!(found.wrong == 0, "{settings:?}: {found:?}");
    assert!(found.checked >= 285, "too many ties: {settings:?}: {found:?}");
}

#[test]
fn every_layout_lookup_and_number_of_layers_agrees() {
    let fragments = with_opaque(random(1, 6, 5, 24), 2);
    for layout in layouts() {
        for lookup in [Lookup::Lerp, Lookup::Nearest, Lookup::Exclusive] {
            for layers in [1, 2, 3, 5, 8, 32, 33, 256] {
                let mut layered = layered(layout.clone(), layers);
                layered.lookup = lookup;
                assert_agrees(&settings(layered), &fragments);
            }
        }
    }
}

#[test]
fn every_packing_and_format_agrees() {
    let fragments = with_opaque(random(3, 6, 5, 24), 4);
    let packings = [Packing::Single, Packing::Slabs, Packing::Targets(2), Packing::Sorted];
    let formats = [Format::F32, Format::F16, Format::Unorm8, Format::Unorm8Scaled, Format::Fixed];
    let blends = [Blend::Add, Blend::Over, Blend::Alpha, Blend::Premultiplied];
    let mut accepted = 0;
    for layout in [even(), deep(0.3), bounded(0.5)] {
        for packing in packings {
            for format in formats {
                for blend in blends {
                    let mut layered = layered(layout.clone(), 10);
                    (layered.packing, layered.format, layered.blend) = (packing, format, blend);
                    let settings = settings(layered);
                    if settings.check().is_ok() {
                        accepted += 1;
                        assert_agrees(&settings, &fragments);
                    }
                }
            }
        }
    }
    // Fixed point and scaled bytes can only be added; two states need four channels.
    assert_eq!(accepted, 3 * (4 * (3 * 2 + 2) + 2 * 3 * 2));
}

#[test]
fn taps_blurs_biases_and_opaque_casters_agree() {
    let fragments = with_opaque(random(5, 9, 7, 16), 6);
    let weight = |in_bounds| Opaque::Weight { weight: 3.0, in_bounds };
    let mut cases = 0;
    for layout in [even(), deep(0.3), bounded(0.7)] {
        for taps in [Taps::One, Taps::Box3, Taps::Box4, Taps::Stochastic16] {
            for blur in [Blur::Transmittance, Blur::Stored] {
                for opaque in [Opaque::Separate, weight(false), weight(true)] {
                    let mut layered = layered(layout.clone(), 8);
                    layered.write_bias = 1e-3;
                    layered.soft_start = blur == Blur::Stored && layout != even();
                    let settings = Settings { taps, blur, opaque, bias: 1e-3, ..settings(layered) };
                    assert_agrees(&settings, &fragments);
                    cases += 1;
                }
            }
        }
    }
    assert_eq!(cases, 72);
}

#[test]
fn the_listing_agrees_with_its_own_definition() {
    let fragments = random(8, 6, 5, 24);
    let listing = dapple_opacity_maps::Layout::Deep { span: 0.3, growth: 1.0, listing: true };
    for packing in [Packing::Sorted, Packing::Targets(8), Packing::Targets(1), Packing::Single] {
        let mut layered = layered(listing.clone(), 16);
        layered.packing = packing;
        assert_agrees(&settings(layered), &fragments);
    }
}

#[test]
fn every_fault_is_caught() {
    let fragments = random(9, 8, 8, 24);
    for fault in Fault::ALL {
        let mut caught = 0;
        for layout in [even(), deep(0.3), bounded(0.0)] {
            let settings = settings(layered(layout, 8));
            let Some(code) = fault.code(&settings) else { continue };
            let found = compare(&settings, &fragments, Some(code), 400);
            assert!(found.checked > 300 && found.wrong >= 5, "{fault:?} {settings:?}: {found:?}");
            caught += 1;
        }
        assert!(caught >= 1, "{fault:?} applies nowhere");
    }
}

#[test]
fn near_ties_are_those_at_boundaries() {
    use dapple_opacity_maps::Receiver;
    let settings = settings(layered(bounded(0.0), 4));
    let tie = |map, u, v, depth| near_tie(&settings, map, &Receiver::at(u, v, depth)).unwrap();
    // Fragments exactly on boundaries: k / 4 of the bounds.
    let on = map(1, &[vec![(0.0, 0.5), (0.25, 0.5), (0.5, 0.5), (1.0, 0.5)]]);
    assert!(tie(&on, 0.5, 0.5, 0.3));
    // Behind everything, and where no boundary is near, nothing is undecided.
    assert!(!tie(&on, 0.5, 0.5, 0.8));
    assert!(!tie(&on, 0.5, 0.5, 1.5));
    assert!(!tie(&on, 1.5, 0.5, 0.3));
    let off = map(1, &[vec![(0.0, 0.5), (0.3, 0.5), (0.6, 0.5), (1.0, 0.5)]]);
    assert!(!tie(&off, 0.5, 0.5, 0.31));
}
