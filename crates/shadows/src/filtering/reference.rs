//! The oracle for ports: f64, brute-force two-dimensional windows, one receiver at a time.
//!
//! Packed channels are rounded to the format, filtered in f64 over the whole window at once, and
//! rounded to the format again; nothing else is rounded, except that the looked-up texel and the
//! compared depth are f32 as in every form (`lookup`). Cost: width squared per receiver and
//! corner; never timed.

mod port;

use rayon::prelude::*;

pub use self::port::{CPU_STEPS, Expected, PORT_SLACK, Rounding, expected, port_bounds};
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

/// [`visibility`] with the middle weight of either axis multiplied by `factor` and nothing
/// normalised again: the least fault of a filter, for the controls of checks.
///
/// # Errors
/// As [`visibility`].
pub fn visibility_one_weight_off(
    map: &DepthMap,
    receivers: &[Receiver],
    settings: &Settings,
    factor: f64,
) -> Result<Vec<f64>, FilterError> {
    let mut oracle = Oracle::new(map, settings, None)?;
    let middle = oracle.weights.len() / 2;
    oracle.weights.iter_mut().skip(middle).take(1).for_each(|weight| *weight *= factor);
    let middle = oracle.taps.len() / 2;
    oracle.taps.iter_mut().skip(middle).take(1).for_each(|(_, weight)| *weight *= factor);
    Ok(receivers.par_iter().map(|receiver| oracle.shade(receiver)).collect())
}

pub(super) fn evaluate(
    map: &DepthMap,
    receivers: &[Receiver],
    settings: &Settings,
    fault: Option<Fault>,
) -> Result<Vec<f64>, FilterError> {
    let oracle = Oracle::new(map, settings, fault)?;
    let shade = |receiver: &Receiver| match fault {
        Some(Fault::ClampedReceiver) => oracle.shade(&moved_inside(receiver)),
        _ => oracle.shade(receiver),
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
    /// Of the window along one axis.
    weights: Vec<f64>,
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
        let weights = kernel.weights().to_vec();
        Ok(Self { map, settings, weights, taps, channels, planes, fault })
    }

    fn shade(&self, receiver: &Receiver) -> f64 {
        if !receiver.in_map() {
            1.0
        } else if self.settings.prefiltered() {
            self.prefiltered(receiver)
        } else {
            self.closer_filtered(receiver, [0.0])[0]
        }
    }

    /// Index of the texel at an offset, the border repeated.
    fn texel(&self, x: u32, y: u32, dx: i32, dy: i32) -> usize {
        let shift = i64::from(self.fault == Some(Fault::WindowOffByOne));
        let clamp = |at: u32, by: i32, side: u32| {
            (i64::from(at) + i64::from(by) - shift).clamp(0, i64::from(side) - 1) as usize
        };
        clamp(y, dy, self.map.height) * self.map.width as usize + clamp(x, dx, self.map.width)
    }

    /// Mean of the comparisons over the window, blended over the footprint, for each of the
    /// `nudges` (depth) of the receiver away from the light.
    fn closer_filtered<const N: usize>(&self, receiver: &Receiver, nudges: [f64; N]) -> [f64; N] {
        let (width, height) = (self.map.width, self.map.height);
        let z = self.biased_depth(receiver);
        let (du, dv) = if self.settings.plane_bias { slopes(receiver) } else { (0.0, 0.0) };
        let (u, v) = (f64::from(receiver.u), f64::from(receiver.v));
        let mut sums = [0.0; N];
        for ((x, y), share) in self.footprint(receiver).corners() {
            for &(dy, wy) in &self.taps {
                for &(dx, wx) in &self.taps {
                    let texel = self.texel(x, y, dx, dy);
                    let tu = ((texel % width as usize) as f64 + 0.5) / f64::from(width);
                    let tv = ((texel / width as usize) as f64 + 0.5) / f64::from(height);
                    let plane = z + f64::from(du) * (tu - u) + f64::from(dv) * (tv - v);
                    for (sum, nudge) in sums.iter_mut().zip(nudges) {
                        // The plane may run past the far plane within the window; an empty
                        // texel, of depth 1, hides nothing all the same.
                        let compared = (plane + nudge).min((z + nudge).max(1.0));
                        let lit = step::visibility(self.planes[0][texel], compared);
                        *sum += f64::from(share) * wx * wy * lit;
                    }
                }
            }
        }
        sums.map(|sum: f64| sum.clamp(0.0, 1.0))
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
        let weights = &self.weights;
        let radius = (weights.len() / 2) as i32;
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
