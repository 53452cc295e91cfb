//! Rounding to the storage formats.

use half::f16;

use super::Format;

/// The 16-bit code of a value clamped to 0..=1.
#[inline]
fn integer_code(value: f64) -> u16 {
    // The cast floors what is not negative.
    (value.clamp(0.0, 1.0) * 65_535.0 + 0.5) as u16
}

/// What a code reads back as.
#[inline]
fn integer_value(code: u16) -> f32 {
    f32::from(code) / 65_535.0
}

impl Format {
    /// The nearest value of the format, from f64. Half floats round to nearest even, integers
    /// to the code `floor(65535 x + 1/2)` after clamping to 0..=1, which reads back as the f32
    /// nearest to `code / 65535` in every form, this one included: a comparison with a depth
    /// decides on it.
    #[must_use]
    pub fn round(self, value: f64) -> f64 {
        match self {
            Self::F16 => f16::from_f64(value).to_f64(),
            Self::F32 => f64::from(value as f32),
            Self::U16 => f64::from(integer_value(integer_code(value))),
        }
    }

    /// The nearest value of the format, from f32: the same as [`Format::round`] of that value.
    #[inline]
    #[must_use]
    pub fn round_f32(self, value: f32) -> f32 {
        match self {
            Self::F16 => f16::from_f32(value).to_f32(),
            Self::F32 => value,
            // In f64, where 65535 x + 1/2 of an f32 is exact: in f32 the product alone moves
            // depths across a step's border.
            Self::U16 => integer_value(integer_code(f64::from(value))),
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
        assert_eq!(Format::U16.round(1.4 / 65_535.0), f64::from(1.0f32 / 65_535.0));
    }

    /// `floor(65535 x + 1/2)` in whole numbers, for 0 <= x <= 1.
    fn exact_code(x: f32) -> u32 {
        let bits = x.to_bits();
        let (exponent, fraction) = (bits >> 23, u128::from(bits & 0x7f_ffff));
        let significand = if exponent == 0 { fraction } else { fraction | 0x80_0000 };
        // x = significand * 2^(exponent - 150), so (2 * 65535 x + 1) / 2 over 2^(150 - exponent).
        let down = 150 - exponent.max(1);
        if down > 100 {
            return 0;
        }
        ((2 * 65_535 * significand + (1 << down)) >> (down + 1)) as u32
    }

    #[test]
    fn integers_round_exactly_on_both_sides_of_every_border() {
        assert_eq!([0.0, 1.0, 0.5, 7.4e-6, 7.7e-6].map(exact_code), [0, 65_535, 32_768, 0, 1]);
        let mut naive_is_wrong = 0;
        for code in 0..65_536u32 {
            let border = ((f64::from(code) + 0.5) / 65_535.0) as f32;
            let at = (f64::from(code) / 65_535.0) as f32;
            for x in [at, border] {
                for x in [x.next_down(), x, x.next_up()] {
                    let x = x.clamp(0.0, 1.0);
                    let expected = exact_code(x) as f32 / 65_535.0;
                    assert_eq!(Format::U16.round_f32(x), expected, "{x:e}");
                    assert_eq!(Format::U16.round(f64::from(x)), f64::from(expected), "{x:e}");
                    let naive = (x * 65_535.0 + 0.5).floor() / 65_535.0;
                    naive_is_wrong += u32::from(naive != expected);
                }
            }
        }
        assert!(naive_is_wrong > 1000, "{naive_is_wrong}: these inputs show nothing");
    }

    #[test]
    fn floats_are_kept() {
        assert_eq!(Format::F32.round(0.1), f64::from(0.1f32));
        assert_eq!(Format::F32.round_f32(0.1), 0.1);
    }
}
