//! Numbers in few bytes, exactly: most errors and counters are small whole numbers.

/// Appends a number: a whole one below 2^53 as 7 bits a byte, another as 4 bytes where a single
/// float holds it, else as 8.
pub(crate) fn push(bytes: &mut Vec<u8>, value: f64) {
    // 2^53 - 1, shifted by the mark, still fits; minus zero is no whole number here.
    if value.fract() == 0.0 && value < 9_007_199_254_740_992.0 && value.is_sign_positive() {
        let mut rest = (value as u64) << 1;
        while rest >= 0x80 {
            bytes.push(rest as u8 | 0x80);
            rest >>= 7;
        }
        bytes.push(rest as u8);
    } else if f64::from(value as f32).to_bits() == value.to_bits() {
        bytes.push(1);
        bytes.extend((value as f32).to_le_bytes());
    } else {
        bytes.push(3);
        bytes.extend(value.to_le_bytes());
    }
}

/// The number at position `at` of those that begin here; none if the bytes end before.
pub(crate) fn nth(mut bytes: &[u8], at: usize) -> Option<f64> {
    for _ in 0..at {
        bytes = next(bytes)?.1;
    }
    next(bytes).map(|(value, _)| value)
}

fn next(bytes: &[u8]) -> Option<(f64, &[u8])> {
    match bytes.first()? {
        1 => {
            let (value, rest) = bytes.get(1..)?.split_first_chunk()?;
            Some((f64::from(f32::from_le_bytes(*value)), rest))
        }
        3 => {
            let (value, rest) = bytes.get(1..)?.split_first_chunk()?;
            Some((f64::from_le_bytes(*value), rest))
        }
        _ => {
            let last = bytes.iter().take(8).position(|byte| byte & 0x80 == 0)?;
            let (number, rest) = bytes.split_at(last + 1);
            let value = number.iter().rev().fold(0_u64, |sum, b| sum << 7 | u64::from(b & 0x7f));
            Some(((value >> 1) as f64, rest))
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::fixtures::config;

    fn check(values: &[f64]) {
        let mut bytes = Vec::new();
        values.iter().for_each(|&v| push(&mut bytes, v));
        for (i, value) in values.iter().enumerate() {
            assert_eq!(nth(&bytes, i).map(f64::to_bits), Some(value.to_bits()), "{value}");
        }
        assert_eq!(nth(&bytes, values.len()), None);
    }

    #[test]
    fn awkward_numbers_come_back_bit_for_bit_and_small_ones_are_short() {
        let most = 9_007_199_254_740_991.0;
        check(&[0.0, -0.0, 1.0, 63.0, 64.0, 127.0, most, most + 1.0, most * 4.0, 0.5, 0.1, -1.0]);
        check(&[f64::NAN, f64::INFINITY, -f64::INFINITY, f64::MIN_POSITIVE, f64::MAX, 5e-324]);
        check(&[u64::MAX as f64, f64::from(f32::MAX), 1e-45]);
        for (value, length) in [(0.0, 1), (63.0, 1), (64.0, 2), (0.5, 5), (0.1, 9), (most, 8)] {
            let mut bytes = Vec::new();
            push(&mut bytes, value);
            assert_eq!(bytes.len(), length, "{value}");
        }
    }

    proptest! {
        #![proptest_config(config())]

        #[test]
        fn every_number_comes_back(
            bits in prop::collection::vec(any::<u64>(), 0..20),
            counts in prop::collection::vec(any::<u64>(), 0..20),
            shift in 0..64_u32,
        ) {
            let floats = bits.iter().map(|&b| f64::from_bits(b)).filter(|v| !v.is_nan());
            check(&floats.chain(counts.iter().map(|c| (c >> shift) as f64)).collect::<Vec<_>>());
        }
    }
}
