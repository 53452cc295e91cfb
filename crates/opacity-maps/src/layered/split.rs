//! Split functions: from the depth t along a ray's bounds (0 first fragment, 1 last) to the layer
//! coordinate u, 0..=1.
//!
//! This work is based on: Voicu, Real-time volumetric shadows for dynamic rendering, MSc thesis,
//! Imperial College London, 2011, §5.2 and appendices 7 and 9; Zhang, Sun, Xu, Lun, Parallel-split
//! shadow maps for large-scale virtual environments, VRCIA 2006 (mixing positions).
//!
//! [`SplitFunction`] is the `f32` form that the processor and, line by line, the graphics device
//! run. Arithmetic and tables stay within [`PRECISION`] of the `f64` reference
//! ([`super::split_reference`]), mixed positions within [`POSITIONS_PRECISION`].

use crate::{Split, SplitKind};

/// Greatest difference of u from the `f64` reference.
pub const PRECISION: f32 = 1e-6;

/// The same where positions are mixed: the inverse is steep where layers are thin.
pub const POSITIONS_PRECISION: f32 = 2e-5;

/// Where the thesis stops, so that its texture does not wrap.
const LISTING_END: f32 = 0.9999;

/// Halvings that locate a mixed position to the last bit of an `f32` in 0..=1.
const HALVINGS: u32 = 24;

/// A split function, ready to be evaluated.
#[derive(Clone, Debug, PartialEq)]
pub struct SplitFunction {
    kind: SplitKind,
    lambda: f32,
    /// N - 2.
    stretch: f32,
    /// log2(N - 1).
    octaves: f32,
    /// Texels of the lookup texture, none for arithmetic.
    table: Vec<f32>,
}

impl SplitFunction {
    /// Fills the table, if there is one. The settings must have been checked.
    pub fn new(split: &Split) -> Self {
        let table = match split.kind {
            SplitKind::Normalised | SplitKind::Positions => Vec::new(),
            SplitKind::Listing => listing_table(split).iter().map(|&b| unorm(b)).collect(),
            SplitKind::Table8 => {
                let byte = |t| (255.0 * super::split_reference::hybrid(split, t)).round() as u8;
                steps(split.width).map(|t| unorm(byte(t))).collect()
            }
            SplitKind::Table32 => {
                let texel = |t| super::split_reference::hybrid(split, t) as f32;
                steps(split.width).map(texel).collect()
            }
        };
        Self::with_table(split, table)
    }

    /// The same with a table at hand, which may be a faulty one; texels 0..=1, as many as `width`.
    pub fn with_table(split: &Split, table: Vec<f32>) -> Self {
        let width = split.width as f32;
        Self {
            kind: split.kind,
            lambda: split.lambda,
            stretch: width - 2.0,
            octaves: (width - 1.0).log2(),
            table,
        }
    }

    /// Texels of the lookup texture, 0..=1; empty for arithmetic.
    pub fn table(&self) -> &[f32] {
        &self.table
    }

    /// u = H(t), 0..=1; t is clamped to 0..=1. Never falls as t grows.
    #[inline]
    pub fn coordinate(&self, t: f32) -> f32 {
        // Ends are exact whatever the mixture rounds to. A NaN counts as 0.
        if t >= 1.0 && self.kind != SplitKind::Listing {
            return 1.0;
        }
        let t = t.max(0.0);
        let u = match self.kind {
            SplitKind::Normalised => (1.0 - self.lambda) * t + self.lambda * self.logarithmic(t),
            SplitKind::Positions => self.of_position(t),
            SplitKind::Listing => self.texture(t.min(LISTING_END) * self.table.len() as f32 - 0.5),
            SplitKind::Table8 | SplitKind::Table32 => {
                self.texture(t * (self.table.len() as f32 - 1.0))
            }
        };
        u.min(1.0)
    }

    fn logarithmic(&self, t: f32) -> f32 {
        (1.0 + self.stretch * t).log2() / self.octaves
    }

