//! The oracle for ports: f64, brute-force two-dimensional windows, one receiver at a time.
//!
//! Packed channels are rounded to the format, filtered in f64 over the whole window at once, and
//! rounded to the format again; nothing else is rounded, except that the looked-up texel and the
//! compared depth are f32 as in every form (`lookup`). Cost: width squared per receiver and
//! corner; never timed.

use rayon::prelude::*;

#[cfg(doc)]
use super::Format;
use super::channels::{Channels, MAX_READ, Reduction};
use super::estimators::{exponential, gaussian, step};
use super::faults::Fault;
use super::kernel::Kernel;
use super::lookup::{Footprint, biased_depth, slopes};
use super::{DepthMap, Estimator, FilterError, Receiver, Settings};

/// Visibility in 0..=1 of every receiver, in order; 1 for those outside the map.
///
/// # Errors
/// Whatever [`Settings::check`] and [`DepthMap::check`] refuse.
pub fn visibility(
    map: &DepthMap,
    receivers: &[Receiver],
    settings: &Settings,
) -> Result<Vec<f64>, FilterError> {
    evaluate(map, receivers, settings, None)
}

/// Allowance of [`port_bounds`] for arithmetic that no stored value shows: powers of e (their
/// argument alone is rounded by up to 88 * 2^-24) and sums of weights.
pub const PORT_SLACK: f64 = 2e-5;

/// Roundings of f32 allowed to the CPU form in [`port_bounds`].
pub const CPU_STEPS: f64 = 4.0;

/// The range in which a port's visibility of every receiver must lie.
///
/// A port rounds between the passes and computes in f32. What that may change is known for the
/// stored channels, not for the visibility: where the estimator is ill-conditioned (a variance of
/// half floats) a correct port may be anywhere. So every channel read is moved up and down by
/// `float_steps` times 2^-23 of its value and by [`Format::pass_error`], and the range is that of
/// the visibilities so reached, widened by [`PORT_SLACK`]. For `Hard` and `Pcf` with `plane_bias`
/// the compared plane is moved by `float_steps` times 2^-23 instead.
///
/// # Errors
/// As [`visibility`].
pub fn port_bounds(
    map: &DepthMap,
    receivers: &[Receiver],
    settings: &Settings,
    float_steps: f64,
) -> Result<Vec<(f64, f64)>, FilterError> {
    let oracle = Oracle::new(map, settings, None)?;
    let bounds = |receiver: &Receiver| {
        let (low, high) = if !receiver.in_map() {
            return (1.0, 1.0);
        } else if settings.prefiltered() {
            oracle.reachable(receiver, float_steps)
        } else {
            let nudge =
                if settings.plane_bias { float_steps * f64::from(f32::EPSILON) } else { 0.0 };
            let filtered = |nudge| oracle.closer_filtered(receiver, nudge);
            (filtered(nudge), filtered(-nudge))
        };
        (low - PORT_SLACK, high + PORT_SLACK)
    };
    Ok(receivers.par_iter().map(bounds).collect())
}

pub(super) fn evaluate(
    map: &DepthMap,
    receivers: &[Receiver],
    settings: &Settings,
    fault: Option<Fault>,
) -> Result<Vec<f64>, FilterError> {
    let oracle = Oracle::new(map, settings, fault)?;
    let shade = |receiver: &Receiver| {
        let receiver = match fault {
            Some(Fault::ClampedReceiver) => &moved_inside(receiver),
            _ => receiver,
        };
        if !receiver.in_map() {
            1.0
        } else if settings.prefiltered() {
            oracle.prefiltered(receiver)
        } else {
            oracle.closer_filtered(receiver, 0.0)
        }
    };
    Ok(receivers.par_iter().map(shade).collect())
}

fn moved_inside(receiver: &Receiver) -> Receiver {
    let inside = |x: f32| if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) };
    Receiver { u: inside(receiver.u), v: inside(receiver.v), ..*receiver }
}

struct Oracle<'a> {
    map: &'a DepthMap,
    settings: &'a Settings,
    kernel: Kernel,
    /// Of percentage-closer filtering, along one axis.
    taps: Vec<(i32, f64)>,
    channels: Channels,
    /// Packed and rounded, a plane a channel.
    planes: Vec<Vec<f64>>,
    fault: Option<Fault>,
}

impl<'a> Oracle<'a> {
    fn new(
        map: &'a DepthMap,
        settings: &'a Settings,
        fault: Option<Fault>,
    ) -> Result<Self, FilterError> {
        settings.check(map.width, map.height)?;
        map.check()?;
        let kernel = Kernel::of(settings);
        let taps = match settings.estimator {
            Estimator::Pcf { taps } => kernel.taps(taps),
            _ => kernel.taps(0),
        };
        let channels = Channels::new(settings, map);
        let pack = |channel: usize| {
            let packed = map.depths.iter().map(|&z| channels.pack(channel, f64::from(z)));
            packed.map(|x| settings.format.round(x)).collect::<Vec<f64>>()
        };
        let planes = (0..settings.channel_count() as usize).map(pack).collect();
        Ok(Self { map, settings, kernel, taps, channels, planes, fault })
    }

