//! Layers of opacity on the device against the reference, on the device's own fragments.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]
#![allow(clippy::print_stderr, reason = "tests say what they measured")]

mod gpu_support;

use dapple_gpu::Gpu;
use dapple_gpu::light_space::LightSpaceMesh;
use dapple_opacity_maps::gpu::fragments;
use dapple_opacity_maps::layered::reference::TIE;
use dapple_opacity_maps::reference::Reference;
use dapple_opacity_maps::{
    Bins, Blend, Blur, Format, Fragments, Layered, Layout, Lookup, Opaque, Packing, Receiver,
    Settings, Slicing, Split, SplitKind, Storage, Taps,
};
use gpu_support::{MODEL, add, bounded, exclusive_gpu, foliage, frame, plain, receivers, sheet};

const SIZE: [u32; 2] = [67, 45];

/// Sums and exponentials in 32-bit floats.
const FLOATS: f64 = 3e-6;
/// A mesh of a dozen fragments a texel, each sum rounded to 11 binary digits: Ω e^-Ω <= 1 / e.
const HALVES: f64 = 20.0 / 2048.0 / std::f64::consts::E;
/// The same in bytes, each opacity rounded to 1/255 and again as it is blended; roundings do not
/// all go one way.
const BYTES: f64 = 10.0 / 255.0;

struct Verdict {
    /// Farthest that a receiver lies outside of its interval.
    worst: f64,
    /// Receivers whose interval is wide: rounding may tip them.
    ties: usize,
}

/// Holds receivers to the intervals within which rounding may move the reference.
fn verdict(s: &Settings, own: &Fragments, receivers: &[Receiver], got: &[f32]) -> Verdict {
    assert_eq!(receivers.len(), got.len());
    let reference = Reference::new(s, own).unwrap();
    let mut verdict = Verdict { worst: 0.0, ties: 0 };
    for (receiver, &got) in receivers.iter().zip(got) {
        assert!((0.0..=1.0).contains(&got), "{got}");
        let (least, greatest) = reference.interval(receiver);
        verdict.ties += usize::from(greatest - least > TIE);
        let got = f64::from(got);
        verdict.worst = verdict.worst.max(least - got).max(got - greatest);
    }
    verdict
}

/// One mesh with its fragments and receivers.
struct Case {
    mesh: LightSpaceMesh,
    own: Fragments,
    receivers: Vec<Receiver>,
}

impl Case {
    fn new(gpu: &Gpu) -> Self {
        let mesh = foliage(3, 200);
        let own = fragments(gpu, &mesh, MODEL, SIZE).unwrap();
        assert!(own.items.len() > 2 * own.texels());
        Self { mesh, own, receivers: receivers(9, 1500) }
    }

    /// Within `tolerance` of the reference, which a receiver moved by little is not.
    fn check(&self, gpu: &Gpu, s: &Settings, tolerance: f64) {
        let got = frame(gpu, &self.mesh, &self.receivers, SIZE, s).transmittances;
        let found = verdict(s, &self.own, &self.receivers, &got);
        let moved = Settings { bias: s.bias + 0.05, ..s.clone() };
        let control = verdict(&moved, &self.own, &self.receivers, &got);
        eprintln!("{:.1e} ({} ties; moved {:.1e}) {s:?}", found.worst, found.ties, control.worst);
        assert!(3 * found.ties < got.len(), "{} ties: {s:?}", found.ties);
        assert!(found.worst <= tolerance, "{}: {s:?}", found.worst);
        assert!(control.worst > 3.0 * tolerance, "the control: {} {s:?}", control.worst);
    }
}

fn split(lambda: f32, kind: SplitKind, bins: Bins) -> Layout {
    Layout::Bounded { split: Split { lambda, kind, width: 512 }, bins }
}

fn layouts() -> Vec<Layout> {
    let deep = |span, growth| Layout::Deep { span, growth, listing: false };
    vec![
        Layout::Planes(Slicing::Uniform),
        Layout::Planes(Slicing::Density),
        Layout::Planes(Slicing::Growing),
        deep(0.3, 1.0),
        deep(0.9, 1.0),
        deep(0.6, 1.4),
        Layout::Deep { span: 0.6, growth: 1.0, listing: true },
        split(0.0, SplitKind::Normalised, Bins::Full),
        split(0.5, SplitKind::Normalised, Bins::Full),
        split(1.0, SplitKind::Normalised, Bins::Thesis),
        split(0.7, SplitKind::Listing, Bins::Thesis),
        split(1.0, SplitKind::Table8, Bins::Full),
        split(0.4, SplitKind::Table32, Bins::Full),
        split(0.5, SplitKind::Positions, Bins::Full),
        split(1.0, SplitKind::Positions, Bins::Full),
    ]
}

#[test]
fn every_layout_and_lookup_is_the_reference() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let case = Case::new(gpu);
    let mut checked = 0;
    for layout in layouts() {
        for lookup in [Lookup::Lerp, Lookup::Nearest, Lookup::Exclusive] {
            let layered = Layered { layout: layout.clone(), lookup, ..bounded(7) };
            case.check(gpu, &plain(layered), FLOATS);
            checked += 1;
        }
    }
    assert_eq!(checked, 45);
}

