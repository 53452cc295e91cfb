//! The GPU form against the reference, stage by stage: filtered channels, then visibilities.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod gpu_support;

use dapple_gpu::{Gpu, GpuError};
use dapple_shadows::filtering::faults::{self, Fault};
use dapple_shadows::filtering::gpu::{DepthSource, Filter, GpuFilterError};
use dapple_shadows::filtering::{
    DepthMap, EsmSpace, Estimator, EvsmComponents, FilterError, Format, KernelShape, Lookup,
    Receiver, Settings, Splits, VsmVariant, reference,
};
use gpu_support::{
    EVALUATION, Exact, KINDS, Kind, exclusive_gpu, formats, map, prefiltered, receivers, strangers,
};

struct Run {
    channels: Vec<Vec<f32>>,
    visibilities: Vec<f32>,
    passes: Vec<&'static str>,
}

fn run(gpu: &Gpu, map: &DepthMap, receivers: &[Receiver], s: &Settings) -> Run {
    let filter = Filter::new(gpu, map.width, map.height, receivers, s).unwrap();
    filter.upload_depths(gpu, map).unwrap();
    let mut frame = gpu.frame();
    filter.record(&mut frame);
    let times = frame.finish().unwrap();
    gpu.check().unwrap();
    Run {
        channels: filter.read_channels(gpu).unwrap(),
        visibilities: filter.read(gpu).unwrap(),
        passes: times.passes.iter().map(|p| p.0).collect(),
    }
}

/// Errors of channels over what is allowed there: above 1 is wrong.
struct ChannelErrors {
    worst: f64,
    /// Share of the texels above 1.
    over: f64,
}

impl ChannelErrors {
    /// Whether a port may have them. In 16 bits a packed value on a tie may be rounded the other
    /// way, which moves its neighbours by up to a step more: rare, and bounded.
    fn pass(&self, format: Format) -> bool {
        match format {
            Format::F32 => self.worst <= 1.0,
            Format::F16 | Format::U16 => self.worst <= 2.0 && self.over <= TIES,
        }
    }
}

/// Largest share of 16-bit values that rounding the other way may move beyond the tolerance.
const TIES: f64 = 2e-3;

fn channel_errors(exact: &Exact, channels: &[Vec<f32>]) -> ChannelErrors {
    assert_eq!(channels.len(), exact.planes.len());
    let (mut worst, mut over, mut all) = (0.0f64, 0, 0);
    for (c, (got, want)) in channels.iter().zip(&exact.planes).enumerate() {
        assert_eq!(got.len(), want.len());
        for (&got, &want) in got.iter().zip(want) {
            assert!(!got.is_nan(), "channel {c}");
            let error = (f64::from(got) - want).abs();
            let relative = if error == 0.0 { 0.0 } else { error / exact.channel_noise(c, want) };
            worst = worst.max(relative);
            over += usize::from(relative > 1.0);
            all += 1;
        }
    }
    ChannelErrors { worst, over: f64::from(over as u32) / f64::from(all) }
}

#[test]
fn channels_match_brute_force_for_every_estimator_and_format() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let (mut checked, mut faulty) = (0, 0);
    for estimator in prefiltered() {
        for base in formats(estimator) {
            for kernel in [KernelShape::Box, KernelShape::Gaussian] {
                let s = Settings { kernel, width_texels: 9, ..base };
                let map = map(Kind::Noise, 67, 35, 7);
                let got = run(gpu, &map, &[], &s).channels;
                let errors = channel_errors(&Exact::new(&map, &s, 0), &got);
                let shifted = channel_errors(&Exact::new(&map, &s, 1), &got);
                eprintln!(
                    "{estimator:?} {:?} {kernel:?}: {:.3} of the tolerance, shifted {:.1}",
                    s.format, errors.worst, shifted.worst
                );
                assert!(errors.pass(s.format), "{s:?}: {} of the tolerance", errors.worst);
                assert!(!shifted.pass(s.format), "{s:?}: a window one texel early passes");
                checked += 1;
                faulty += 1;
            }
        }
    }
    assert!(checked >= 70 && faulty == checked, "{checked}");
}

