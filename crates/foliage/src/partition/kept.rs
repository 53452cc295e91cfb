//! Factors, their quantisation, and how many leaves of a cell they keep.
//!
//! Based on: J. Gumbau Portalés, PhD thesis, Universitat Jaume I, 2011, §3.4.2: the first
//! `n_leavesCell * LoD_cell_factor` leaves of a cell are copied.
//!
//! Deviations: the thesis does not say how the product is rounded. Here it is rounded to nearest,
//! and the factor is a 16-bit fraction, so that CPU and GPU agree to the bit. A tie cannot occur:
//! both denominators are odd.

use super::PartitionError;

/// The quantised factor of "keep everything".
pub const FULL: u32 = 65_535;

/// Largest cell whose kept count uses all 16 bits of the factor, leaves.
pub const FINE_CELL: u32 = 65_535;

/// The 12-bit fraction of "keep everything", used by larger cells.
const FULL_COARSE: u32 = 4_095;

/// Largest cell of all, leaves: the largest `n` with `n * 4095 + 2047 < 2^32`.
pub const MAX_CELL: u32 = (u32::MAX - FULL_COARSE / 2) / FULL_COARSE;

/// Quantises a factor in `0..=1` to 16 bits: `round(65535 f)`.
///
/// The product is exact in f64 (24 + 16 bits), so only the rounding to an integer rounds. Values
/// outside the range saturate and NaN gives 0; [`quantise_into`] refuses both.
#[must_use]
pub fn quantise(factor: f32) -> u32 {
    // A float-to-integer cast saturates and takes NaN to 0.
    ((f64::from(factor) * f64::from(FULL)).round() as u32).min(FULL)
}

/// Quantises one factor per cell into `out`, which is cleared first and keeps its capacity.
///
/// # Errors
/// [`PartitionError::Factor`] names the first cell whose factor is NaN or outside `0..=1`.
pub fn quantise_into(factors: &[f32], out: &mut Vec<u32>) -> Result<(), PartitionError> {
    out.clear();
    for (cell, &value) in factors.iter().enumerate() {
        if !(0.0..=1.0).contains(&value) {
            return Err(PartitionError::Factor { cell, value });
        }
        out.push(quantise(value));
    }
    Ok(())
}

/// As [`quantise_into`], into a new vector.
///
/// # Errors
/// [`PartitionError::Factor`] names the first cell whose factor is NaN or outside `0..=1`.
pub fn quantise_all(factors: &[f32]) -> Result<Vec<u32>, PartitionError> {
    let mut out = Vec::with_capacity(factors.len());
    quantise_into(factors, &mut out)?;
    Ok(out)
}

/// Leaves kept of a cell of `n` leaves at quantised factor `q`: 0 at 0, `n` at [`FULL`],
/// non-decreasing in between.
///
/// `n` is at most [`MAX_CELL`] and `q` at most [`FULL`]; the extractors check both. Beyond them
/// the result means nothing, but does not panic.
///
/// Why `u32` is enough:
/// - `n <= 65535`: `n q + 32767 <= 65535^2 + 32767 = 4_294_868_992 < 2^32 = 4_294_967_296`.
/// - larger cells: `q12 = (q * 4095 + 32767) / 65535 <= 4095`, where
///   `65535 * 4095 + 32767 = 268_398_592`; then `n q12 + 2047 <= 1_048_831 * 4095 + 2047 =
///   4_294_964_992 < 2^32`.
///
/// `q12` is a monotone function of `q` with 0 to 0 and 65535 to 4095, so both branches are
/// monotone; a cell never changes branch, because `n` is fixed.
#[must_use]
#[inline]
pub fn kept(n: u32, q: u32) -> u32 {
    if n <= FINE_CELL {
        return n.wrapping_mul(q).wrapping_add(FULL / 2) / FULL;
    }
    let coarse = q.wrapping_mul(FULL_COARSE).wrapping_add(FULL / 2) / FULL;
    n.wrapping_mul(coarse).wrapping_add(FULL_COARSE / 2) / FULL_COARSE
}

/// Checks that there is one quantised factor for each of `cells` cells, none above [`FULL`].
///
/// # Errors
/// [`PartitionError::FactorCount`] or [`PartitionError::QuantisedFactor`].
pub fn check_factors(cells: usize, factors_q: &[u32]) -> Result<(), PartitionError> {
    if factors_q.len() != cells {
        return Err(PartitionError::FactorCount { found: factors_q.len(), expected: cells });
    }
    match factors_q.iter().position(|&q| q > FULL) {
        Some(cell) => Err(PartitionError::QuantisedFactor { cell, value: factors_q[cell] }),
        None => Ok(()),
    }
}

