//! Errors of sets and multisets of identifiers.

use std::cmp::Ordering;

/// How a found multiset differs from the true one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SetErrors {
    /// Elements of the truth.
    pub expected: usize,
    /// Elements found.
    pub found: usize,
    /// Elements of the truth that were not found (false culls).
    pub missing: usize,
    /// Elements found that are not in the truth, or once too often.
    pub extra: usize,
}

impl SetErrors {
    /// Whether both are equal.
    pub fn is_exact(&self) -> bool {
        self.missing == 0 && self.extra == 0
    }
}

/// Compares two multisets in any order: an element that occurs twice must be found twice.
pub fn compare<T: Ord + Copy>(found: &[T], truth: &[T]) -> SetErrors {
    let (mut a, mut b) = (found.to_vec(), truth.to_vec());
    a.sort_unstable();
    b.sort_unstable();
    let mut errors = SetErrors { expected: b.len(), found: a.len(), ..SetErrors::default() };
    let (mut i, mut j) = (0, 0);
    while let (Some(x), Some(y)) = (a.get(i), b.get(j)) {
        match x.cmp(y) {
            Ordering::Equal => (i, j) = (i + 1, j + 1),
            Ordering::Less => {
                errors.extra += 1;
                i += 1;
            }
            Ordering::Greater => {
                errors.missing += 1;
                j += 1;
            }
        }
    }
    errors.extra += a.len() - i;
    errors.missing += b.len() - j;
    errors
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::test_config::config;

    #[test]
    fn multiplicity_counts_and_order_does_not() {
        let errors = compare(&[3, 1, 1, 9], &[1, 2, 3, 3]);
        assert_eq!(errors, SetErrors { expected: 4, found: 4, missing: 2, extra: 2 });
        assert!(compare(&[2, 1, 2], &[2, 2, 1]).is_exact());
        assert!(!compare(&[2, 1], &[2, 2, 1]).is_exact());
    }

    #[test]
    fn empty_sets() {
        assert!(compare::<u32>(&[], &[]).is_exact());
        assert_eq!(compare(&[], &[7]).missing, 1);
        assert_eq!(compare(&[7], &[]).extra, 1);
    }

    proptest! {
        #![proptest_config(config())]

        #[test]
        fn removing_and_adding_is_counted(
            truth in prop::collection::vec(0..50_u32, 1..100),
            removed in 0..100_usize,
            added in prop::collection::vec(50..60_u32, 0..20),
        ) {
            let removed = removed.min(truth.len());
            let mut found = truth[removed..].to_vec();
            found.extend(&added);
            let errors = compare(&found, &truth);
            prop_assert_eq!((errors.missing, errors.extra), (removed, added.len()));
        }
    }
}
