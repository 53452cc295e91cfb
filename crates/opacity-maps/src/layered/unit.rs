//! What the blending unit does to a stored number: the states of the thesis's table 3.3.1 in the
//! formats of [`Format`].
//!
//! A number is held as its *raw* value: codes (whole numbers) where the format is of whole numbers,
//! the value itself where it is a float, in `f64` so that both are exact. Every step ends with the
//! format's rounding.

use crate::{Blend, Format};
use half::f16;

/// Thickness that a scaled byte of 255 stands for: T = 1 / 256.
pub const SCALE: f64 = 8.0 * std::f64::consts::LN_2;

/// One unit in the last place of the fixed point: Q12.20.
pub const FIXED: f64 = 1_048_576.0;

/// Largest stored opacity that is decoded, 1 - 2^-10, as [`crate::Model::MOST_OPACITY`].
const MOST: f64 = crate::Model::MOST_OPACITY;

/// Beyond it nothing is left to tell apart, and no infinity is interpolated.
const MOST_THICKNESS: f64 = 1e30;

/// A blend state on a format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unit {
    /// The blend state.
    pub blend: Blend,
    /// The format.
    pub format: Format,
}

impl Unit {
    /// Adds a surface of thickness `omega` to a raw value; in [`Blend::Alpha`] and
    /// [`Blend::Premultiplied`] as the alpha channel does.
    #[inline]
    pub fn step(self, raw: f64, omega: f32) -> f64 {
        if self.blend == Blend::Add {
            return self.sum(raw, self.increment(omega));
        }
        let alpha = -(-f64::from(omega)).exp_m1();
        self.round(self.code(alpha) + raw * (1.0 - alpha))
    }

    /// Draws a surface into the four channels of a texture. It is added to those of `mask`; its
    /// alpha is in all of them, which is what makes [`Blend::Alpha`] and [`Blend::Premultiplied`]
    /// fail: channels that the surface does not belong to are darkened by 1 - α.
    pub fn step_group(self, raw: &mut [f64; 4], omega: f32, mask: [bool; 4]) {
        let alpha = -(-f64::from(omega)).exp_m1();
        for (channel, (value, on)) in raw.iter_mut().zip(mask).enumerate() {
            let source = match (self.blend, channel, on) {
                (Blend::Add | Blend::Over, _, _) => {
                    if on {
                        *value = self.step(*value, omega);
                    }
                    continue;
                }
                (_, 3, _) => alpha,
                (Blend::Alpha, _, true) => alpha * alpha,
                (_, _, true) => alpha,
                (_, _, false) => 0.0,
            };
            *value = self.round(self.code(source) + *value * (1.0 - alpha));
        }
    }

    /// What a surface adds to a raw value in [`Blend::Add`]: whole numbers in formats of such.
    pub fn increment(self, omega: f32) -> f64 {
        let omega = f64::from(omega);
        match self.format {
            Format::F32 | Format::F16 => omega,
            // A rounded product of 8 by 24 bits, as the unit's.
            Format::Unorm8 => f64::from((255.0 * omega) as f32).round_ties_even(),
            Format::Unorm8Scaled => f64::from((255.0 / SCALE * omega) as f32).round_ties_even(),
            Format::Fixed => (omega * FIXED).round_ties_even(),
        }
    }

    /// The sum of two raw values of [`Blend::Add`], clipped and rounded.
    pub fn sum(self, a: f64, b: f64) -> f64 {
        self.round(a + b)
    }

    /// Whether sums are the same to the bit in any order and grouping.
    pub fn is_exact(self) -> bool {
        self.blend == Blend::Add
            && matches!(self.format, Format::Unorm8 | Format::Unorm8Scaled | Format::Fixed)
    }

    /// The word that stands for a raw value: the value itself, 0..=1 in bytes.
    pub fn word(self, raw: f64) -> f32 {
        (match self.format {
            Format::F32 | Format::F16 => raw,
            Format::Unorm8 | Format::Unorm8Scaled => raw / 255.0,
            Format::Fixed => raw / FIXED,
        }) as f32
    }

    /// Thickness that a stored value (or a mean of such) stands for, >= 0.
    #[inline]
    pub fn thickness(self, value: f64) -> f64 {
        let thickness = match (self.blend, self.format) {
            (Blend::Add, Format::Unorm8Scaled) => value * SCALE,
            (Blend::Add, _) => value,
            _ => -(-value.min(MOST)).ln_1p(),
        };
        thickness.min(MOST_THICKNESS)
    }

    /// A value of 0..=1 as a raw value, unrounded.
    fn code(self, value: f64) -> f64 {
        match self.format {
            Format::F32 | Format::F16 => value,
            Format::Unorm8 | Format::Unorm8Scaled => value * 255.0,
            Format::Fixed => value * FIXED,
        }
    }

    fn round(self, raw: f64) -> f64 {
        match self.format {
            Format::F32 => f64::from(raw as f32),
            Format::F16 => f64::from(f16::from_f32(raw as f32)),
            Format::Unorm8 | Format::Unorm8Scaled => raw.round_ties_even().min(255.0),
            Format::Fixed => raw.round_ties_even().min(f64::from(u32::MAX)),
        }
    }
}