#[test]
fn channels_match_at_every_width_and_map_size() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let (mut runs, mut seen) = (0, std::collections::BTreeSet::new());
    let estimators = [
        Estimator::PowerCdf,
        Estimator::Evsm { components: EvsmComponents::Four },
        Estimator::Esm { space: EsmSpace::Log },
        Estimator::Msm,
    ];
    for (m, (width, height)) in
        [(1, 1), (3, 5), (64, 64), (257, 129), (1030, 3), (2, 300)].into_iter().enumerate()
    {
        let kind = if width == 64 { Kind::Steps } else { Kind::Noise };
        let map = map(kind, width, height, u64::from(width));
        for (w, width_texels) in [1, 3, 5, 7, 9, 15, 17, 31, 1025, 4095].into_iter().enumerate() {
            if width_texels > 31 && width * height > 700 {
                continue;
            }
            // Every map meets every width with two of the estimators; over the maps, every
            // estimator meets every width up to 31 with both kernels.
            for i in [m + w, m + w + 2] {
                let estimator = estimators[i % 4];
                let kernel = [KernelShape::Box, KernelShape::Gaussian][(m / 2) % 2];
                let format = [Format::F32, Format::F16][(m / 2 + i / 2) % 2];
                let s = Settings::new(estimator).with_format(format);
                let s = Settings { kernel, width_texels, ..s };
                let got = run(gpu, &map, &[], &s).channels;
                let mut errors = channel_errors(&Exact::new(&map, &s, 0), &got);
                if width_texels > 31 {
                    // Sums of thousands of texels lose a few ulp more.
                    errors.worst /= 8.0;
                }
                assert!(
                    errors.pass(format),
                    "{width}x{height} {kind:?} {s:?}: {} ({} over)",
                    errors.worst,
                    errors.over
                );
                seen.insert((width_texels, i % 4, kernel == KernelShape::Box));
                runs += 1;
            }
        }
    }
    // 8 widths by 4 estimators by 2 kernels, and some of the widest.
    assert!(runs >= 100 && seen.len() >= 64, "{runs} {}", seen.len());
}

#[test]
fn integers_are_rounded_as_the_reference_rounds_them_beside_every_border() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let mut depths = Vec::new();
    for code in 0..65_536u32 {
        for place in [f64::from(code), f64::from(code) + 0.5] {
            let z = (place / 65_535.0) as f32;
            depths.extend([z.next_down(), z, z.next_up()].map(|z| z.clamp(0.0, 1.0)));
        }
    }
    let map = DepthMap { width: 768, height: 512, depths };
    let s = Settings::new(Estimator::Pcf { taps: 0 }).with_format(Format::U16);
    let got = run(gpu, &map, &[], &s).channels;
    assert_eq!((got.len(), got[0].len()), (1, 6 * 65_536));
    let wrong = got[0].iter().zip(&map.depths).filter(|(g, z)| **g != Format::U16.round_f32(**z));
    assert_eq!(wrong.count(), 0);
}

/// Receivers whose visibility lies outside what rounding allows, and those for which it allows
/// less than `width` either way.
struct Verdict {
    outside: usize,
    worst: f64,
    pinned: usize,
    all: usize,
}

fn judge(exact: &Exact, receivers: &[Receiver], got: &[f32], want: &[f64], width: f64) -> Verdict {
    let mut verdict = Verdict { outside: 0, worst: 0.0, pinned: 0, all: 0 };
    for ((r, &got), &want) in receivers.iter().zip(got).zip(want) {
        assert!((0.0..=1.0).contains(&got), "{r:?}: {got}");
        let (low, high) = exact.interval(r);
        let beyond = (low - f64::from(got)).max(f64::from(got) - high);
        verdict.outside += usize::from(beyond > EVALUATION);
        verdict.worst = verdict.worst.max(beyond);
        verdict.pinned += usize::from((want - low).max(high - want) < width);
        verdict.all += 1;
    }
    verdict
}

