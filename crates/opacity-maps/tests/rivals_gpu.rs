//! The rivals' arithmetic on a device against references in f64: what their shaders import, driven
//! by entry points of our own.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]
#![allow(clippy::print_stderr, reason = "tests say what they measured")]

use dapple_gpu::Gpu;
use dapple_gpu::testing::test_gpu;
use dapple_opacity_maps::{Format, Fragment, Moments, moments, taps::hash};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::TAU;

/// Runs `compute` of the file's text and `entry` over cases of `N` numbers; `results` numbers each.
fn run<const N: usize>(
    gpu: &Gpu,
    path: &str,
    entry: &str,
    cases: &[[u32; N]],
    results: usize,
) -> Vec<u32> {
    let text = format!(
        "{}\n@group(0) @binding(0) var<storage, read> cases: array<array<u32, {N}>>;
        @group(0) @binding(1) var<storage, read_write> results: array<u32>;
        @compute @workgroup_size(64)
        fn compute(@builtin(global_invocation_id) id: vec3<u32>) {{
            if id.x < arrayLength(&cases) {{ one(id.x); }}
        }}\n{entry}",
        dapple_shaders::source(path).unwrap()
    );
    dapple_shaders::validate(path, &text).unwrap();
    let module = gpu.module_of(path, &text).unwrap();
    let pipeline = gpu.compute_of(&module, path, "compute", &[]).unwrap();
    let input = gpu.upload("cases", cases).unwrap();
    let output = gpu.upload("results", &vec![u32::MAX; cases.len() * results]).unwrap();
    let group = gpu.bind(&pipeline, 0, &[&input, &output]);
    let mut frame = gpu.frame();
    frame.compute("cases", |pass| {
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(cases.len().div_ceil(64) as u32, 1, 1);
    });
    frame.finish().unwrap();
    gpu.check().unwrap();
    gpu.read(&output, 0, cases.len() * results).unwrap()
}

#[test]
fn harmonics_of_every_place_on_the_circle() {
    let Some(gpu) = test_gpu() else { return };
    let entry = "
        var<private> series: SeriesParams;
        @group(1) @binding(0) var bounds_map: texture_2d<f32>;
        @group(1) @binding(1) var opaque_map: texture_depth_2d;
        fn one(i: u32) {
            let first = on_circle(bitcast<f32>(cases[i][0]));
            var harmonic = first;
            for (var k = 0u; k < 15u; k++) {
                results[30u * i + 2u * k] = bitcast<u32>(harmonic.x);
                results[30u * i + 2u * k + 1u] = bitcast<u32>(harmonic.y);
                harmonic = next_harmonic(harmonic, first);
            }
        }";
    let shares: Vec<f32> = (0..=1000).map(|i| i as f32 / 1000.0).collect();
    let cases: Vec<[u32; 1]> = shares.iter().map(|share| [share.to_bits()]).collect();
    let results = run(gpu, "common/opacity_fourier.wgsl", entry, &cases, 30);
    let mut worst = [0.0f64; 2];
    for (share, found) in shares.iter().zip(results.chunks(30)) {
        for (k, pair) in (1..).zip(found.chunks(2)) {
            let angle = TAU * f64::from(k) * f64::from(*share);
            let [sin, cos] = [pair[0], pair[1]].map(|bits| f64::from(f32::from_bits(bits)));
            worst[0] = worst[0].max((sin - angle.sin()).abs()).max((cos - angle.cos()).abs());
            // Control: cosines for sines.
            worst[1] = worst[1].max((cos - angle.sin()).abs());
        }
    }
    eprintln!("harmonics: {:.1e}", worst[0]);
    assert!(worst[0] < 1e-4, "{worst:?}");
    assert!(worst[1] > 0.1);
}

/// A ray, a receiver's depth, and what the moments' settings are.
fn rays() -> Vec<(Vec<Fragment>, f32)> {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let mut rays = Vec::new();
    for i in 0..2000usize {
        // One to four depths, bunches, or any.
        let places = if i % 2 == 0 { 1 + i % 4 } else { 60 };
        let range = if i % 8 == 5 { 0.3..0.31f32 } else { 0.0..1.0 };
        let depths: Vec<f32> = (0..places).map(|_| random.random_range(range.clone())).collect();
        let count = random.random_range(1..60usize);
        let ray = (0..count).map(|k| Fragment {
            depth: depths[k % places],
            omega: random.random_range(0.0..[0.1, 0.5, 3.0f32][i % 3]),
        });
        rays.push((ray.collect(), random.random_range(0.01..1.0f32)));
    }
    rays
}

