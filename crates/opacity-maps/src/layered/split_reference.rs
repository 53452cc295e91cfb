//! Split functions in `f64`, by definition, with their slopes and inverses.

use crate::{Split, SplitKind, layered::split};

/// log2(1 + (N - 2) t) / log2(N - 1) for any real ratio N > 2; t as N falls to 2.
pub fn logarithmic(t: f64, width: f64) -> f64 {
    // ln_1p keeps the digits as N - 2 vanishes.
    ((width - 2.0) * t).ln_1p() / (width - 2.0).ln_1p()
}

/// The mixture of layer coordinates (1 - λ) t + λ log.
pub fn hybrid(split: &Split, t: f64) -> f64 {
    let lambda = f64::from(split.lambda);
    (1.0 - lambda) * t + lambda * logarithmic(t, f64::from(split.width))
}

/// Slope of [`hybrid`] at t.
pub fn slope(split: &Split, t: f64) -> f64 {
    let (lambda, stretch) = (f64::from(split.lambda), f64::from(split.width) - 2.0);
    1.0 - lambda + lambda * stretch / ((1.0 + stretch * t) * stretch.ln_1p())
}

/// The mixture of positions (1 - λ) u + λ ((N - 1)^u - 1) / (N - 2).
pub fn mixed_position(split: &Split, u: f64) -> f64 {
    let (lambda, stretch) = (f64::from(split.lambda), f64::from(split.width) - 2.0);
    (1.0 - lambda) * u + lambda * (u * stretch.ln_1p()).exp_m1() / stretch
}

/// A split function with its table, if it has one.
#[derive(Clone, Debug)]
pub struct SplitReference {
    split: Split,
    texels: Vec<f64>,
}

impl SplitReference {
    /// Fills the table.
    pub fn new(split: &Split) -> Self {
        let at = |i: u32| hybrid(split, f64::from(i) / f64::from(split.width - 1));
        let texels = match split.kind {
            SplitKind::Normalised | SplitKind::Positions => Vec::new(),
            SplitKind::Listing => {
                split::listing_table(split).iter().map(|&byte| f64::from(byte) / 255.0).collect()
            }
            SplitKind::Table8 => {
                (0..split.width).map(|i| (255.0 * at(i)).round() / 255.0).collect()
            }
            SplitKind::Table32 => (0..split.width).map(at).collect(),
        };
        Self { split: *split, texels }
    }

    /// u = H(t), t clamped to 0..=1.
    pub fn coordinate(&self, t: f64) -> f64 {
        let t = t.clamp(0.0, 1.0);
        let width = f64::from(self.split.width);
        match self.split.kind {
            SplitKind::Normalised => hybrid(&self.split, t),
            SplitKind::Positions => bisect(|u| mixed_position(&self.split, u), t),
            // The thesis's bound on the coordinate is an `f32` too.
            SplitKind::Listing => texture(&self.texels, t.min(f64::from(0.9999f32)) * width - 0.5),
            SplitKind::Table8 | SplitKind::Table32 => texture(&self.texels, t * (width - 1.0)),
        }
    }

    /// t = H^-1(u): the least t with H(t) >= u, for u in 0..=1; mixed positions directly.
    pub fn position(&self, u: f64) -> f64 {
        match self.split.kind {
            SplitKind::Positions => mixed_position(&self.split, u),
            _ => bisect(|t| self.coordinate(t), u),
        }
    }
}

/// The x in 0..=1 at which the never falling `function` reaches `value`.
fn bisect(function: impl Fn(f64) -> f64, value: f64) -> f64 {
    if value <= 0.0 {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if function(middle) < value {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

fn texture(texels: &[f64], x: f64) -> f64 {
    let last = texels.len() - 1;
    let x = x.clamp(0.0, last as f64);
    let i = (x as usize).min(last);
    let next = texels[(i + 1).min(last)];
    texels[i] + (next - texels[i]) * x.fract()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boundaries_grow_from_0_to_1_and_match_closed_forms() {
        for kind in [SplitKind::Normalised, SplitKind::Positions, SplitKind::Table32] {
            for lambda in [0.0, 0.2, 0.5, 1.0] {
                let split = Split { lambda, kind, width: 512 };
                let reference = SplitReference::new(&split);
                for layers in [1, 2, 3, 5, 32, 33, 256] {
                    let at = |k: u32| reference.position(f64::from(k) / f64::from(layers));
                    let boundaries: Vec<f64> = (0..=layers).map(at).collect();
                    assert_eq!(boundaries[0], 0.0);
                    assert!((boundaries[layers as usize] - 1.0).abs() < 1e-12);
                    assert!(boundaries.windows(2).all(|w| w[0] < w[1]), "{split:?} {layers}");
                }
            }
        }
        let log = Split { lambda: 1.0, kind: SplitKind::Normalised, width: 512 };
        let reference = SplitReference::new(&log);
        for k in 0..=16 {
            let closed = (511f64.powf(f64::from(k) / 16.0) - 1.0) / 510.0;
            assert!((reference.position(f64::from(k) / 16.0) - closed).abs() < 1e-12);
        }
    }

    #[test]
    fn the_logarithm_tends_to_uniform_as_its_ratio_tends_to_1() {
        let worst = |width: f64| {
            let differs =
                |i| (logarithmic(f64::from(i) / 100.0, width) - f64::from(i) / 100.0).abs();
            (0..=100).map(differs).fold(0.0, f64::max)
        };
        assert!(worst(2.0 + 1e-9) < 1e-9);
        assert!(worst(2.001) < 2e-4 && worst(2.1) < 2e-2);
        assert!(worst(3.0) > 0.05);
    }

    #[test]
    fn mixing_positions_is_not_mixing_coordinates() {
        let of = |kind| Split { lambda: 0.5, kind, width: 512 };
        let coordinate = |kind| SplitReference::new(&of(kind)).coordinate(0.1);
        let mixed = coordinate(SplitKind::Positions);
        assert!((mixed - coordinate(SplitKind::Normalised)).abs() > 0.05);
        assert!((mixed_position(&of(SplitKind::Positions), mixed) - 0.1).abs() < 1e-12);
    }
}