    /// Reads the table between texels; `x` in texels, 0 at the middle of the first.
    fn texture(&self, x: f32) -> f32 {
        let Some(last) = self.table.len().checked_sub(1) else { return 0.0 };
        let x = x.clamp(0.0, last as f32);
        let i = x as usize;
        let (here, next) = (self.table[i], self.table[(i + 1).min(last)]);
        here + (next - here) * (x - i as f32)
    }

    /// The u whose mixed position is `t`.
    fn of_position(&self, t: f32) -> f32 {
        if self.lambda == 0.0 {
            return t;
        }
        if self.lambda == 1.0 {
            return self.logarithmic(t);
        }
        let (mut low, mut high) = (0.0f32, 1.0f32);
        for _ in 0..HALVINGS {
            let u = 0.5 * (low + high);
            let log = ((u * self.octaves).exp2() - 1.0) / self.stretch;
            if (1.0 - self.lambda) * u + self.lambda * log <= t {
                low = u;
            } else {
                high = u;
            }
        }
        low
    }
}

/// A byte of an 8-bit texture as it is read.
fn unorm(byte: u8) -> f32 {
    f32::from(byte) / 255.0
}

/// t at the texels of a table of `width` texels, both ends included.
fn steps(width: u32) -> impl Iterator<Item = f64> {
    (0..width).map(move |i| f64::from(i) / f64::from(width - 1))
}

/// The thesis's table (appendix 9; with λ = 1 what appendix 7 means): its exponent
/// R = floor(log2(N - 2)) is truncated, so that the curve reaches 1 before t does. Texel 0 is 0.
/// Where R would be 0 (N = 3) it is taken as 1.
pub fn listing_table(split: &Split) -> Vec<u8> {
    let end = f64::from(split.width - 1);
    let range = (end - 1.0).log2().floor().max(1.0);
    let lambda = f64::from(split.lambda);
    let texel = |i: u32| {
        if i == 0 {
            return 0;
        }
        let i = f64::from(i);
        let value = (1.0 - lambda) * i + lambda * end / range * i.log2();
        (value.min(end) * 255.0 / end) as u8
    };
    (0..split.width).map(texel).collect()
}

#[cfg(test)]
mod tests {
    use super::super::split_reference as reference;
    use super::*;

    const KINDS: [SplitKind; 5] = [
        SplitKind::Normalised,
        SplitKind::Listing,
        SplitKind::Table8,
        SplitKind::Table32,
        SplitKind::Positions,
    ];

    fn split(lambda: f32, kind: SplitKind, width: u32) -> Split {
        Split { lambda, kind, width }
    }

    /// Differences from the reference over a fine grid of t.
    fn worst(split: &Split, function: &SplitFunction) -> f64 {
        let reference = reference::SplitReference::new(split);
        let differ = |i: u32| {
            let t = i as f32 / 20_000.0;
            let expected = reference.coordinate(f64::from(t));
            (f64::from(function.coordinate(t)) - expected).abs()
        };
        (0..=20_000).map(differ).fold(0.0, f64::max)
    }

    #[test]
    fn every_kind_stays_within_its_stated_precision() {
        for kind in KINDS {
            let limit = if kind == SplitKind::Positions { POSITIONS_PRECISION } else { PRECISION };
            for lambda in [0.0, 0.1, 0.5, 0.9, 0.999, 1.0] {
                for width in [3, 4, 17, 512, 1024] {
                    let split = split(lambda, kind, width);
                    let found = worst(&split, &SplitFunction::new(&split));
                    assert!(found <= f64::from(limit), "{split:?}: {found}");
                }
            }
        }
        // Control: a function that is off by little more than the limit is seen.
        let good = split(1.0, SplitKind::Normalised, 512);
        let off = SplitFunction::new(&split(0.99999, SplitKind::Normalised, 512));
        assert!(worst(&good, &off) > f64::from(PRECISION));
    }

