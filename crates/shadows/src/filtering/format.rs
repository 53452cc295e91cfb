//! Rounding to the storage formats.

use half::f16;

use super::Format;

impl Format {
    /// The nearest value of the format, from f64. Half floats round to nearest even, integers
    /// `floor(65535 x + 1/2)` after clamping to 0..=1.
    #[must_use]
    pub fn round(self, value: f64) -> f64 {
        match self {
            Self::F16 => f16::from_f64(value).to_f64(),
            Self::F32 => f64::from(value as f32),
            Self::U16 => (value.clamp(0.0, 1.0) * 65_535.0 + 0.5).floor() / 65_535.0,
        }
    }

    /// The nearest value of the format, from f32.
    #[inline]
    #[must_use]
    pub fn round_f32(self, value: f32) -> f32 {
        match self {
            Self::F16 => f16::from_f32(value).to_f32(),
            Self::F32 => value,
            Self::U16 => (value.clamp(0.0, 1.0) * 65_535.0 + 0.5).floor() / 65_535.0,
        }
    }

    /// How far a filtered value may move when the result of the pass between is rounded too.
    ///
    /// Integers: half a step from the pass between, and two roundings to the same grid of numbers
    /// half a step apart end at most one step apart. Half floats: half a step of 2^-10 relative
    /// (rows may lie in a higher binade than their mean), and half a step for either rounding.
    /// Floats: nothing beside their arithmetic.
    #[must_use]
    pub fn pass_error(self, value: f64) -> f64 {
        match self {
            Self::F16 => 1.5 * value.abs() / 1024.0 + 2.0f64.powi(-24),
            Self::F32 => 0.0,
            Self::U16 => 1.0 / 65_535.0,
        }
    }

    /// Depth range that counts as one depth: two steps of the format below 1 (integers), between
    /// 1/2 and 1 (half floats: 2^-11 each), or 16 of them for floats (2^-24 each), whose filtered
    /// means carry rounding of their own.
    #[must_use]
    pub fn degenerate_range(self) -> f32 {
        match self {
            Self::F16 => 1.0 / 1024.0,
            Self::F32 => 1.0 / 1_048_576.0,
            Self::U16 => 2.0 / 65_535.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_round_to_nearest_even() {
        // Steps of 2^-11 between 1/2 and 1: a tie goes to the even neighbour.
        let step = 2.0f64.powi(-11);
        assert_eq!(Format::F16.round(0.5 + 0.5 * step), 0.5);
        assert_eq!(Format::F16.round(0.5 + 1.5 * step), 0.5 + 2.0 * step);
        assert_eq!(Format::F16.round_f32(0.5 + 0.5 * step as f32), 0.5);
        assert_eq!(Format::F16.round_f32(70_000.0), f32::INFINITY);
    }

    #[test]
    fn integers_hold_both_ends_and_refuse_the_rest() {
        assert_eq!(Format::U16.round(1.0), 1.0);
        assert_eq!(Format::U16.round_f32(1.7), 1.0);
        assert_eq!(Format::U16.round(-0.2), 0.0);
        assert_eq!(Format::U16.round(1.4 / 65_535.0), 1.0 / 65_535.0);
    }

    #[test]
    fn floats_are_kept() {
        assert_eq!(Format::F32.round(0.1), f64::from(0.1f32));
        assert_eq!(Format::F32.round_f32(0.1), 0.1);
    }
}
