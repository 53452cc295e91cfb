//! Hidden nodes that are asked together.
//!
//! Based on: Mattausch, Bittner, Wimmer 2008 (`mattausch2008`), section 4.2: a node hidden in the
//! last n visits stays hidden with probability p = 0.99 - 0.7 e^-n; of nodes by falling p, a group
//! M is grown while V(M) = |M| / (1 + (1 - Π p) |M|), queries saved by queries expected, rises.
//!
//! Deviations: V of a single node is 1, as it is never asked again. (By the formula it is less, so
//! that even two nodes that will surely show would be grouped.) n is 0 for a node that the last
//! frame did not visit: nothing is known of it.

/// Probability that a node hidden in the last `hidden` visits stays so.
fn keep(hidden: u32) -> f64 {
    0.99 - 0.7 * (-f64::from(hidden)).exp()
}

/// Cuts nodes with `hidden` visits each, in falling order, into groups: gives the length of the
/// first, at least 1 unless there are none.
pub(super) fn first_group(hidden: impl Iterator<Item = u32>) -> usize {
    let (mut size, mut value, mut all_stay) = (0, 0.0, 1.0);
    for hidden in hidden {
        all_stay *= keep(hidden);
        let members = size as f64 + 1.0;
        let next = if size == 0 { 1.0 } else { members / (1.0 + (1.0 - all_stay) * members) };
        if next <= value {
            break;
        }
        (size, value) = (size + 1, next);
    }
    size
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probabilities_rise_from_29_to_99_in_a_hundred() {
        assert!((keep(0) - 0.29).abs() < 1e-12);
        assert!((0..100).all(|n| keep(n) <= keep(n + 1)));
        assert!((keep(u32::MAX) - 0.99).abs() < 1e-12);
    }

    #[test]
    fn groups_hold_as_many_as_are_worth_it() {
        assert_eq!(first_group(std::iter::empty()), 0);
        // Of nodes that are likely to show, or that nothing is known of, none is grouped.
        assert_eq!(first_group(std::iter::repeat_n(0, 50)), 1);
        // 1 - 0.99^m falls behind: m / (1 + (1 - 0.99^m) m) is 5.112, 5.113 and 5.077 at 10, 11 and 12.
        assert_eq!(first_group(std::iter::repeat_n(100, 50)), 11);
        // 2 / (1 + 2 (1 - 0.7325²)) = 1.04, and 3 / (1 + 3 (1 - 0.7325³)) = 1.07, then 1.04.
        assert_eq!(first_group(std::iter::repeat_n(1, 50)), 3);
        // One that will show spoils the group that it would join.
        assert_eq!(first_group([100, 100, 100, 0].into_iter()), 3);
    }
}
