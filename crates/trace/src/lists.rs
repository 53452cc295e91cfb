//! Lists of lists in one array, as maps and images have them, and where their rays go.

use std::ops::Range;

/// Coordinate 0..=1 of the middle of texel or pixel `i` of `n`.
pub(crate) fn centre(i: u32, n: u32) -> f64 {
    (f64::from(i) + 0.5) / f64::from(n)
}

/// Where each list starts, and at last where they end, from their lengths.
pub(crate) fn starts(lengths: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut end = 0;
    let ends = lengths.map(|length| {
        end += length;
        end
    });
    std::iter::once(0).chain(ends).collect()
}

/// Where list `index` lies; empty where there is none.
pub(crate) fn range(starts: &[u32], index: usize) -> Range<usize> {
    match (starts.get(index), starts.get(index + 1)) {
        (Some(&start), Some(&end)) => start as usize..end as usize,
        _ => 0..0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_lie_one_after_the_other() {
        assert_eq!(starts([3, 0, 2].into_iter()), [0, 3, 3, 5]);
        assert_eq!(starts(std::iter::empty()), [0]);
        let starts = starts([3, 0, 2].into_iter());
        assert_eq!([0, 1, 2, 3].map(|i| range(&starts, i)), [0..3, 3..3, 3..5, 0..0]);
        assert_eq!((centre(0, 4), centre(3, 4)), (0.125, 0.875));
    }
}
