//! Maps, receivers, and the interval within which a port may differ from the reference.
#![allow(dead_code, reason = "each test file uses its share")]

use std::sync::{Mutex, MutexGuard, PoisonError};

use dapple_gpu::Gpu;
use dapple_gpu::testing::test_gpu;
use dapple_shadows::filtering::channels::{Channels, MAX_READ, Reduction};
use dapple_shadows::filtering::kernel::Kernel;
use dapple_shadows::filtering::lookup::{Footprint, biased_depth};
use dapple_shadows::filtering::{DepthMap, EsmSpace, Estimator, Format, Receiver, Settings};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// The adapter for one test at a time: they use both cores, and share one device.
pub fn exclusive_gpu() -> Option<(&'static Gpu, MutexGuard<'static, ()>)> {
    static ONE: Mutex<()> = Mutex::new(());
    let lock = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    test_gpu().map(|gpu| (gpu, lock))
}

pub fn rng(seed: u64) -> Pcg64 {
    Pcg64::seed_from_u64(seed)
}

/// Every pre-filtered estimator.
pub fn prefiltered() -> Vec<Estimator> {
    Estimator::every().into_iter().filter(|e| Settings::new(*e).prefiltered()).collect()
}

/// The settings of an estimator in every format that can store it.
pub fn formats(estimator: Estimator) -> Vec<Settings> {
    [Format::F32, Format::F16, Format::U16]
        .into_iter()
        .map(|format| Settings::new(estimator).with_format(format))
        .filter(|s| s.check(1, 1).is_ok())
        .collect()
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Noise,
    Steps,
    Ramp,
    Empty,
}

pub const KINDS: [Kind; 4] = [Kind::Noise, Kind::Steps, Kind::Ramp, Kind::Empty];

pub fn map(kind: Kind, width: u32, height: u32, seed: u64) -> DepthMap {
    let mut rng = rng(seed);
    let depths = (0..width * height)
        .map(|i| {
            let (x, y) = (i % width, i / width);
            match kind {
                Kind::Noise => rng.random::<f32>(),
                // Two occluders over a floor, in blocks that no window width divides.
                Kind::Steps => [0.9, 0.3, 0.9, 0.55][((x / 7 + 3 * (y / 11)) % 4) as usize],
                Kind::Ramp => {
                    0.2 + 0.6 * (x as f32 + 0.3 * y as f32) / (1.3 * width.max(height) as f32)
                }
                Kind::Empty => 1.0,
            }
        })
        .collect();
    DepthMap { width, height, depths }
}

/// Receivers all over the map, a third of them near the depths that are stored there.
pub fn receivers(map: &DepthMap, count: usize, seed: u64) -> Vec<Receiver> {
    let mut rng = rng(seed);
    (0..count)
        .map(|i| {
            let (u, v) = (rng.random::<f32>(), rng.random::<f32>());
            let x = ((u * map.width as f32) as u32).min(map.width - 1);
            let y = ((v * map.height as f32) as u32).min(map.height - 1);
            let here = map.depths[(y * map.width + x) as usize];
            let z = match i % 3 {
                0 => here + 0.1 * (rng.random::<f32>() - 0.3),
                _ => rng.random::<f32>(),
            };
            Receiver::new(u, v, z)
                .with_slope(0.4 * (rng.random::<f32>() - 0.5), 0.4 * (rng.random::<f32>() - 0.5))
        })
        .collect()
}

/// What no receiver of a map is: outside, absent or not a number. All lit.
pub fn strangers() -> Vec<Receiver> {
    let inside = Receiver::new(0.5, 0.5, 0.99);
    let mut all = vec![Receiver { valid: 0.0, ..inside }, Receiver { valid: -0.0, ..inside }];
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1e-6, 1.000_001, -f32::NAN] {
        all.push(Receiver { u: bad, ..inside });
        all.push(Receiver { v: bad, ..inside });
        if !bad.is_finite() {
            all.push(Receiver { z: bad, ..inside });
        }
    }
    all
}

/// Filtered channels in f64: packed and rounded to the format, filtered without rounding.
pub struct Exact {
    pub settings: Settings,
    pub channels: Channels,
    pub planes: Vec<Vec<f64>>,
    width: u32,
    height: u32,
}

impl Exact {
    /// `shift` 0, or 1 for the deliberate fault of a window that begins one texel early.
    pub fn new(map: &DepthMap, settings: &Settings, shift: i64) -> Self {
        let channels = Channels::new(settings, map);
        let kernel = Kernel::of(settings);
        let (w, h) = (map.width as usize, map.height as usize);
        let planes = (0..settings.channel_count() as usize)
            .map(|c| {
                let packed: Vec<f64> = map
                    .depths
                    .iter()
                    .map(|&z| settings.format.round(channels.pack(c, f64::from(z))))
                    .collect();
                let reduction = channels.reduction(c);
                let across =
                    axis(&packed, w, h, 1, w, reduction, &kernel, settings.exponent, shift);
                axis(&across, h, w, w, 1, reduction, &kernel, settings.exponent, shift)
            })
            .collect();
        Self { settings: *settings, channels, planes, width: map.width, height: map.height }
    }

