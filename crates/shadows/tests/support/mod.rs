//! Maps, receivers and settings that the tests share.
#![allow(dead_code, reason = "each test file uses its own part")]

use dapple_shadows::filtering::{
    DepthMap, Estimator, Format, KernelShape, Lookup, Receiver, Settings,
};
use proptest::test_runner::Config;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// 32 cases unless PROPTEST_CASES says otherwise.
pub fn cases() -> Config {
    let asked = std::env::var("PROPTEST_CASES").ok().and_then(|n| n.parse().ok());
    Config { cases: asked.unwrap_or(32), failure_persistence: None, ..Config::default() }
}

pub fn rng(seed: u64) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(seed)
}

/// Every estimator and variant, and percentage-closer filtering with fewer taps.
pub fn estimators() -> Vec<Estimator> {
    [Estimator::every(), vec![Estimator::Pcf { taps: 3 }]].concat()
}

/// Every estimator in every format that can hold it, with the format's defaults.
pub fn all_settings() -> Vec<Settings> {
    let mut all = Vec::new();
    for estimator in estimators() {
        for format in [Format::F32, Format::F16, Format::U16] {
            let settings = Settings::new(estimator).with_format(format);
            if settings.check(16, 16).is_ok() {
                all.push(settings);
            }
        }
    }
    all
}

pub fn map(width: u32, height: u32, depth: impl Fn(u32, u32) -> f32) -> DepthMap {
    let depths = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    DepthMap { width, height, depths: depths.map(|(x, y)| depth(x, y)).collect() }
}

/// Independent uniform depths: the hardest input for any statistic.
pub fn noise(width: u32, height: u32, seed: u64) -> DepthMap {
    let mut rng = rng(seed);
    let depths = (0..width * height).map(|_| rng.random::<f32>()).collect();
    DepthMap { width, height, depths }
}

/// A sloped floor with blocks on it and a border of empty texels.
pub fn blocks(width: u32, height: u32, seed: u64) -> DepthMap {
    let mut rng = rng(seed);
    let mut map = map(width, height, |x, y| {
        if x == 0 || y == 0 { 1.0 } else { 0.6 + 0.2 * x as f32 / width as f32 }
    });
    for _ in 0..12 {
        let (x0, y0) = (rng.random_range(0..width), rng.random_range(0..height));
        let depth = rng.random_range(0.05..0.6f32);
        for y in y0..(y0 + 6).min(height) {
            for x in x0..(x0 + 6).min(width) {
                map.depths[(y * width + x) as usize] = depth;
            }
        }
    }
    map
}

/// Receivers all over the map and a little beyond, half of them at stored depths, some sloped.
pub fn receivers(map: &DepthMap, count: usize, seed: u64) -> Vec<Receiver> {
    let mut rng = rng(seed);
    (0..count)
        .map(|i| {
            let (u, v) = (rng.random_range(-0.02..1.02f32), rng.random_range(-0.02..1.02f32));
            let z = if i % 2 == 0 {
                rng.random::<f32>()
            } else {
                map.depths[rng.random_range(0..map.depths.len())] + 0.01
            };
            let slope = if i % 4 < 2 { 0.0 } else { rng.random_range(-1.0..1.0f32) };
            Receiver::new(u, v, z).with_slope(slope, -0.5 * slope)
        })
        .collect()
}

pub const KERNELS: [KernelShape; 2] = [KernelShape::Box, KernelShape::Gaussian];
pub const LOOKUPS: [Lookup; 2] = [Lookup::Nearest, Lookup::Bilinear];
