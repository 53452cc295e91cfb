//! Compensated summation.
//!
//! Based on: A. Neumaier, "Rundungsfehleranalyse einiger Verfahren zur Summation endlicher
//! Summen", ZAMM 54, 1974, algorithm IV (improved Kahan-Babuska).

/// Sum whose error is about one rounding of the result, for any number of terms of one sign.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sum {
    sum: f64,
    lost: f64,
}

impl Sum {
    pub(crate) fn add(&mut self, value: f64) {
        let total = self.sum + value;
        self.lost += if self.sum.abs() >= value.abs() {
            (self.sum - total) + value
        } else {
            (value - total) + self.sum
        };
        self.sum = total;
    }

    pub(crate) fn total(self) -> f64 {
        self.sum + self.lost
    }
}

impl FromIterator<f64> for Sum {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        let mut sum = Self::default();
        values.into_iter().for_each(|value| sum.add(value));
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::Sum;

    #[test]
    fn small_terms_survive_beside_a_large_one() {
        let terms = [1.0, 1e100, 1.0, -1e100];
        assert_eq!(terms.iter().sum::<f64>(), 0.0, "the plain sum is the control");
        assert_eq!(terms.into_iter().collect::<Sum>().total(), 2.0);
    }

    #[test]
    fn ten_million_tenths_are_exact_to_one_rounding() {
        let sum = std::iter::repeat_n(0.1, 10_000_000).collect::<Sum>().total();
        // The double nearest 0.1 is 0.1 + 5.55e-18; ten million of them are 1e6 + 5.55e-11.
        assert!((sum - 1e6).abs() <= 1.2e-10, "{sum}");
        let plain: f64 = std::iter::repeat_n(0.1, 10_000_000).sum();
        assert!((plain - 1e6).abs() > 1e-5, "the plain sum is the control: {plain}");
    }
}
