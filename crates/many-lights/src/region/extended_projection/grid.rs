//! A stretch of a plane in even parts.

use std::ops::Range;

/// So many parts from `ends[0]` to `ends[1]`, metres. All that is asked of it refers to the same edges,
/// so that rounding them moves them for occluders and occludees alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grid {
    ends: [f64; 2],
    parts: usize,
}

impl Grid {
    /// `ends` are finite and in order, `parts` is at least 1.
    pub fn new(ends: [f64; 2], parts: usize) -> Self {
        Self { ends, parts }
    }

    /// Edge `index` of 0..=parts; they never fall.
    pub fn edge(&self, index: usize) -> f64 {
        let [first, last] = self.ends;
        let share = index as f64 / self.parts as f64;
        ((1.0 - share) * first + share * last).clamp(first, last)
    }

    /// The parts that lie wholly between `from` and `to`, which may be infinite.
    pub fn within(&self, [from, to]: [f64; 2]) -> Range<usize> {
        let mut first = self.guess(from);
        while first > 0 && self.edge(first - 1) >= from {
            first -= 1;
        }
        while first < self.parts && self.edge(first) < from {
            first += 1;
        }
        let mut end = self.guess(to);
        while end < self.parts && self.edge(end + 1) <= to {
            end += 1;
        }
        while end > first && self.edge(end) > to {
            end -= 1;
        }
        first..end.max(first)
    }

    /// Parts that together hold everything from `from` to `to`, at least one; `None` where that
    /// reaches beyond the ends.
    pub fn around(&self, [from, to]: [f64; 2]) -> Option<Range<usize>> {
        if !(from >= self.ends[0] && to <= self.ends[1] && from <= to) {
            return None;
        }
        let mut first = self.guess(from).min(self.parts - 1);
        while first > 0 && self.edge(first) > from {
            first -= 1;
        }
        while first + 1 < self.parts && self.edge(first + 1) <= from {
            first += 1;
        }
        let mut end = self.guess(to).max(first + 1);
        while end < self.parts && self.edge(end) < to {
            end += 1;
        }
        while end > first + 1 && self.edge(end - 1) >= to {
            end -= 1;
        }
        Some(first..end)
    }

    /// The same of what lies between the ends; `None` where nothing does.
    pub fn around_clipped(&self, [from, to]: [f64; 2]) -> Option<Range<usize>> {
        self.around([from.max(self.ends[0]), to.min(self.ends[1])])
    }

    /// An edge close to a place, in 0..=parts.
    fn guess(&self, at: f64) -> usize {
        let [first, last] = self.ends;
        let share = (at - first) / (last - first);
        // Also of NaN and of infinities: it is only where the search begins.
        (share * self.parts as f64).clamp(0.0, self.parts as f64) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn parts_within_lie_within_and_parts_around_hold_all(
            (first, width) in (-1e6_f64..1e6, 1e-6_f64..1e6),
            parts in 1_usize..70,
            (a, b) in (-0.2_f64..1.2, -0.2_f64..1.2),
            exact in any::<bool>(),
        ) {
            let grid = Grid::new([first, first + width], parts);
            let at = |share: f64| if exact {
                grid.edge((share.clamp(0.0, 1.0) * parts as f64) as usize)
            } else {
                first + share * width
            };
            let span = [at(a.min(b)), at(a.max(b))];
            let within = grid.within(span);
            prop_assert!(within.end <= parts);
            if !within.is_empty() {
                prop_assert!(grid.edge(within.start) >= span[0] && grid.edge(within.end) <= span[1]);
            }
            // And no part more would.
            for part in 0..parts {
                let fits = grid.edge(part) >= span[0] && grid.edge(part + 1) <= span[1];
                prop_assert!(!fits || within.contains(&part) || grid.edge(part) == grid.edge(part + 1));
            }
            match grid.around(span) {
                Some(around) => {
                    prop_assert!(!around.is_empty() && around.end <= parts);
                    prop_assert!(grid.edge(around.start) <= span[0] && grid.edge(around.end) >= span[1]);
                }
                None => prop_assert!(span[0] < grid.edge(0) || span[1] > grid.edge(parts)),
            }
        }
    }

    #[test]
    fn what_touches_an_edge_needs_no_part_beyond_it() {
        let grid = Grid::new([0.0, 4.0], 4);
        assert_eq!(grid.around([1.0, 3.0]), Some(1..3));
        assert_eq!(grid.around([1.0, 3.1]), Some(1..4));
        assert_eq!(grid.around([4.0, 4.0]), Some(3..4));
        assert_eq!(grid.around([0.0, 4.1]), None);
        assert_eq!(grid.around_clipped([-9.0, 0.5]), Some(0..1));
        assert_eq!(grid.around_clipped([5.0, 6.0]), None);
        assert_eq!(grid.within([f64::NEG_INFINITY, 2.5]), 0..2);
        assert_eq!(grid.within([f64::NEG_INFINITY, f64::INFINITY]), 0..4);
        assert_eq!(grid.within([2.1, 2.9]), 3..3);
    }
}