    /// Largest error a port may have in a channel: for F32, two stored results of half an ulp each
    /// and the rounding of the sums; for 16 bits, the two roundings and the port's own before
    /// them (a value that is rounded the other way is a whole step off).
    pub fn channel_noise(&self, channel: usize, value: f64) -> f64 {
        let per_layer = self.channels.per_layer();
        let warped = matches!(
            self.settings.estimator,
            Estimator::Esm { space: EsmSpace::Linear } | Estimator::Evsm { .. }
        );
        let extreme = matches!(self.channels.reduction(channel), Reduction::Min | Reduction::Max);
        let unlayered = per_layer == self.planes.len();
        if extreme && unlayered {
            // Rounding keeps order: the extreme of rounded depths is one of them. k / 65535 is
            // rounded to f32 when it is read.
            return if self.settings.format == Format::U16 { 6e-8 } else { 0.0 };
        }
        match self.settings.format {
            Format::F32 if warped => F32_WARPED_NOISE * value.abs() + f64::from(f32::MIN_POSITIVE),
            Format::F32 => F32_NOISE,
            Format::U16 => 1.01 / 65_535.0 + F32_NOISE,
            // Half an ulp in each pass, 2^-11 of the value each; values below 2^-14 are stored in
            // steps of 2^-24. A pass may hold larger values than its result.
            Format::F16 if warped => 2.1 * F16_STEP * value.abs() + 2.0f64.powi(-23),
            Format::F16 => F16_STEP * 1.01,
        }
    }

    /// Statistics that a receiver reads (rounded and blended like the reference's), how far a
    /// port's may be off, and the biased depth.
    pub fn statistics(&self, r: &Receiver) -> ([f64; MAX_READ], [f64; MAX_READ], f64) {
        let z = f64::from(biased_depth(r, &self.settings, self.width, self.height));
        let corners = Footprint::new(r, self.settings.lookup, self.width, self.height).corners();
        let (mut stats, mut noise) = ([0.0; MAX_READ], [0.0; MAX_READ]);
        for (i, channel) in self.channels.read(z).enumerate() {
            let values = corners.map(|((x, y), share)| {
                let at = (y * self.width + x) as usize;
                (f64::from(share), self.settings.format.round(self.planes[channel][at]))
            });
            stats[i] = self.channels.blend(channel, values);
            noise[i] = values.iter().fold(0.0, |n: f64, v| n.max(self.channel_noise(channel, v.1)));
        }
        (stats, noise, z)
    }

    /// Smallest and largest visibility over statistics and depths as far off as a port's may be.
    pub fn interval(&self, r: &Receiver) -> (f64, f64) {
        let (stats, noise, z) = self.statistics(r);
        self.interval_of(stats, noise, z)
    }

    pub fn interval_of(
        &self,
        stats: [f64; MAX_READ],
        noise: [f64; MAX_READ],
        z: f64,
    ) -> (f64, f64) {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let levels = 3usize.pow(self.channels.per_layer() as u32);
        for code in 0..levels {
            let mut moved = stats;
            let mut digits = code;
            for i in 0..self.channels.per_layer() {
                moved[i] += noise[i] * ((digits % 3) as f64 - 1.0);
                digits /= 3;
            }
            for dz in [-DEPTH_NOISE, 0.0, DEPTH_NOISE] {
                let v = self.channels.visibility(&moved, z + dz);
                low = low.min(v);
                high = high.max(v);
            }
        }
        (low, high)
    }
}

/// Rounding of a bounded channel in f32: 6e-8 for each of two stored results, as much for each
/// division, and the sums about the pivot.
pub const F32_NOISE: f64 = 4e-7;
/// The same for warped channels, relative: half an ulp of c z (3.8e-6 for 64..128), where a driver
/// folds the split product back into one, and sums without pivot.
pub const F32_WARPED_NOISE: f64 = 6e-6;
/// 2^-11: half an ulp relative, or a whole step between 1/2 and 1.
pub const F16_STEP: f64 = 1.0 / 2048.0;
/// Rounding of a depth (and of its place in a layer) in f32.
pub const DEPTH_NOISE: f64 = 3e-7;
/// Rounding of an estimator evaluated in f32.
pub const EVALUATION: f64 = 2e-5;

#[expect(clippy::too_many_arguments, reason = "strides of the two axes")]
fn axis(
    from: &[f64],
    length: usize,
    lines: usize,
    step: usize,
    line_step: usize,
    reduction: Reduction,
    kernel: &Kernel,
    exponent: f32,
    shift: i64,
) -> Vec<f64> {
    let (radius, weights) = (kernel.radius() as i64, kernel.weights());
    let c = f64::from(exponent);
    let mut to = vec![0.0; from.len()];
    for line in 0..lines {
        for i in 0..length {
            let window = weights.iter().enumerate().map(|(k, &w)| {
                let at = (i as i64 + k as i64 - radius - shift).clamp(0, length as i64 - 1);
                (w, from[line * line_step + at as usize * step])
            });
            to[line * line_step + i * step] = match reduction {
                Reduction::Mean => window.map(|(w, x)| w * x).sum(),
                Reduction::Min => window.fold(f64::INFINITY, |m, (_, x)| m.min(x)),
                Reduction::Max => window.fold(f64::NEG_INFINITY, |m, (_, x)| m.max(x)),
                Reduction::LogMean => {
                    let most = window.clone().fold(f64::NEG_INFINITY, |m, (_, x)| m.max(x));
                    let sum: f64 = window.map(|(w, x)| w * (c * (x - most)).exp()).sum();
                    most + sum.ln() / c
                }
            };
        }
    }
    to
}
