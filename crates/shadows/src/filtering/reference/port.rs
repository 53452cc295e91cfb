//! How far a correct port may be from the reference, receiver by receiver.
//!
//! A port rounds between the passes and computes in f32. What that may change is known for the
//! stored channels and the depth, not for the visibility: where the estimator is ill-conditioned
//! (a variance of half floats) a correct port may be anywhere. So every channel read is moved up
//! and down by what rounding allows, and the range is that of the visibilities so reached.

use rayon::prelude::*;

use super::super::channels::{MAX_READ, Reduction};
use super::super::lookup::slopes;
use super::super::{DepthMap, EsmSpace, Estimator, FilterError, Format, Receiver, Settings};
use super::Oracle;

/// Allowance of [`port_bounds`] for arithmetic that no stored value shows: powers of e (their
/// argument alone is rounded by up to 88 * 2^-24) and sums of weights.
pub const PORT_SLACK: f64 = 2e-5;

/// Roundings of f32 allowed to the CPU form in [`port_bounds`].
pub const CPU_STEPS: f64 = 4.0;

/// Halvings of the search for the extremes within a channel's rounding: to 2^-11 of it.
const SEARCH_ROUNDS: usize = 12;

/// What a port's f32 arithmetic may move, beside the rounding of the format
/// ([`Format::pass_error`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rounding {
    /// Of a channel, as a share of its value (of 1 for moments, which pass through 0 but are
    /// summed from values up to 1).
    pub relative: f64,
    /// Of a channel, in its own unit.
    pub absolute: f64,
    /// Of the receiver's depth, normalised.
    pub depth: f64,
}

impl Rounding {
    /// So many steps of 2^-23 of a channel's value, the depth exact.
    #[must_use]
    pub fn steps(float_steps: f64) -> Self {
        Self { relative: float_steps * f64::from(f32::EPSILON), absolute: 0.0, depth: 0.0 }
    }

    /// Of the CPU form, whose sums are f64.
    #[must_use]
    pub fn cpu() -> Self {
        Self::steps(CPU_STEPS)
    }

    /// Of the GPU form. Bounded channels: two stored results of half an ulp each, as much for each
    /// division, and the sums about the pivot, which may be larger than their result: 4e-7. Warped
    /// ones: half an ulp of `c z` (3.8e-6 for 64..128), where a driver folds the split product
    /// back into one, and sums without pivot: 6e-6 of the value. Depths, also as a place in a
    /// layer: a few roundings of 6e-8.
    #[must_use]
    pub fn gpu(settings: &Settings) -> Self {
        let depth = 3e-7;
        match settings.estimator {
            Estimator::Esm { space: EsmSpace::Linear } | Estimator::Evsm { .. } => {
                Self { relative: 6e-6, absolute: f64::from(f32::MIN_POSITIVE), depth }
            }
            _ => Self { relative: 0.0, absolute: 4e-7, depth },
        }
    }
}

/// The visibility of one receiver, and the range in which a port's must lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expected {
    /// As [`visibility`](super::visibility).
    pub value: f64,
    /// Least a port may give.
    pub low: f64,
    /// Most a port may give.
    pub high: f64,
}

impl Expected {
    /// Whether a port may give this; no port may give what is not a number.
    #[must_use]
    pub fn allows(&self, visibility: f32) -> bool {
        (self.low..=self.high).contains(&f64::from(visibility))
    }
}

/// Visibility and port's range of every receiver, in order, for the cost of one
/// [`visibility`](super::visibility).
///
/// Channels read are moved by [`Format::pass_error`] and `rounding`, the depth by
/// [`Rounding::depth`]; the range is widened by [`PORT_SLACK`]. For `Hard` and `Pcf` with
/// `plane_bias` the compared plane is moved instead, by as much as its sum and its slopes round;
/// without, the comparisons are exact.
///
/// # Errors
/// As [`visibility`](super::visibility).
pub fn expected(
    map: &DepthMap,
    receivers: &[Receiver],
    settings: &Settings,
    rounding: &Rounding,
) -> Result<Vec<Expected>, FilterError> {
    let oracle = Oracle::new(map, settings, None)?;
    let expect = |receiver: &Receiver| {
        let Expected { value, low, high } = if !receiver.in_map() {
            Expected { value: 1.0, low: 1.0, high: 1.0 }
        } else if settings.prefiltered() {
            oracle.reachable(receiver, rounding)
        } else {
            oracle.tippable(receiver, rounding)
        };
        Expected { value, low: low - PORT_SLACK, high: high + PORT_SLACK }
    };
    Ok(receivers.par_iter().map(expect).collect())
}

