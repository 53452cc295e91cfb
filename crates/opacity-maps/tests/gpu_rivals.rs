//! Codes without layers on the device against the reference, on the device's own fragments.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]
#![allow(clippy::print_stderr, reason = "tests say what they measured")]

mod gpu_support;

use dapple_gpu::Gpu;
use dapple_gpu::light_space::LightSpaceMesh;
use dapple_opacity_maps::gpu::{Fault, Renderer, fragments};
use dapple_opacity_maps::reference::Reference;
use dapple_opacity_maps::{
    Adaptive, Blur, Code, Deep, Format, Fourier, Fragments, Moments, Opaque, Order, Receiver,
    Settings, Stochastic, Taps, fourier, moments, taps,
};
use gpu_support::{MODEL, exclusive_gpu, foliage, frame, receivers};

const SIZE: [u32; 2] = [61, 47];

fn fourier(pairs: u32, bounded: bool, format: Format) -> Code {
    Code::Fourier(Fourier { pairs, bounded, format })
}

fn power_moments(moments: u32, bounded: bool, format: Format) -> Code {
    Code::Moments(Moments { moments, bias: 0.0, overestimation: 0.25, bounded, format })
}

fn stochastic(samples: u32, seed: u32) -> Code {
    Code::Stochastic(Stochastic { samples, seed })
}

struct Case {
    mesh: LightSpaceMesh,
    own: Fragments,
    receivers: Vec<Receiver>,
}

impl Case {
    fn new(gpu: &Gpu) -> Self {
        let mesh = foliage(13, 200);
        let own = fragments(gpu, &mesh, MODEL, SIZE).unwrap();
        assert!(own.items.len() > 2 * own.texels());
        Self { mesh, own, receivers: receivers(11, 2000) }
    }

    /// Largest error over what rounding may do to a receiver's texels, and the largest itself.
    fn errors(&self, s: &Settings, got: &[f32]) -> (f64, f64) {
        let reference = Reference::new(s, &self.own).unwrap();
        let (mut relative, mut worst) = (0.0f64, 0.0f64);
        for (receiver, &got) in self.receivers.iter().zip(got) {
            assert!((0.0..=1.0).contains(&got), "{got} {s:?}");
            let error = (f64::from(got) - reference.transmittance(receiver)).abs();
            worst = worst.max(error);
            if error > 0.0 {
                relative = relative.max(error / self.bound(s, receiver));
            }
        }
        (relative, worst)
    }

    /// What the processor's form may be off by, over the receiver's taps.
    fn bound(&self, s: &Settings, receiver: &Receiver) -> f64 {
        let mut found = [taps::Tap { texel: 0, du: 0.0, dv: 0.0 }; taps::MOST];
        let n = taps::taps(s.taps, receiver, SIZE[0], SIZE[1], &mut found);
        let of = |tap: &taps::Tap| {
            let (ray, nearest) = (self.own.texel(tap.texel), self.own.opaque[tap.texel]);
            let opaque = dapple_opacity_maps::cpu::weighted(s.opaque, nearest);
            match &s.code {
                Code::Fourier(f) => halves(f.format) + fourier::port_bound(ray, opaque),
                Code::Moments(m) => halves(m.format) + moments::port_bound(m, ray, opaque),
                // Averages over taps are rounded.
                _ => 2e-7,
            }
        };
        found[..n].iter().map(of).fold(0.0, f64::max)
    }

    /// Within bounds of the reference, which a receiver moved by little is not.
    fn check(&self, gpu: &Gpu, s: &Settings) {
        let got = frame(gpu, &self.mesh, &self.receivers, SIZE, s).transmittances;
        let (relative, worst) = self.errors(s, &got);
        let moved = Settings { bias: s.bias + 0.05, ..s.clone() };
        let (control, _) = self.errors(&moved, &got);
        eprintln!("{relative:.3} of the bound ({worst:.1e}), moved {control:.1} {s:?}");
        assert!(relative <= 1.0, "{relative} of the bound, {worst}: {s:?}");
        assert!(control > 3.0, "the control: {control} {s:?}");
    }
}

/// Devices round or truncate a half after every addition, in the order things are drawn.
fn halves(format: Format) -> f64 {
    if format == Format::F16 { 0.05 } else { 0.0 }
}

#[test]
fn codes_without_layers_are_the_reference() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let case = Case::new(gpu);
    let mut codes = vec![Code::Binary, stochastic(1, 0), stochastic(16, 5), stochastic(64, 9)];
    for bounded in [false, true] {
        for pairs in [1, 2, 7, 15] {
            codes.push(fourier(pairs, bounded, Format::F32));
        }
        for moments in [4, 6] {
            codes.push(power_moments(moments, bounded, Format::F32));
        }
        codes.push(fourier(7, bounded, Format::F16));
        codes.push(power_moments(4, bounded, Format::F16));
    }
    assert_eq!(codes.len(), 20);
    for code in codes {
        case.check(gpu, &Settings::plain(code));
    }
}