    /// Index of the texel at an offset, the border repeated.
    fn texel(&self, x: u32, y: u32, dx: i32, dy: i32) -> usize {
        let shift = i64::from(self.fault == Some(Fault::WindowOffByOne));
        let clamp = |at: u32, by: i32, side: u32| {
            (i64::from(at) + i64::from(by) - shift).clamp(0, i64::from(side) - 1) as usize
        };
        clamp(y, dy, self.map.height) * self.map.width as usize + clamp(x, dx, self.map.width)
    }

    /// Mean of the comparisons over the window, blended over the footprint; `nudge` (depth) moves
    /// the receiver away from the light.
    fn closer_filtered(&self, receiver: &Receiver, nudge: f64) -> f64 {
        let (width, height) = (self.map.width, self.map.height);
        let z = self.biased_depth(receiver) + nudge;
        let (du, dv) = if self.settings.plane_bias { slopes(receiver) } else { (0.0, 0.0) };
        let (u, v) = (f64::from(receiver.u), f64::from(receiver.v));
        let mut sum = 0.0;
        for ((x, y), share) in self.footprint(receiver).corners() {
            for &(dy, wy) in &self.taps {
                for &(dx, wx) in &self.taps {
                    let texel = self.texel(x, y, dx, dy);
                    let tu = ((texel % width as usize) as f64 + 0.5) / f64::from(width);
                    let tv = ((texel / width as usize) as f64 + 0.5) / f64::from(height);
                    let plane = z + f64::from(du) * (tu - u) + f64::from(dv) * (tv - v);
                    let lit = step::visibility(self.planes[0][texel], plane);
                    sum += f64::from(share) * wx * wy * lit;
                }
            }
        }
        sum.clamp(0.0, 1.0)
    }

    /// Channels filtered, rounded and blended over the footprint; unused places stay 0.
    fn stats(&self, receiver: &Receiver, z: f64) -> [f64; MAX_READ] {
        let corners = self.footprint(receiver).corners();
        let mut stats = [0.0; MAX_READ];
        for (stat, channel) in stats.iter_mut().zip(self.channels.read(z)) {
            let values = corners.map(|((x, y), share)| {
                let filtered = self.window(channel, x, y);
                (f64::from(share), self.settings.format.round(filtered))
            });
            let linear = self.fault == Some(Fault::BilinearMinMax);
            *stat = if linear {
                values.iter().map(|(share, value)| share * value).sum()
            } else {
                self.channels.blend(channel, values)
            };
        }
        stats
    }

    fn biased_depth(&self, receiver: &Receiver) -> f64 {
        let (width, height) = (self.map.width, self.map.height);
        f64::from(biased_depth(receiver, self.settings, width, height))
    }

    /// Smallest and largest visibility with every channel moved by its rounding.
    fn reachable(&self, receiver: &Receiver, float_steps: f64) -> (f64, f64) {
        let z = self.biased_depth(receiver);
        let stats = self.stats(receiver, z);
        let read = self.channels.per_layer();
        let format = self.settings.format;
        // Odd moments pass through 0 but are summed from values up to 1.
        let magnitude = |x: f64| if self.settings.estimator == Estimator::Msm { 1.0 } else { x };
        let moves = stats.map(|x| {
            let size = magnitude(x).abs();
            format.pass_error(size) + float_steps * f64::from(f32::EPSILON) * size
        });
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        // Every channel down, kept and up, in all combinations.
        for combination in 0..3usize.pow(read as u32) {
            let moved = std::array::from_fn(|channel| {
                let digit = combination / 3usize.pow(channel.min(read) as u32) % 3;
                stats[channel] + (digit as f64 - 1.0) * moves[channel]
            });
            let v = self.channels.visibility(&moved, z);
            (low, high) = (low.min(v), high.max(v));
        }
        (low, high)
    }

    fn prefiltered(&self, receiver: &Receiver) -> f64 {
        let z = self.biased_depth(receiver);
        let mut stats = self.stats(receiver, z);
        let s = self.settings;
        match (self.fault, s.estimator) {
            (Some(Fault::PrintedErf), Estimator::GaussianCdf) => {
                gaussian::visibility_printed(stats[0], stats[1], z, f64::from(s.min_variance))
            }
            (Some(Fault::MeanBeforeSquare), Estimator::GaussianCdf | Estimator::Vsm { .. }) => {
                stats[1] = stats[0] * stats[0];
                self.channels.visibility(&stats, z)
            }
            _ => self.channels.visibility(&stats, z),
        }
    }

    fn footprint(&self, receiver: &Receiver) -> Footprint {
        Footprint::new(receiver, self.settings.lookup, self.map.width, self.map.height)
    }

    /// One channel reduced over the window around a texel.
    fn window(&self, channel: usize, x: u32, y: u32) -> f64 {
        let radius = self.kernel.radius() as i32;
        let weights = self.kernel.weights();
        let plane = &self.planes[channel];
        let texels = (0..weights.len() * weights.len()).map(|i| {
            let (row, column) = (i / weights.len(), i % weights.len());
            let texel = self.texel(x, y, column as i32 - radius, row as i32 - radius);
            (weights[row] * weights[column], plane[texel])
        });
        match self.channels.reduction(channel) {
            Reduction::Mean => texels.map(|(weight, value)| weight * value).sum(),
            Reduction::LogMean => exponential::log_mean(texels, f64::from(self.settings.exponent)),
            Reduction::Min => texels.fold(f64::INFINITY, |min, (_, value)| min.min(value)),
            Reduction::Max => texels.fold(f64::NEG_INFINITY, |max, (_, value)| max.max(value)),
        }
    }
}
