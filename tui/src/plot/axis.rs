//! A logarithmic axis with ticks at round numbers.

use dapple_records::text::{duration, significant};

/// Least length of an axis, decades: short enough to tell close points apart, long enough for two
/// ticks of 1, 2 and 5.
const LEAST_DECADES: f64 = 0.75;
/// Room beyond the outermost points, as a share of the length.
const MARGIN: f64 = 0.04;

/// From one positive number to another, logarithmically.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogAxis {
    /// Decimal logarithm of the lower end.
    low: f64,
    /// Decimal logarithm of the upper end.
    high: f64,
}

/// A round number: `digit` times 10 to the `exponent`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tick {
    /// 1..=9.
    pub digit: u8,
    /// Power of ten.
    pub exponent: i32,
}

impl Tick {
    /// The number.
    pub fn value(self) -> f64 {
        // Parsed rather than multiplied: 3 * 10^-1 is not 0.3.
        format!("{}e{}", self.digit, self.exponent).parse().unwrap_or(f64::NAN)
    }

    /// As a duration; the number is in nanoseconds.
    pub fn duration(self) -> String {
        // Trailing zeros say nothing: `1 ms` rather than `1.00 ms`.
        let text = duration(self.value());
        let Some((number, unit)) = text.split_once(' ') else { return text };
        format!("{} {unit}", shorter(number))
    }

    /// As a plain number, or with an exponent where that is shorter to read.
    pub fn plain(self) -> String {
        if (-3..=4).contains(&self.exponent) {
            return shorter(&significant(self.value())).to_string();
        }
        format!("{}e{}", self.digit, self.exponent)
    }
}

fn shorter(number: &str) -> &str {
    if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { number }
}

impl LogAxis {
    /// Over all positive, finite values, with a little room. `None` if there are none.
    pub fn over(values: impl Iterator<Item = f64>) -> Option<Self> {
        let logs = values.filter(|v| *v > 0.0 && v.is_finite()).map(f64::log10);
        let (low, high) =
            logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        if low > high {
            return None;
        }
        let margin = ((high - low) * MARGIN).max((LEAST_DECADES - (high - low)) / 2.0);
        Some(Self { low: low - margin, high: high + margin })
    }

    /// Where a value stands among `cells` from the lower end; `None` off the axis, for 0 and NaN.
    pub fn at(self, value: f64, cells: u16) -> Option<u16> {
        let share = (value.log10() - self.low) / (self.high - self.low);
        // NaN is in no range.
        if cells == 0 || !(0.0..=1.0).contains(&share) {
            return None;
        }
        Some((share * f64::from(cells - 1)).round() as u16)
    }

    /// The finest of: every digit, 1-2-5, decades, every second, third ... decade, that has at
    /// most `most` ticks. At least one where `most` is not 0.
    pub fn ticks(self, most: usize) -> Vec<Tick> {
        let levels: [&[u8]; 3] = [&[1, 2, 3, 4, 5, 6, 7, 8, 9], &[1, 2, 5], &[1]];
        let digits = levels.into_iter().map(|digits| self.level(digits, 1));
        let decades = (2..700).map(|step| self.level(&[1], step));
        digits.chain(decades).find(|t| (1..=most).contains(&t.len())).unwrap_or_else(|| {
            let mut few = self.level(&[1, 2, 5], 1);
            few.truncate(most);
            few
        })
    }

    fn level(self, digits: &[u8], step: i32) -> Vec<Tick> {
        let decades = self.low.floor() as i32..=self.high.floor() as i32;
        decades
            .filter(|exponent| exponent.rem_euclid(step) == 0)
            .flat_map(|exponent| digits.iter().map(move |&digit| Tick { digit, exponent }))
            .filter(|tick| {
                let log = f64::from(tick.exponent) + f64::from(tick.digit).log10();
                (self.low..=self.high).contains(&log)
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn over(values: &[f64]) -> LogAxis {
        LogAxis::over(values.iter().copied()).unwrap()
    }

    fn plain(values: &[f64], most: usize) -> Vec<String> {
        over(values).ticks(most).into_iter().map(Tick::plain).collect()
    }

    #[test]
    fn ticks_are_round_and_as_many_as_fit() {
        assert_eq!(plain(&[0.001, 0.1], 3), ["0.001", "0.01", "0.1"]);
        assert_eq!(
            plain(&[0.001, 0.1], 9),
            ["0.001", "0.002", "0.005", "0.01", "0.02", "0.05", "0.1"]
        );
        assert_eq!(plain(&[1e-12, 1e12], 5), ["1e-10", "1e-5", "1", "1e5", "1e10"]);
        assert_eq!(plain(&[1e-12, 1e12], 1), ["1"]);
        assert!(plain(&[1.0], 0).is_empty());
    }

    #[test]
    fn one_value_stands_in_the_middle_with_two_ticks_in_sight() {
        for value in [1e-300, 3e-5, 0.7, 1.0, 4.9e6, 1e300] {
            let axis = over(&[value]);
            assert_eq!(axis.at(value, 101), Some(50), "{value}");
            assert!(axis.ticks(3).len() >= 2, "{value}: {:?}", axis.ticks(3));
        }
    }

    #[test]
    fn what_has_no_logarithm_has_no_place() {
        let axis = over(&[0.0, f64::NAN, 1.0, f64::INFINITY, -3.0, 100.0]);
        assert_eq!(axis, over(&[1.0, 100.0]));
        for off in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e9] {
            assert_eq!(axis.at(off, 50), None);
        }
        assert_eq!(axis.at(10.0, 0), None);
        assert_eq!(LogAxis::over([0.0, f64::NAN].into_iter()), None);
    }

    #[test]
    fn places_rise_with_values_and_stay_within() {
        let values: Vec<f64> = (-24..=24).map(|i| 10_f64.powf(f64::from(i) / 2.0)).collect();
        let places: Vec<u16> = values.iter().map(|&v| over(&values).at(v, 100).unwrap()).collect();
        assert!(places.windows(2).all(|p| p[0] < p[1]) && places[48] < 100, "{places:?}");
    }

    #[test]
    fn labels_have_units_and_no_idle_zeros() {
        let tick = |digit, exponent| Tick { digit, exponent };
        assert_eq!(tick(1, 6).duration(), "1 ms");
        assert_eq!(tick(2, 5).duration(), "200 µs");
        assert_eq!(tick(5, 9).duration(), "5 s");
        assert_eq!(tick(3, 2).duration(), "300 ns");
        assert_eq!(tick(3, -1).plain(), "0.3");
        assert_eq!(tick(2, 3).plain(), "2000");
        assert_eq!(tick(1, 7).plain(), "1e7");
        assert_eq!(tick(1, -7).plain(), "1e-7");
    }
}
