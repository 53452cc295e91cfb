//! How far a picture may be from its reference.

use super::Picture;
use dapple_metrics::flip_mean;
use std::fmt;

/// What a picture must keep, all three at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Name, for messages.
    pub name: &'static str,
    /// Difference that any pixel may have, codes of 255.
    pub codes: u8,
    /// Share of pixels that may differ by more: those on an edge, where one texel or ray more or
    /// less decides.
    pub edges: f64,
    /// Mean FLIP, 67 pixels a degree. Catches what spreads over the picture below `codes`.
    pub flip: f64,
}

/// Integers: no pixel may differ.
pub const EXACT: Tolerance = Tolerance { name: "exact", codes: 0, edges: 0.0, flip: 0.0 };

/// The same arithmetic in other libraries' last bits.
pub const LSB: Tolerance = Tolerance { name: "lsb", codes: 1, edges: 0.001, flip: 0.001 };

/// A graphics adapter against the processor's picture: its rasteriser moves edges of the depth map
/// by less than a texel.
pub const RASTER: Tolerance = Tolerance { name: "raster", codes: 2, edges: 0.01, flip: 0.005 };

/// What a comparison found.
#[derive(Clone, Debug, PartialEq)]
pub enum Deviation {
    /// Of one size.
    Pixels {
        /// Largest difference, codes.
        most: u8,
        /// Share of pixels beyond the tolerance's codes.
        beyond: f64,
        /// Mean FLIP.
        flip: f64,
    },
    /// Of different sizes: (columns, rows) expected and found.
    Size([u32; 2], [u32; 2]),
    /// The reference is no picture.
    Unreadable(String),
}

impl Deviation {
    /// Whether it is within `tolerance`.
    pub fn is_within(&self, tolerance: Tolerance) -> bool {
        match self {
            // Written so that NaN is not within.
            Self::Pixels { beyond, flip, .. } => {
                *beyond <= tolerance.edges && *flip <= tolerance.flip
            }
            Self::Size(..) | Self::Unreadable(_) => false,
        }
    }
}

impl fmt::Display for Deviation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pixels { most, beyond, flip } => write!(
                f,
                "largest difference {most} of 255, {:.3} % of pixels beyond the tolerance, mean \
                 FLIP {flip:.5}",
                100.0 * beyond
            ),
            Self::Size(expected, actual) => write!(f, "size {actual:?} in place of {expected:?}"),
            Self::Unreadable(why) => write!(f, "the reference cannot be read: {why}"),
        }
    }
}

/// Compares a picture with its reference.
///
/// # Panics
/// For a picture without pixels.
pub fn compare(expected: &Picture, actual: &Picture, tolerance: Tolerance) -> Deviation {
    let size = |p: &Picture| [p.width, p.height];
    if size(expected) != size(actual) {
        return Deviation::Size(size(expected), size(actual));
    }
    let differences = || expected.codes.iter().zip(&actual.codes).map(|(a, b)| a.abs_diff(*b));
    let beyond = differences().filter(|d| *d > tolerance.codes).count();
    let rgb = |p: &Picture| p.codes.iter().flat_map(|c| [*c; 3]).collect::<Vec<_>>();
    let flip = flip_mean(expected.width, expected.height, &rgb(actual), &rgb(expected));
    Deviation::Pixels {
        most: differences().max().unwrap_or(0),
        beyond: beyond as f64 / expected.codes.len() as f64,
        flip: flip.expect("two pictures of one size"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ramp under a dark disc: smooth parts and an edge.
    fn picture() -> Picture {
        let value = |i: u32| {
            let (x, y) = ((i % 40) as f32, (i / 40) as f32);
            let disc = (x - 20.0).hypot(y - 12.0) < 7.0;
            if disc { 0.1 } else { 0.3 + x / 80.0 }
        };
        Picture::from_values(40, 25, &(0..1000).map(value).collect::<Vec<_>>())
    }

    fn passes(actual: &Picture, tolerance: Tolerance) -> bool {
        compare(&picture(), actual, tolerance).is_within(tolerance)
    }

    #[test]
    fn figures_are_those_of_hand() {
        let mut other = picture();
        other.codes[0] += 3;
        other.codes[1] += 2;
        other.codes[999] -= 9;
        let Deviation::Pixels { most, beyond, flip } = compare(&picture(), &other, RASTER) else {
            panic!("a comparison of pixels");
        };
        assert_eq!((most, beyond), (9, 0.002));
        assert!(flip > 0.0 && flip < 0.005, "{flip}");
        assert!(passes(&other, RASTER) && !passes(&other, LSB) && !passes(&other, EXACT));
        assert!(passes(&picture(), EXACT));
    }

    /// Controls: what must not pass.
    #[test]
    fn a_shift_and_a_change_of_brightness_fail_everywhere() {
        for tolerance in [EXACT, LSB, RASTER] {
            assert!(!passes(&picture().shifted(), tolerance), "{}", tolerance.name);
            assert!(!passes(&picture().brightened(0.03), tolerance), "{}", tolerance.name);
            assert!(!passes(&picture().dimmed(0.97), tolerance), "{}", tolerance.name);
        }
    }

    #[test]
    fn a_faint_veil_over_the_whole_picture_fails_by_flip_alone() {
        let mut veiled = picture();
        veiled.codes.iter_mut().for_each(|c| *c += 2);
        let Deviation::Pixels { beyond, flip, .. } = compare(&picture(), &veiled, RASTER) else {
            panic!("a comparison of pixels");
        };
        assert_eq!(beyond, 0.0);
        assert!(flip > RASTER.flip, "{flip}");
    }

    #[test]
    fn other_sizes_and_broken_files_fail() {
        let tall = Picture { width: 25, height: 40, ..picture() };
        assert!(!passes(&tall, RASTER));
        assert!(Picture::from_png(b"what").is_err());
        let png = picture().to_png();
        assert!(Picture::from_png(&png[..png.len() / 2]).is_err());
        assert_eq!(Picture::from_png(&png).unwrap(), picture());
    }
}