#[test]
fn shares_from_moments_of_any_ray() {
    let Some(gpu) = test_gpu() else { return };
    let entry = "
        fn one(i: u32) {
            var m: array<f32, 7>;
            for (var j = 0u; j < 7u; j++) { m[j] = bitcast<f32>(cases[i][j]); }
            let x = bitcast<f32>(cases[i][7]);
            let bias = bitcast<f32>(cases[i][8]);
            let own = bitcast<f32>(cases[i][9]);
            var share = share_from_six(m, x, bias, own);
            if cases[i][10] == 4u { share = share_from_four(m, x, bias, own); }
            results[i] = bitcast<u32>(share);
        }";
    let rays = rays();
    for (count, format) in [(4, Format::F32), (6, Format::F32), (4, Format::F16), (6, Format::F16)]
    {
        let settings =
            Moments { moments: count, bias: 0.0, overestimation: 0.7, bounded: false, format };
        let code = moments::Code { settings, opaque_in_bounds: false };
        let bias = moments::bias(&settings) as f32;
        let mut totals = Vec::new();
        let mut cases = Vec::new();
        for (ray, depth) in &rays {
            let words = encoded(&code, ray);
            let mut case = [0u32; 11];
            case[0] = 1.0f32.to_bits();
            for (j, safe) in moments::safe(count).iter().enumerate() {
                let normal = words[j + 1] / words[0];
                case[j + 1] = (normal + bias * (*safe as f32 - normal)).to_bits();
            }
            case[7] = (2.0 * depth - 1.0).to_bits();
            case[8] = bias.to_bits();
            case[9] = 0.3f32.to_bits();
            case[10] = count;
            totals.push(words[0]);
            cases.push(case);
        }
        let shares = run(gpu, "common/opacity_moments.wgsl", entry, &cases, 1);
        // The receivers of one ray at another's: a control.
        let (mut worst, mut most, mut control) = (0.0f64, 0.0f64, 0.0f64);
        for (i, (ray, depth)) in rays.iter().enumerate() {
            let share = f32::from_bits(shares[i]).clamp(0.0, 1.0);
            let t = f64::from((-totals[i] * share).exp());
            let expected = moments::reference(&settings, ray, None, false, *depth);
            let other = moments::reference(&settings, ray, None, false, (depth + 0.1).min(1.0));
            let bound = moments::port_bound(&settings, ray, None);
            worst = worst.max((t - expected).abs() / bound);
            most = most.max((t - expected).abs());
            control = control.max((t - other).abs() / bound);
        }
        eprintln!("{count} moments in {format:?}: {most:.1e}, {worst:.2} of what is allowed");
        assert!(worst <= 1.0, "{count} {format:?}: {worst}");
        assert!(control > 3.0, "{control}");
    }
}

fn encoded(code: &moments::Code, ray: &[Fragment]) -> Vec<f32> {
    use dapple_opacity_maps::code::TexelCode;
    let mut words = vec![f32::NAN; code.words()];
    code.encode(0, ray, None, &mut Vec::new(), &mut words);
    words
}

#[test]
fn random_numbers_are_the_same_bits() {
    let Some(gpu) = test_gpu() else { return };
    let entry = "fn one(i: u32) { results[i] = hash(hash(cases[i][0]) ^ cases[i][1]); }";
    let cases: Vec<[u32; 2]> = (0..5000u32)
        .map(|i| [i.wrapping_mul(0x0123_4567), (i as f32 / 5000.0).to_bits()])
        .collect();
    let found = run(gpu, "common/hash.wgsl", entry, &cases, 1);
    let expected: Vec<u32> = cases.iter().map(|[a, b]| hash(hash(*a) ^ b)).collect();
    assert_eq!(found, expected);
    assert_ne!(found[1], found[2]);
}