#[test]
fn visibilities_match_the_reference_for_every_estimator() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let mut checked = 0;
    for (e, estimator) in prefiltered().into_iter().enumerate() {
        for base in formats(estimator) {
            let (mut pinned, mut all, mut largest, mut caught) = (0, 0, 0.0f64, 0);
            for (k, kind) in KINDS.into_iter().enumerate() {
                for lookup in [Lookup::Nearest, Lookup::Bilinear] {
                    if kind != Kind::Noise && (lookup == Lookup::Nearest) == (k % 2 == 0) {
                        continue;
                    }
                    let kernel =
                        if (e + k) % 2 == 0 { KernelShape::Box } else { KernelShape::Gaussian };
                    let width_texels = [5, 3, 7, 5][k];
                    let plane_bias = k % 2 == 1;
                    let s = Settings { kernel, width_texels, lookup, plane_bias, ..base };
                    let map = map(kind, 45, 33, 3 + k as u64);
                    let receivers = receivers(&map, 300, 11 + k as u64);
                    let got = run(gpu, &map, &receivers, &s).visibilities;
                    let want = reference::visibility(&map, &receivers, &s).unwrap();
                    let exact = Exact::new(&map, &s, 0);
                    let verdict = judge(&exact, &receivers, &got, &want, 0.02);
                    let ties = if base.format == Format::F32 { 0 } else { verdict.all / 200 };
                    assert!(verdict.outside <= ties, "{kind:?} {s:?}: {} beyond", verdict.worst);
                    pinned += verdict.pinned;
                    all += verdict.all;
                    for (&got, &want) in got.iter().zip(&want) {
                        largest = largest.max((f64::from(got) - want).abs());
                    }
                    if kind != Kind::Empty {
                        let fault = Fault::WindowOffByOne;
                        let faulty = faults::visibility(&map, &receivers, &s, fault).unwrap();
                        let faulty: Vec<f32> = faulty.iter().map(|&v| v as f32).collect();
                        let verdict = judge(&exact, &receivers, &faulty, &want, 0.02);
                        assert!(
                            verdict.outside > verdict.all / 200,
                            "{kind:?} {s:?}: fault passes"
                        );
                        caught += 1;
                    }
                    checked += 1;
                }
            }
            let share = pinned as f64 / all as f64;
            eprintln!(
                "{estimator:?} {:?}: largest difference {largest:.1e}, {:.1} % pinned to 0.02",
                base.format,
                100.0 * share
            );
            assert_eq!(caught, 4);
            assert!(
                share > 0.5,
                "{estimator:?} {:?}: tolerances are too wide, {share}",
                base.format
            );
        }
    }
    assert!(checked >= 200, "{checked}");
}

/// Comparisons are exact but for the rounding of weights and sums.
const COMPARED: f64 = 3e-6;

#[test]
fn comparisons_match_the_reference() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let (mut checked, mut caught) = (0, 0);
    for (k, kind) in KINDS.into_iter().enumerate() {
        for estimator in [
            Estimator::Hard,
            Estimator::Pcf { taps: 0 },
            Estimator::Pcf { taps: 3 },
            Estimator::Pcf { taps: 4 },
        ] {
            for base in formats(estimator) {
                for lookup in [Lookup::Nearest, Lookup::Bilinear] {
                    for (w, h) in [(45, 33), (3, 5), (1, 1)] {
                        let kernel = [KernelShape::Box, KernelShape::Gaussian][k % 2];
                        // A power-of-two bias is exact in every form.
                        let s = Settings {
                            kernel,
                            width_texels: 7,
                            lookup,
                            bias: 1.0 / 1024.0,
                            ..base
                        };
                        let map = map(kind, w, h, k as u64);
                        let mut receivers = receivers(&map, 200, 5);
                        receivers.extend(strangers());
                        let got = run(gpu, &map, &receivers, &s);
                        let want = reference::visibility(&map, &receivers, &s).unwrap();
                        let fault = Fault::WindowOffByOne;
                        let faulty = faults::visibility(&map, &receivers, &s, fault).unwrap();
                        let mut differs = false;
                        for ((r, &got), (want, faulty)) in
                            receivers.iter().zip(&got.visibilities).zip(want.iter().zip(faulty))
                        {
                            let error = (f64::from(got) - want).abs();
                            assert!(error <= COMPARED, "{kind:?} {s:?} {r:?}: {got} {want}");
                            differs |= (want - faulty).abs() > COMPARED;
                        }
                        if kind != Kind::Empty && w == 45 {
                            assert!(differs, "{kind:?} {s:?}: fault passes");
                            caught += 1;
                        }
                        checked += receivers.len();
                    }
                }
            }
        }
    }
    assert!(checked >= 50_000 && caught >= 70, "{checked} {caught}");
}

#[test]
fn comparisons_with_a_slope_match_away_from_ties() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let map = map(Kind::Noise, 45, 33, 9);
    let receivers = receivers(&map, 2000, 8);
    for taps in [0, 3] {
        let mut s = Settings::new(Estimator::Pcf { taps });
        s.plane_bias = true;
        let got = run(gpu, &map, &receivers, &s).visibilities;
        let want = reference::visibility(&map, &receivers, &s).unwrap();
        let off = |flat: bool| {
            let s = Settings { plane_bias: !flat, ..s };
            let want = if flat {
                reference::visibility(&map, &receivers, &s).unwrap()
            } else {
                want.clone()
            };
            got.iter().zip(want).filter(|(g, w)| (f64::from(**g) - w).abs() > COMPARED).count()
        };
        // A depth within 1e-7 of its plane: about 64 comparisons of 1e-7 a receiver.
        assert!(off(false) <= 1, "{}", off(false));
        assert!(off(true) > 200, "the slope has no effect");
    }
}