#[test]
fn every_number_of_layers_is_the_reference() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let case = Case::new(gpu);
    for layers in [1, 2, 3, 5, 32, 33, 256] {
        for layout in [Layout::Planes(Slicing::Uniform), bounded(1).layout] {
            let layered = Layered { layout, ..bounded(layers) };
            case.check(gpu, &plain(layered.clone()), FLOATS);
            let bins = Layered { storage: Storage::Atomic, format: Format::Fixed, ..layered };
            // A fragment's thickness is rounded to 2^-20.
            case.check(gpu, &plain(bins), 2.0 * FLOATS);
        }
    }
}

fn blends_and_formats() -> impl Iterator<Item = (Blend, Format)> {
    let formats = [Format::F32, Format::F16, Format::Unorm8, Format::Unorm8Scaled];
    [Blend::Add, Blend::Over].into_iter().flat_map(move |blend| formats.map(|f| (blend, f)))
}

#[test]
fn every_packing_blend_and_format_is_the_reference() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let case = Case::new(gpu);
    let packings = [Packing::Single, Packing::Slabs, Packing::Targets(1), Packing::Targets(3)];
    let mut checked = 0;
    for (packing, layers) in packings.into_iter().zip([6, 9, 17, 30]) {
        for (blend, format) in blends_and_formats() {
            let s = plain(Layered { packing, blend, format, ..bounded(layers) });
            if s.check().is_err() {
                continue;
            }
            let tolerance = match format {
                Format::F32 if blend == Blend::Add => FLOATS,
                // 1 - s loses digits: 2^-10 of it may be left.
                Format::F32 => 1e-4,
                Format::F16 => HALVES,
                _ => BYTES,
            };
            case.check(gpu, &s, tolerance);
            checked += 1;
        }
    }
    assert_eq!(checked, 28);
}

/// A mesh that is drawn from the front to the back, as the reference's fragments are sorted.
fn sheets() -> LightSpaceMesh {
    let mut mesh = LightSpaceMesh::default();
    for i in 0..12 {
        let (z, opacity) =
            (0.2 + 0.05 * f64::from(i * i) / 12.0, [0.3, 0.69, 0.05][i as usize % 3]);
        let u = if i % 2 == 0 { [0.0, 1.0] } else { [0.3, 1.0] };
        add(&mut mesh, sheet(u, [0.0, 1.0], z), opacity, None);
    }
    mesh
}

#[test]
fn states_whose_channels_depend_on_each_other_fail_as_the_reference_does() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let mesh = sheets();
    let case = Case {
        own: fragments(gpu, &mesh, MODEL, SIZE).unwrap(),
        mesh,
        receivers: receivers(2, 800),
    };
    assert!(case.own.items.len() > 8 * case.own.texels());
    for blend in [Blend::Alpha, Blend::Premultiplied] {
        for packing in [Packing::Targets(8), Packing::Targets(1)] {
            for layers in [3, 8, 10] {
                for format in [Format::F32, Format::F16, Format::Unorm8] {
                    let s = plain(Layered { blend, packing, format, ..bounded(layers) });
                    let tolerance = match format {
                        Format::F32 => 1e-4,
                        // The logarithm magnifies what halves near 1 lose.
                        _ => BYTES,
                    };
                    case.check(gpu, &s, tolerance);
                }
            }
        }
    }
    // They do fail: sums over maps say something else.
    let shade = |blend| {
        let s = plain(Layered { blend, ..bounded(8) });
        frame(gpu, &case.mesh, &case.receivers, SIZE, &s).transmittances
    };
    let (good, bad) = (shade(Blend::Over), shade(Blend::Alpha));
    let worst = good.iter().zip(&bad).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(worst > 0.1, "{worst}");
}

#[test]
fn taps_blurs_biases_and_opaque_casters_are_the_reference() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let case = Case::new(gpu);
    let mut checked = 0;
    let opaques = [
        Opaque::Separate,
        Opaque::Weight { weight: 3.0, in_bounds: false },
        Opaque::Weight { weight: 10.0, in_bounds: true },
    ];
    for (i, taps) in [Taps::One, Taps::Box3, Taps::Box4, Taps::Stochastic16].into_iter().enumerate()
    {
        for blur in [Blur::Transmittance, Blur::Stored] {
            for opaque in opaques {
                for layout in
                    [layouts()[i].clone(), layouts()[i + 3].clone(), layouts()[i + 7].clone()]
                {
                    let soft_start =
                        blur == Blur::Stored && !matches!(layout, Layout::Planes(_)) && i % 2 == 0;
                    let write_bias = if i < 2 { 0.0 } else { 1e-3 };
                    let layered = Layered { layout, soft_start, write_bias, ..bounded(8) };
                    let s = Settings { taps, blur, opaque, bias: 2e-3, ..plain(layered) };
                    case.check(gpu, &s, FLOATS);
                    checked += 1;
                }
            }
        }
    }
    assert_eq!(checked, 72);
}
