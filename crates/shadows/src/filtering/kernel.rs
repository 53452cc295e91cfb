//! One-dimensional weights of the separable windows.

use super::{KernelShape, Settings};

/// Normalised, symmetric weights of one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Kernel {
    shape: KernelShape,
    weights: Vec<f64>,
}

impl Kernel {
    /// The kernel of a box `width_texels` (odd) wide, or of the Gaussian of the same variance:
    /// `sigma = width / sqrt(12)`, cut at `ceil(3 sigma)`.
    #[must_use]
    pub fn new(shape: KernelShape, width_texels: u32) -> Self {
        let weights = match shape {
            KernelShape::Box => {
                vec![1.0 / f64::from(width_texels.max(1)); width_texels.max(1) as usize]
            }
            KernelShape::Gaussian => gaussian(f64::from(width_texels) / 12.0f64.sqrt()),
        };
        Self { shape, weights }
    }

    /// The kernel of the settings; `Hard` looks at one texel whatever the width.
    #[must_use]
    pub fn of(settings: &Settings) -> Self {
        match settings.estimator {
            super::Estimator::Hard => Self::new(KernelShape::Box, 1),
            _ => Self::new(settings.kernel, settings.width_texels),
        }
    }

    /// Box or Gaussian.
    #[must_use]
    pub fn shape(&self) -> KernelShape {
        self.shape
    }

    /// Texels on either side of the centre.
    #[must_use]
    pub fn radius(&self) -> usize {
        self.weights.len() / 2
    }

    /// Texels of the window, `2 radius + 1`.
    #[must_use]
    pub fn support(&self) -> usize {
        self.weights.len()
    }

    /// Weights from `-radius` to `radius`; they sum to 1.
    #[must_use]
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Offsets from the centre and normalised weights that percentage-closer filtering reads
    /// along one axis: all of them for `taps` 0 or at least the support, else `taps` of them, the
    /// i-th in the middle of the i-th stratum.
    #[must_use]
    pub fn taps(&self, taps: u32) -> Vec<(i32, f64)> {
        let (support, radius) = (self.support(), self.radius() as i32);
        let count = if taps == 0 { support } else { support.min(taps as usize) };
        // floor((i + 1/2) * support / count) in whole numbers
        let place = |i: usize| (2 * i + 1) * support / (2 * count);
        let sum: f64 = (0..count).map(|i| self.weights[place(i)]).sum();
        (0..count).map(|i| (place(i) as i32 - radius, self.weights[place(i)] / sum)).collect()
    }
}

fn gaussian(sigma: f64) -> Vec<f64> {
    let radius = (3.0 * sigma).ceil() as i32;
    let weight = |i: i32| (-0.5 * (f64::from(i) / sigma).powi(2)).exp();
    let sum: f64 = (-radius..=radius).map(weight).sum();
    (-radius..=radius).map(|i| weight(i) / sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_one_and_are_symmetric() {
        for shape in [KernelShape::Box, KernelShape::Gaussian] {
            for width in [1, 3, 7, 31, 4095] {
                let kernel = Kernel::new(shape, width);
                let w = kernel.weights();
                assert!((w.iter().sum::<f64>() - 1.0).abs() < 1e-12);
                assert_eq!(w.len(), 2 * kernel.radius() + 1);
                assert!(w.iter().eq(w.iter().rev()));
            }
        }
    }

    #[test]
    fn gaussian_has_the_variance_of_the_box() {
        // width^2 / 12, less about 1.3 % for the cut at 3 sigma.
        let kernel = Kernel::new(KernelShape::Gaussian, 31);
        let r = kernel.radius() as f64;
        let variance: f64 =
            kernel.weights().iter().enumerate().map(|(i, w)| w * (i as f64 - r).powi(2)).sum();
        assert!((variance / (31.0 * 31.0 / 12.0) - 1.0).abs() < 0.03, "{variance}");
        assert_eq!(kernel.radius(), 27); // ceil(3 * 8.949)
    }

    #[test]
    fn taps_by_hand() {
        let kernel = Kernel::new(KernelShape::Box, 7);
        let offsets = |n| kernel.taps(n).iter().map(|t| t.0).collect::<Vec<_>>();
        assert_eq!(offsets(0), [-3, -2, -1, 0, 1, 2, 3]);
        assert_eq!(offsets(9), offsets(0));
        assert_eq!(offsets(1), [0]);
        assert_eq!(offsets(2), [-2, 2]); // floor(1.75), floor(5.25)
        assert_eq!(offsets(3), [-2, 0, 2]); // floor(1.17), floor(3.5), floor(5.83)
        let kernel = Kernel::new(KernelShape::Gaussian, 7);
        assert!((kernel.taps(3).iter().map(|t| t.1).sum::<f64>() - 1.0).abs() < 1e-12);
    }
}