#[test]
fn taps_blurs_and_opaque_casters_are_the_reference_for_every_code() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let case = Case::new(gpu);
    let codes = [
        Code::Binary,
        stochastic(8, 1),
        fourier(5, false, Format::F32),
        fourier(5, true, Format::F32),
        power_moments(4, false, Format::F32),
        power_moments(6, true, Format::F32),
    ];
    let opaques = [
        Opaque::Separate,
        Opaque::Weight { weight: 3.0, in_bounds: false },
        Opaque::Weight { weight: 10.0, in_bounds: true },
    ];
    let mut checked = 0;
    for code in codes {
        for (opaque, taps) in opaques.into_iter().zip([Taps::Box3, Taps::Box4, Taps::One]) {
            for blur in [Blur::Transmittance, Blur::Stored] {
                let s = Settings { taps, blur, opaque, ..Settings::plain(code.clone()) };
                if s.check().is_ok() {
                    case.check(gpu, &s);
                    checked += 1;
                }
            }
        }
    }
    assert!(checked >= 24, "{checked}");
}

#[test]
fn survivors_are_the_same_bits_in_any_order_and_another_seed_draws_others() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let case = Case::new(gpu);
    let mut reversed = case.mesh.clone();
    reversed.groups.reverse();
    let of = |mesh, seed| {
        frame(gpu, mesh, &case.receivers, SIZE, &Settings::plain(stochastic(12, seed)))
    };
    let first = of(&case.mesh, 3);
    assert_eq!(of(&reversed, 3).maps, first.maps);
    assert_ne!(of(&case.mesh, 4).maps, first.maps);
    assert_eq!(first.maps.len(), 12);
    assert_eq!(first.counters.map_bytes, u64::from(SIZE[0] * SIZE[1]) * (4 * 12 + 4));
    assert_eq!((first.counters.geometry_passes, first.counters.bytes_per_fragment), (1, 48));
}

#[test]
fn one_pass_adds_all_numbers_and_empty_rays_are_lit() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let case = Case::new(gpu);
    for (code, passes, textures, numbers) in [
        (fourier(15, false, Format::F32), 1, 8, 31),
        (fourier(3, true, Format::F32), 2, 2, 7),
        (power_moments(6, false, Format::F16), 1, 2, 7),
        (power_moments(4, true, Format::F32), 2, 2, 5),
    ] {
        let s = Settings::plain(code);
        let drawn = frame(gpu, &case.mesh, &case.receivers, SIZE, &s);
        assert_eq!(drawn.counters.geometry_passes, passes, "{s:?}");
        let texel = if matches!(s.code, Code::Moments(Moments { format: Format::F16, .. })) {
            8
        } else {
            16
        };
        assert_eq!(drawn.counters.bytes_per_fragment, textures * texel, "{s:?}");
        assert_eq!(drawn.maps.len(), numbers);
        assert_eq!(drawn.bounds.is_empty(), passes == 1);
        let empty = frame(gpu, &LightSpaceMesh::default(), &case.receivers, SIZE, &s);
        assert!(empty.transmittances.iter().all(|&t| t == 1.0), "{s:?}");
    }
    for code in [Code::Binary, stochastic(4, 0)] {
        let s = Settings::plain(code);
        let empty = frame(gpu, &LightSpaceMesh::default(), &case.receivers, SIZE, &s);
        assert!(empty.transmittances.iter().all(|&t| t == 1.0), "{s:?}");
    }
}

#[test]
fn codes_of_ordered_nodes_have_no_graphics_form_and_faults_are_of_layers() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let mesh = foliage(1, 5);
    for (code, word) in [
        (Code::Adaptive(Adaptive { nodes: 8, order: Order::Drawn }), "adaptive"),
        (Code::Deep(Deep { tolerance: 0.01, nodes: 16 }), "deep shadow map"),
    ] {
        let refused = Renderer::new(gpu, &mesh, MODEL, &[], [8, 8], &Settings::plain(code));
        let text = refused.unwrap_err().to_string();
        assert!(text.contains(word) && text.contains("no graphics form"), "{text}");
    }
    let s = Settings::plain(Code::Binary);
    let refused = Renderer::with_fault(gpu, &mesh, MODEL, &[], [8, 8], &s, Fault::DepthTested);
    assert!(refused.unwrap_err().to_string().contains("only layers"));
}