/// The range in which a port's visibility of every receiver must lie: that of [`expected`] with
/// [`Rounding::steps`].
///
/// # Errors
/// As [`visibility`](super::visibility).
pub fn port_bounds(
    map: &DepthMap,
    receivers: &[Receiver],
    settings: &Settings,
    float_steps: f64,
) -> Result<Vec<(f64, f64)>, FilterError> {
    let expected = expected(map, receivers, settings, &Rounding::steps(float_steps))?;
    Ok(expected.into_iter().map(|e| (e.low, e.high)).collect())
}

impl Oracle<'_> {
    /// Comparisons with the plane as it is, and moved away from and towards the light.
    fn tippable(&self, receiver: &Receiver, rounding: &Rounding) -> Expected {
        let nudge = if self.settings.plane_bias {
            let (du, dv) = slopes(receiver);
            // A texel's place and the receiver's are rounded, and the slopes carry that.
            let places = f64::from(f32::EPSILON) * f64::from(du.abs() + dv.abs());
            rounding.relative + rounding.absolute + places
        } else {
            0.0
        };
        let [value, low, high] = self.closer_filtered(receiver, [0.0, nudge, -nudge]);
        Expected { value, low, high }
    }

    /// Visibility, and the smallest and largest with every channel moved by its rounding.
    fn reachable(&self, receiver: &Receiver, rounding: &Rounding) -> Expected {
        let z = self.biased_depth(receiver);
        let stats = self.stats(receiver, z);
        let value = self.channels.visibility(&stats, z);
        let mut all = Expected { value, low: value, high: value };
        self.reach(&stats, z, rounding, &mut all);
        if rounding.depth > 0.0 {
            for z_moved in [z - rounding.depth, z + rounding.depth] {
                // Another layer has other channels.
                let other = self.channels.read(z_moved) != self.channels.read(z);
                let stats = if other { self.stats(receiver, z_moved) } else { stats };
                self.reach(&stats, z_moved, rounding, &mut all);
            }
        }
        all
    }

    /// Widens a range by all that channels moved within their rounding reach: every channel down,
    /// kept and up in all combinations, then a search around the lowest and the highest so found.
    /// The extremes need not be at corners: where the variance meets its floor, a mean further up
    /// is no longer darker.
    fn reach(&self, stats: &[f64; MAX_READ], z: f64, rounding: &Rounding, all: &mut Expected) {
        let mut moves = [0.0; MAX_READ];
        for ((moved, channel), stat) in moves.iter_mut().zip(self.channels.read(z)).zip(stats) {
            *moved = self.movement(channel, *stat, rounding);
        }
        let at = |share: &[f64; MAX_READ]| {
            let moved = std::array::from_fn(|i| stats[i] + share[i] * moves[i]);
            self.channels.visibility(&moved, z)
        };
        let read = self.channels.per_layer();
        let (mut lowest, mut highest) = ([0.0; MAX_READ], [0.0; MAX_READ]);
        let (mut low, mut high) = (at(&lowest), at(&highest));
        let mut step = 1.0;
        for round in 0..SEARCH_ROUNDS {
            let (around_low, around_high) = (lowest, highest);
            for combination in 0..3usize.pow(read as u32) {
                let near = |centre: &[f64; MAX_READ]| {
                    std::array::from_fn(|i| {
                        let digit = combination / 3usize.pow(i.min(read) as u32) % 3;
                        (centre[i] + (digit as f64 - 1.0) * step).clamp(-1.0, 1.0)
                    })
                };
                for centre in [&around_low, &around_high].into_iter().take(1 + round.min(1)) {
                    let share = near(centre);
                    let v = at(&share);
                    if v < low {
                        (low, lowest) = (v, share);
                    }
                    if v > high {
                        (high, highest) = (v, share);
                    }
                }
            }
            if high - low < 0.01 * PORT_SLACK {
                break;
            }
            step *= 0.5;
        }
        (all.low, all.high) = (all.low.min(low), all.high.max(high));
    }

    /// Largest error of a channel that is read.
    fn movement(&self, channel: usize, value: f64, rounding: &Rounding) -> f64 {
        let Settings { estimator, format, .. } = *self.settings;
        let size = if estimator == Estimator::Msm { 1.0 } else { value.abs() };
        let float = rounding.absolute + rounding.relative * size;
        let extreme = matches!(self.channels.reduction(channel), Reduction::Min | Reduction::Max);
        if extreme && self.settings.splits().is_none() {
            // Rounding keeps order: the extreme of rounded depths is one of them, exactly. Only
            // k / 65535 is a division, rounded when it is read.
            return if format == Format::U16 { float } else { 0.0 };
        }
        format.pass_error(size) + float
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::VsmVariant;
    use super::super::{visibility, visibility_one_weight_off};
    use super::*;

    fn slope() -> (DepthMap, Vec<Receiver>) {
        let depths = (0..32 * 32).map(|i| 0.2 + 0.5 * ((i * 37 % 101) as f32 / 101.0)).collect();
        let receivers = (0..200)
            .map(|i| {
                let (u, v) = ((i * 7 % 200) as f32 / 200.0, (i as f32 + 0.5) / 200.0);
                Receiver::new(u, v, 0.2 + 0.5 * (i * 13 % 200) as f32 / 200.0)
            })
            .collect();
        (DepthMap { width: 32, height: 32, depths }, receivers)
    }

    #[test]
    fn the_value_is_the_reference_and_lies_within_its_range() {
        let (map, receivers) = slope();
        for estimator in [Estimator::Pcf { taps: 0 }, Estimator::PowerCdf, Estimator::Msm] {
            for format in [Format::F32, Format::U16] {
                let s = Settings::new(estimator).with_format(format);
                let values = visibility(&map, &receivers, &s).unwrap();
                for rounding in [Rounding::cpu(), Rounding::gpu(&s)] {
                    let all = expected(&map, &receivers, &s, &rounding).unwrap();
                    for (e, value) in all.iter().zip(&values) {
                        assert_eq!(e.value, *value);
                        assert!(e.low <= e.value - PORT_SLACK && e.high >= e.value + PORT_SLACK);
                        assert!(!e.allows(f32::NAN) && e.allows(e.value as f32));
                    }
                }
            }
        }
    }

    #[test]
    fn a_variance_that_meets_its_floor_within_rounding_is_darkest_there() {
        // Every receiver sees the same half of 0.25 and half of 0.25 + 2 deviations.
        let deviation = 0.012f32;
        let depths = (0..64).map(|i| 0.25 + 2.0 * deviation * (i % 2) as f32).collect();
        let map = DepthMap { width: 8, height: 8, depths };
        let s = Settings {
            width_texels: 1,
            bias: 0.0,
            min_variance: 1e-4,
            ..Settings::new(Estimator::Vsm { variant: VsmVariant::MinVariance })
        };
        let s = Settings { format: Format::F16, ..s };
        // In the middle of two texels: mean 0.262, mean square 0.262^2 + deviation^2.
        let receiver = Receiver::new(0.25, 0.1875, 0.3);
        let e = expected(&map, &[receiver], &s, &Rounding::steps(0.0)).unwrap()[0];
        // The mean square may be so low that the variance is at its floor with the mean as low as
        // it goes or further up; brute force over both.
        let half = |x: f32| Format::F16.round(f64::from(x));
        let near = f64::from(0.25f32);
        let far = half(0.25 + 2.0 * deviation);
        let mean = 0.5 * (near + far);
        let square =
            0.5 * (Format::F16.round(near * near) + half((0.25 + 2.0 * deviation).powi(2)));
        let (dm, ds) = (Format::F16.pass_error(mean), Format::F16.pass_error(square));
        let (mut low, mut high) = (1.0f64, 0.0f64);
        for i in -400..=400 {
            for j in -400..=400 {
                let m = mean + dm * f64::from(i) / 400.0;
                let variance = (square + ds * f64::from(j) / 400.0 - m * m).max(1e-4);
                let d = f64::from(0.3f32) - m;
                let v = variance / (variance + d * d);
                (low, high) = (low.min(v), high.max(v));
            }
        }
        assert!((e.low + PORT_SLACK - low).abs() < 1e-4, "{e:?} {low}");
        assert!((e.high - PORT_SLACK - high).abs() < 1e-4, "{e:?} {high}");
    }

    #[test]
    fn comparisons_of_floats_are_held_to_the_slack_alone() {
        let (map, receivers) = slope();
        let s = Settings::new(Estimator::Pcf { taps: 0 });
        for e in expected(&map, &receivers, &s, &Rounding::cpu()).unwrap() {
            assert_eq!((e.low, e.high), (e.value - PORT_SLACK, e.value + PORT_SLACK));
        }
    }

    #[test]
    fn a_weight_one_in_a_thousand_off_leaves_the_range() {
        let (map, receivers) = slope();
        for estimator in [Estimator::Pcf { taps: 0 }, Estimator::GaussianCdf, Estimator::PowerCdf] {
            let s = Settings::new(estimator);
            let all = expected(&map, &receivers, &s, &Rounding::gpu(&s)).unwrap();
            let outside = |factor| {
                let off = visibility_one_weight_off(&map, &receivers, &s, factor).unwrap();
                all.iter().zip(&off).filter(|(e, v)| !e.allows(**v as f32)).count()
            };
            assert_eq!(outside(1.0), 0);
            assert!(outside(0.999) > 20, "{estimator:?}: {}", outside(0.999));
        }
    }
}
