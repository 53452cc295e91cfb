//! How wrong a shadow image is: every metric that the problem declares.

use crate::SuiteError;
use dapple_metrics::{
    MetricError, flip_gray_mean, leak_energy, loss_energy, max_abs, percentile_abs, rmse, ssim,
};
use std::collections::BTreeMap;

/// A shadow image and its truth, one value a pixel.
pub struct Compared<'a> {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The technique's visibilities.
    pub result: &'a [f32],
    /// Ground truth.
    pub truth: &'a [f32],
    /// Which pixels are lit-facing receivers.
    pub mask: &'a [bool],
}

impl Compared<'_> {
    /// Errors by metric name. A metric without a pixel to measure (no pixel in full shadow, say)
    /// is left out.
    ///
    /// # Errors
    /// A value that is not finite.
    pub fn errors(&self) -> Result<BTreeMap<String, f64>, SuiteError> {
        let (a, b, mask) = (self.result, self.truth, Some(self.mask));
        let (result, truth) = (self.image(a), self.image(b));
        let (w, h) = (self.width, self.height);
        let figures = [
            ("rmse", rmse(a, b, mask)),
            ("p99", percentile_abs(a, b, 0.99, mask)),
            ("max", max_abs(a, b, mask)),
            ("flip", flip_gray_mean(w, h, &result, &truth)),
            ("ssim_loss", ssim(w, h, &result, &truth).map(|s| 1.0 - s)),
            ("leak", leak_energy(a, b, mask)),
            ("dark", loss_energy(a, b, mask)),
        ];
        let mut errors = BTreeMap::new();
        for (name, figure) in figures {
            match figure {
                Ok(value) => {
                    errors.insert(name.to_string(), value);
                }
                Err(MetricError::Empty) => {}
                Err(error) => return Err(error.into()),
            }
        }
        Ok(errors)
    }

    /// As shown to people: background 1 (nothing there), surfaces that face away 0 are in both
    /// images alike, so that they add no error.
    fn image(&self, values: &[f32]) -> Vec<f32> {
        let shown =
            |((value, truth), mask): ((&f32, &f32), &bool)| if *mask { *value } else { *truth };
        values.iter().zip(self.truth).zip(self.mask).map(shown).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_receivers_count_and_figures_are_those_of_hand() {
        let mask = [[true; 32], [false; 32]].concat();
        let truth = [[0.0; 16], [1.0; 16], [1.0; 16], [0.0; 16]].concat();
        let mut result = truth.clone();
        result[0] = 0.5;
        result[16] = 0.0;
        result[63] = 1.0; // Not a receiver.
        let c = Compared { width: 8, height: 8, result: &result, truth: &truth, mask: &mask };
        let e = c.errors().unwrap();
        let close = |name: &str, value: f64| {
            assert!((e[name] - value).abs() < 1e-12, "{name} {}", e[name]);
        };
        close("rmse", (1.25_f64 / 32.0).sqrt());
        close("max", 1.0);
        close("leak", 0.5 / 16.0);
        close("dark", 1.0 / 16.0);
        assert!(e["flip"] > 0.0 && e["ssim_loss"] > 0.0);
    }

    #[test]
    fn a_scene_without_full_shadow_has_no_leak_figure_and_nan_is_refused() {
        let (truth, mut result, mask) = ([1.0; 64], [1.0; 64], [true; 64]);
        let c = Compared { width: 8, height: 8, result: &result, truth: &truth, mask: &mask };
        let e = c.errors().unwrap();
        assert!(!e.contains_key("leak") && e["rmse"] == 0.0 && e["flip"] == 0.0);
        result[5] = f32::NAN;
        let c = Compared { width: 8, height: 8, result: &result, truth: &truth, mask: &mask };
        assert!(c.errors().is_err());
    }
}