/// [`kept`] computed another way, in 64 bits, for [`super::validate`]: the nearest integer to
/// `n q / d` is `floor((2 n q + d) / 2 d)`.
pub(super) fn kept_oracle(n: u32, q: u32) -> u32 {
    let nearest = |n: u64, q: u64, d: u64| (2 * n * q + d) / (2 * d);
    let (n, q) = (u64::from(n), u64::from(q));
    let value = if n <= 65_535 {
        nearest(n, q, 65_535)
    } else {
        nearest(n, nearest(4_095, q, 65_535), 4_095)
    };
    value.min(u64::from(u32::MAX)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantise_rounds_to_the_nearest_of_65536_levels() {
        assert_eq!(quantise(0.0), 0);
        assert_eq!(quantise(1.0), 65_535);
        assert_eq!(quantise(0.5), 32_768); // 32767.5, away from zero
        assert_eq!(quantise(1.0 / 65_535.0), 1);
        assert_eq!(quantise(0.49 / 65_535.0), 0);
        assert_eq!(quantise(0.51 / 65_535.0), 1);
        // The largest f32 below 1 and the smallest above 0.
        assert_eq!(quantise(1.0 - f32::EPSILON / 2.0), 65_535);
        assert_eq!(quantise(f32::from_bits(1)), 0);
        // Every level comes back.
        for q in 0..=FULL {
            assert_eq!(quantise((f64::from(q) / 65_535.0) as f32), q);
        }
    }

    #[test]
    fn bad_factors_are_refused_naming_the_cell() {
        for bad in [f32::NAN, f32::INFINITY, -f32::INFINITY, -1e-30, 1.000_000_1, 1e30] {
            match quantise_all(&[0.0, 1.0, bad, f32::NAN]) {
                Err(PartitionError::Factor { cell: 2, value }) => {
                    assert_eq!(value.to_bits(), bad.to_bits());
                }
                other => panic!("{bad}: {other:?}"),
            }
        }
        assert_eq!(quantise_all(&[-0.0, 1.0]).unwrap(), [0, 65_535]);
        assert!(matches!(
            check_factors(3, &[0, 65_536, 0]),
            Err(PartitionError::QuantisedFactor { cell: 1, value: 65_536 })
        ));
        assert!(matches!(
            check_factors(3, &[0, 0]),
            Err(PartitionError::FactorCount { found: 2, expected: 3 })
        ));
    }

    #[test]
    fn kept_by_hand() {
        assert_eq!(kept(0, FULL), 0);
        assert_eq!(kept(1, 32_767), 0); // 0.49999
        assert_eq!(kept(1, 32_768), 1); // 0.50001
        assert_eq!(kept(10, 32_768), 5);
        assert_eq!(kept(3, 21_845), 1); // exactly 1
        assert_eq!(kept(100, 6_554), 10);
        assert_eq!(kept(65_535, 12_345), 12_345); // the branch's last size is the identity
        // 65536 leaves, q = 12345: q12 = round(771.38) = 771, u = round(65536 * 771 / 4095)
        // = round(12339.01).
        assert_eq!(kept(65_536, 12_345), 12_339);
        assert_eq!(kept(1_000_000, 32_768), 500_122); // q12 = 2048 (2047.53): 500122.1
    }

    #[test]
    fn the_largest_cell_is_the_last_that_cannot_overflow() {
        let top = |n: u64| n * 4_095 + 2_047;
        assert_eq!(MAX_CELL, 1_048_831);
        assert!(top(u64::from(MAX_CELL)) < 1 << 32);
        assert!(top(u64::from(MAX_CELL) + 1) >= 1 << 32);
        // The border between the branches is a choice: one leaf more would still fit.
        let top = |n: u64| n * u64::from(FULL) + 32_767;
        assert!(top(u64::from(FINE_CELL) + 1) < 1 << 32);
        assert!(top(u64::from(FINE_CELL) + 2) >= 1 << 32);
    }

    /// Every size near a border and a spread of others against 64-bit and f64 arithmetic.
    #[test]
    fn kept_equals_64_bit_and_float_arithmetic() {
        let sizes = [0, 1, 2, 3, 30, 511, 512, 513, 4_095, 65_534, 65_535];
        let large = [65_536, 65_537, 131_042, 1_000_000, MAX_CELL - 1, MAX_CELL];
        for n in sizes.into_iter().chain(large) {
            let mut previous = 0;
            for q in 0..=FULL {
                let u = kept(n, q);
                assert_eq!(u, kept_oracle(n, q), "n {n} q {q}");
                let exact = if n <= FINE_CELL {
                    f64::from(n) * f64::from(q) / 65_535.0
                } else {
                    let coarse = (f64::from(q) * 4_095.0 / 65_535.0).round();
                    f64::from(n) * coarse / 4_095.0
                };
                assert_eq!(f64::from(u), exact.round(), "n {n} q {q}");
                assert!(u >= previous && u <= n, "n {n} q {q}");
                previous = u;
            }
            assert_eq!((kept(n, 0), kept(n, FULL)), (0, n));
        }
    }

    #[test]
    fn out_of_range_arguments_do_not_panic() {
        let _ = kept(u32::MAX, u32::MAX);
        let _ = kept(5, u32::MAX);
        let _ = kept_oracle(u32::MAX, u32::MAX);
        assert_eq!((quantise(f32::NAN), quantise(-3.0), quantise(9.0)), (0, 0, FULL));
    }
}