/// Bytes of a channel.
pub fn bytes(format: Format) -> u64 {
    match format {
        Format::F32 | Format::Fixed => 4,
        Format::F16 => 2,
        Format::Unorm8 | Format::Unorm8Scaled => 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Thickness after `count` surfaces of `omega` each.
    fn after(unit: Unit, omega: f32, count: u32) -> f64 {
        let raw = (0..count).fold(0.0, |raw, _| unit.step(raw, omega));
        unit.thickness(f64::from(unit.word(raw)))
    }

    fn add(format: Format) -> Unit {
        Unit { blend: Blend::Add, format }
    }

    fn over(format: Format) -> Unit {
        Unit { blend: Blend::Over, format }
    }

    #[test]
    fn bytes_clip_at_one_and_scaled_bytes_at_256() {
        assert_eq!(after(add(Format::Unorm8), 0.69, 2), 1.0);
        assert_eq!(after(add(Format::Unorm8), 0.69, 1000), 1.0);
        let floor = (-after(add(Format::Unorm8Scaled), 0.69, 1000)).exp();
        assert!((floor - 1.0 / 256.0).abs() < 1e-8);
        // Not saturated before: eight surfaces of 0.69 leave T = 0.004 > 1/256.
        let eight = after(add(Format::Unorm8Scaled), 0.69, 8);
        assert!((eight - 5.52).abs() < 8.0 * SCALE / 510.0, "{eight}");
        // What rounds to nothing adds nothing.
        assert_eq!(after(add(Format::Unorm8), 0.0019, 1000), 0.0);
        assert_eq!(after(add(Format::Unorm8), 1.0 / 255.0, 255), 1.0);
    }

    #[test]
    fn halves_stall_and_overcount() {
        // At 4 a unit in the last place is 1/256: 0.001 is less than half of it.
        assert_eq!(after(add(Format::F16), 0.001, 100_000), 4.0);
        // From 1024 on units are 1, and 0.69 counts as one; from 2048 on they are 2 and it stalls.
        assert_eq!(after(add(Format::F16), 0.69, 100_000), 2048.0);
        let raw = add(Format::F16).step(1024.0, 0.69);
        assert_eq!(raw, 1025.0);
        assert_eq!(after(add(Format::F16), 1e6, 1), MOST_THICKNESS);
    }

    #[test]
    fn floats_stall_at_two_to_the_24_surfaces() {
        let limit = 16_777_216.0;
        assert_eq!(add(Format::F32).step(0.5 * limit, 0.5), 0.5 * limit);
        assert!(add(Format::F32).step(0.49 * limit, 0.5) > 0.49 * limit);
    }

    #[test]
    fn fixed_point_is_exact_in_any_order_and_clips_at_4096() {
        let unit = add(Format::Fixed);
        assert!((after(unit, 0.001, 100_000) - 100_000.0 * (1049.0 / FIXED)).abs() < 1e-5);
        assert!((after(unit, 1.0, 5000) - 4096.0).abs() < 1e-3);
        let values = [0.3f32, 0.001, 7.0, 1e-6, 0.69];
        let forward = values.iter().fold(0.0, |raw, &w| unit.step(raw, w));
        let backward = values.iter().rev().fold(0.0, |raw, &w| unit.step(raw, w));
        assert_eq!(forward, backward);
        assert!(unit.is_exact() && !add(Format::F16).is_exact());
    }

    #[test]
    fn over_is_the_product_and_never_saturates_before_its_clamp() {
        for count in 1..=6 {
            let expected = f64::from(count) * 0.69;
            assert!((after(over(Format::F32), 0.69, count) - expected).abs() < 1e-4);
        }
        let most = -(1.0 - MOST).ln();
        assert_eq!(after(over(Format::F32), 5.0, 10), most);
        // In bytes: within one step of 1 - T per surface.
        let t = (-after(over(Format::Unorm8), 0.3, 10)).exp();
        assert!((t - (-3.0f64).exp()).abs() <= 10.0 / 255.0, "{t}");
    }

    #[test]
    fn states_of_colour_and_alpha_darken_channels_they_should_leave() {
        let near = |a: f64, b: f64| (a - b).abs() < 1e-6;
        let mask = [false, false, true, true];
        for blend in [Blend::Alpha, Blend::Premultiplied, Blend::Over] {
            let unit = Unit { blend, format: Format::F32 };
            let mut raw = [0.0; 4];
            unit.step_group(&mut raw, 1.0, [true; 4]);
            let first = raw;
            unit.step_group(&mut raw, 1.0, mask);
            let alpha = 1.0 - (-1.0f64).exp();
            let product = 1.0 - (1.0 - alpha) * (1.0 - alpha);
            assert!(near(raw[3], product), "{blend:?}: alpha is right in every state");
            if blend == Blend::Over {
                assert!(raw[0] == first[0] && near(raw[2], product));
            } else {
                assert!(raw[0] < 0.5 * first[0], "{blend:?} leaves {raw:?}");
            }
        }
    }
}