#[test]
fn strangers_to_the_map_are_lit_in_every_estimator() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    // Everything in this map is dark.
    let map = DepthMap { width: 8, height: 8, depths: vec![0.0; 64] };
    let receivers = strangers();
    let dark = Receiver::new(0.5, 0.5, 0.99);
    assert!(receivers.len() > 10);
    for estimator in prefiltered() {
        for s in formats(estimator) {
            let mut all = receivers.clone();
            all.push(dark);
            let got = run(gpu, &map, &all, &s).visibilities;
            assert!(got[..receivers.len()].iter().all(|&v| v == 1.0), "{s:?}: {got:?}");
            assert!(got[receivers.len()] < 0.5, "{s:?}: the control is lit");
        }
    }
}

#[test]
fn receivers_beyond_the_depth_range_are_finite() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let map = map(Kind::Steps, 16, 16, 1);
    let depths = [-f32::MAX, -1e30, -1.0, -1e-6, 0.0, 1e-30, 1.0, 1.000_001, 2.0, 1e30, f32::MAX];
    let receivers: Vec<_> = depths.iter().map(|&z| Receiver::new(0.4, 0.6, z)).collect();
    for estimator in prefiltered() {
        for s in formats(estimator) {
            let got = run(gpu, &map, &receivers, &s).visibilities;
            assert!(got.iter().all(|v| (0.0..=1.0).contains(v)), "{s:?}: {got:?}");
            assert!(got.is_sorted_by(|a, b| *a >= *b - 1e-4), "{s:?}: {got:?}");
            assert!(got[0] == 1.0 && got[10] < 1e-30, "{s:?}: {got:?}");
        }
    }
}

#[test]
fn every_word_of_output_is_written() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let poison = f32::from_bits(0xa5a5_a5a5);
    let half_poison = half::f16::from_bits(0xa5a5).to_f32();
    for (width, height) in [(1, 1), (65, 9), (513, 33), (520, 65)] {
        let map = map(Kind::Noise, width, height, 2);
        let receivers = receivers(&map, 1000, 4);
        let mut settings = formats(Estimator::LayeredPower { splits: Splits::Lloyd });
        settings.extend(formats(Estimator::Vsm { variant: VsmVariant::Max }));
        for s in settings.into_iter().filter(|s| s.format != Format::U16) {
            for width_texels in [1, 31] {
                let s = Settings { width_texels, ..s };
                let got = run(gpu, &map, &receivers, &s);
                let unwritten = if s.format == Format::F32 { poison } else { half_poison };
                let left = got.channels.iter().flatten().filter(|&&x| x == unwritten).count();
                assert_eq!(left, 0, "{width}x{height} {s:?}");
                assert!(got.visibilities.iter().all(|&v| v != poison));
                assert_eq!(got.channels[0].len(), (width * height) as usize);
            }
        }
    }
    // The control: nothing is written before a frame.
    let filter = Filter::new(
        gpu,
        4,
        4,
        &[Receiver::new(0.5, 0.5, 0.5)],
        &Settings::new(Estimator::PowerCdf),
    )
    .unwrap();
    assert_eq!(filter.read(gpu).unwrap(), [poison]);
    assert!(filter.read_channels(gpu).unwrap().iter().flatten().all(|&x| x == poison));
}

#[test]
fn passes_are_named_and_frames_repeat() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let map = map(Kind::Noise, 40, 40, 2);
    let receivers = receivers(&map, 100, 4);
    let got = run(gpu, &map, &receivers, &Settings::new(Estimator::GaussianCdf));
    let compared = run(gpu, &map, &receivers, &Settings::new(Estimator::Hard));
    if gpu.abilities.timestamps {
        assert_eq!(got.passes, ["pack", "filter-x", "filter-y", "shade"]);
        assert_eq!(compared.passes, ["shade"]);
    }
    let filter =
        Filter::new(gpu, 40, 40, &receivers, &Settings::new(Estimator::GaussianCdf)).unwrap();
    filter.upload_depths(gpu, &map).unwrap();
    for _ in 0..3 {
        let mut frame = gpu.frame();
        filter.record(&mut frame);
        frame.finish().unwrap();
        assert_eq!(filter.read(gpu).unwrap(), got.visibilities);
    }
    // No receivers at all.
    assert!(run(gpu, &map, &[], &Settings::new(Estimator::Hard)).visibilities.is_empty());
}

