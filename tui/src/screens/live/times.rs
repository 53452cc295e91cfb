//! Times of the last frames.

use std::collections::VecDeque;

/// Frames that are kept.
const WINDOW: usize = 256;

/// The times of one setting.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Times {
    ns: VecDeque<u64>,
    /// `gpu` or `wall`; empty without a frame.
    pub clock: String,
}

impl Times {
    /// Adds a frame; a frame by another clock begins anew.
    pub fn add(&mut self, ns: u64, clock: &str) {
        if self.clock != clock {
            self.ns.clear();
            self.clock = clock.into();
        }
        if self.ns.len() == WINDOW {
            self.ns.pop_front();
        }
        self.ns.push_back(ns);
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.ns.len()
    }

    /// The least time that a share `q` of the frames does not exceed.
    pub fn quantile(&self, q: f64) -> Option<u64> {
        let mut sorted: Vec<u64> = self.ns.iter().copied().collect();
        sorted.sort_unstable();
        let rank = (q * sorted.len() as f64).ceil() as usize;
        sorted.get(rank.clamp(1, sorted.len().max(1)) - 1).copied()
    }

    /// The last `columns` frames as bars from 0 to the slowest of them.
    pub fn sparkline(&self, columns: usize) -> String {
        const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
        let last = self.ns.iter().skip(self.ns.len().saturating_sub(columns));
        let most = last.clone().max().copied().unwrap_or_default().max(1);
        let bar = |ns: &u64| BARS[(u128::from(*ns) * 7 / u128::from(most)) as usize];
        last.map(bar).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_hand() {
        let mut times = Times::default();
        assert_eq!(times.quantile(0.5), None);
        assert_eq!(times.sparkline(9), "");
        for ns in 1..=100 {
            times.add(101 - ns, "wall");
        }
        assert_eq!((times.quantile(0.5), times.quantile(0.99)), (Some(50), Some(99)));
        assert_eq!((times.quantile(0.0), times.quantile(1.0)), (Some(1), Some(100)));
    }

    #[test]
    fn only_the_last_frames_of_one_clock_count() {
        let mut times = Times::default();
        for ns in 0..1000 {
            times.add(ns, "wall");
        }
        assert_eq!((times.count(), times.quantile(0.0)), (WINDOW, Some(744)));
        times.add(7, "gpu");
        assert_eq!((times.count(), times.clock.as_str()), (1, "gpu"));
    }

    #[test]
    fn bars_stand_on_zero() {
        let mut times = Times::default();
        for ns in [0, 50, 100, u64::MAX] {
            times.add(ns, "wall");
        }
        assert_eq!(times.sparkline(3), "▁▁█");
        times.add(u64::MAX / 2, "wall");
        assert_eq!(times.sparkline(2), "█▄");
    }
}
