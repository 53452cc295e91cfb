//! A bar of progress: how much is done is legible without colour.

/// `width` columns of which the first `done / total` are full; `width` dots if nothing is known.
pub fn bar(done: usize, total: usize, width: usize) -> String {
    if total == 0 {
        return "·".repeat(width);
    }
    // Full only once everything is done.
    let full = (done.min(total) as u128 * width as u128 / total as u128) as usize;
    "█".repeat(full) + &"░".repeat(width - full)
}

/// A percentage, 100 only once everything is done.
pub fn percent(done: usize, total: usize) -> Option<usize> {
    (total > 0).then(|| (done.min(total) as u128 * 100 / total as u128) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_is_full_only_at_the_end() {
        assert_eq!(bar(0, 4, 4), "░░░░");
        assert_eq!(bar(2, 4, 4), "██░░");
        assert_eq!(bar(999, 1000, 4), "███░");
        assert_eq!(bar(9, 4, 4), "████");
        assert_eq!(bar(1, 0, 3), "···");
        assert_eq!(bar(usize::MAX, usize::MAX, 2), "██");
        assert_eq!((percent(999, 1000), percent(1, 1), percent(1, 0)), (Some(99), Some(100), None));
    }
}