#[test]
fn shared_depth_buffers_and_lloyd_splits_agree_with_uploads() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let map = map(Kind::Steps, 40, 40, 2);
    let receivers = receivers(&map, 200, 4);
    let s = Settings::new(Estimator::LayeredVsm { splits: Splits::Lloyd });
    let depths = gpu.upload("depths", &map.depths).unwrap();
    let source = DepthSource::Buffer(&depths);
    let filter = Filter::with_depths(gpu, 40, 40, &receivers, &s, source).unwrap();
    filter.fit_layers(gpu, &map).unwrap();
    let mut frame = gpu.frame();
    filter.record(&mut frame);
    frame.finish().unwrap();
    assert_eq!(filter.read(gpu).unwrap(), run(gpu, &map, &receivers, &s).visibilities);
    let small = gpu.upload("depths", &[1.0f32; 16]).unwrap();
    let refused = Filter::with_depths(gpu, 40, 40, &receivers, &s, DepthSource::Buffer(&small));
    assert!(matches!(refused, Err(GpuFilterError::DepthBuffer { expected: 6400, actual: 64 })));
}

#[test]
fn limits_and_bad_maps_are_refused_by_name() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let s = Settings::new(Estimator::LayeredPower { splits: Splits::Uniform });
    match Filter::new(gpu, 1 << 16, 1 << 16, &[], &s) {
        Err(GpuFilterError::Gpu(GpuError::TooLarge { limit, .. })) => {
            assert!(limit.starts_with("max_"), "{limit}");
        }
        other => panic!("{other:?}"),
    }
    match Filter::new(gpu, 1, 70_000, &[], &Settings::new(Estimator::PowerCdf)) {
        Err(GpuFilterError::Gpu(GpuError::TooLarge { limit, .. })) => {
            assert_eq!(limit, "max_compute_workgroups_per_dimension");
        }
        // A device whose limit is higher.
        Ok(_) => assert!(gpu.limits().max_compute_workgroups_per_dimension >= 70_000),
        other => panic!("{other:?}"),
    }
    let refused = Filter::new(gpu, 0, 4, &[], &s);
    assert!(matches!(refused, Err(GpuFilterError::Filter(FilterError::EmptyMap { .. }))));
    let filter = Filter::new(gpu, 4, 4, &[], &s).unwrap();
    let refused = filter.upload_depths(gpu, &map(Kind::Noise, 4, 5, 1));
    assert!(matches!(refused, Err(GpuFilterError::Filter(FilterError::MapSize { .. }))));
    let nan = DepthMap { width: 4, height: 4, depths: vec![f32::NAN; 16] };
    let refused = filter.upload_depths(gpu, &nan);
    assert!(matches!(refused, Err(GpuFilterError::Filter(FilterError::Depth { texel: 0, .. }))));
}

#[test]
fn counters_by_hand() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let receivers = [Receiver::new(0.5, 0.5, 0.5), Receiver::new(2.0, 0.5, 0.5)];
    let mut s = Settings::new(Estimator::PowerCdf).with_format(Format::F16);
    s.width_texels = 5;
    let c = Filter::new(gpu, 64, 32, &receivers, &s).unwrap().counters();
    // Two words a texel. Rows: 64 + 4 texels; columns: two strips of 16 + 4.
    assert_eq!(c.prefilter_texels, 64 * 32 + 32 * 68 + 64 * 40);
    assert_eq!(c.shade_texels, 4);
    assert_eq!(c.bytes_read, 64 * 32 * (4 + 8 + 8) + 4 * 8 + 2 * 32);
    assert_eq!(c.bytes_written, 64 * 32 * (8 + 8 + 8) + 2 * 4);
    let c = Filter::new(
        gpu,
        64,
        32,
        &receivers,
        &Settings { width_texels: 5, ..Settings::new(Estimator::Pcf { taps: 0 }) },
    )
    .unwrap()
    .counters();
    assert_eq!((c.prefilter_texels, c.shade_texels), (0, 36));
    assert_eq!(c.bytes_read, 36 * 4 + 2 * 32);
}