    #[test]
    fn the_ends_of_lambda_are_the_pure_splits_to_the_bit() {
        for kind in [SplitKind::Normalised, SplitKind::Positions] {
            let uniform = SplitFunction::new(&split(0.0, kind, 512));
            let log = SplitFunction::new(&split(1.0, kind, 512));
            for i in 0..=4096 {
                let t = i as f32 / 4096.0;
                assert_eq!(uniform.coordinate(t).to_bits(), t.to_bits());
                let expected = (1.0 + 510.0 * t).log2() / 511f32.log2();
                assert_eq!(log.coordinate(t).to_bits(), expected.to_bits());
            }
        }
    }

    #[test]
    fn functions_never_fall_and_join_0_to_1() {
        for kind in KINDS {
            for (lambda, width) in [(0.0, 512), (0.3, 3), (0.7, 16), (1.0, 512), (1.0, 1024)] {
                let function = SplitFunction::new(&split(lambda, kind, width));
                let values = (0..=10_000).map(|i| function.coordinate(i as f32 / 10_000.0));
                let values: Vec<f32> = values.collect();
                assert!(values.windows(2).all(|w| w[0] <= w[1]), "{kind:?} {lambda} {width}");
                assert_eq!((values[0], values[10_000]), (0.0, 1.0), "{kind:?} {lambda} {width}");
                assert_eq!(function.coordinate(-1.0), 0.0);
                assert_eq!(function.coordinate(2.0), 1.0);
                assert_eq!(function.coordinate(f32::NAN), 0.0);
            }
        }
    }

    #[test]
    fn the_thesis_s_table_saturates_half_way() {
        let log = split(1.0, SplitKind::Listing, 512);
        let table = listing_table(&log);
        assert_eq!(table[..6], [0, 0, 31, 50, 63, 74]);
        assert_eq!(table[256], 255);
        assert!(table[255] < 255);
        let function = SplitFunction::new(&log);
        assert_eq!(function.coordinate(0.502), 1.0);
        assert!(function.coordinate(0.49) < 1.0);
        // The normalised function does not.
        let normalised = SplitFunction::new(&split(1.0, SplitKind::Normalised, 512));
        assert!(normalised.coordinate(0.502) < 0.9);
        // Where the mixtures saturate, and how many levels they have.
        let saturates = |lambda| {
            let table = listing_table(&split(lambda, SplitKind::Listing, 512));
            let first = table.iter().position(|&b| b == 255).unwrap();
            let mut levels = table.clone();
            levels.dedup();
            (first as f64 / 511.0, levels.len())
        };
        for (lambda, at) in [(0.75, 0.77), (0.5, 0.89), (0.25, 0.96)] {
            assert!((saturates(lambda).0 - at).abs() < 0.01, "{lambda}: {:?}", saturates(lambda));
        }
        assert_eq!(saturates(0.0).1, 256);
        assert_eq!(saturates(1.0).1, 125);
    }

    #[test]
    fn tables_stay_near_arithmetic() {
        for (kind, levels) in [(SplitKind::Table8, 255.0), (SplitKind::Table32, f64::INFINITY)] {
            for width in [16, 64, 512, 1024] {
                for lambda in [0.0, 0.5, 1.0] {
                    let split = split(lambda, kind, width);
                    let function = SplitFunction::new(&split);
                    for i in 0..=5000 {
                        let t = f64::from(i) / 5000.0;
                        // The curve is concave: it is steepest at the left end of t's texel.
                        let left = (t - 1.0 / f64::from(width - 1)).max(0.0);
                        let slope = reference::slope(&split, left);
                        let found = f64::from(function.coordinate(t as f32));
                        let differs = (found - reference::hybrid(&split, t)).abs();
                        let bound = 1.0 / levels + slope / f64::from(width - 1) + 1e-6;
                        assert!(differs <= bound, "{split:?} {t}: {differs} > {bound}");
                    }
                }
            }
        }
    }
}
